"""Arenas and settings as compiled worlds read them.

An arena is a block of bytes, prepared once: its numbers, walls, corners, waypoints and their tables. The
blocks of all arenas of a batch follow one another, and each world has the place of its own. What all worlds of a
batch share is one record, which is read at run time: other decisions or another noise compile nothing.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation import rule
from khepera_forage.envs.arguments import ArenaPool, Settings, food_odds, timing_of, whole_number
from khepera_forage.envs.layouts import arena_map_of, floor_of, no_room
from khepera_forage.geometry.paths import CELLS, Corner, PathTables, Spot
from khepera_forage.records import array_of, dtype_of
from khepera_forage.sim.arena import MOST_FOODS, Arena
from khepera_forage.sim.compiled.world import constants_dtype, corner_dtype, wall_dtype
from khepera_forage.sim.layout_checks import cable_anchor, check_seen
from khepera_forage.sim.records import constants_of
from khepera_forage.task.arena_map import ArenaMap, Floor
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.placement import arena_number
from khepera_forage.task.states import FoodType

decisions_dtype = np.dtype([(name, "f8") for name in (*Decisions.__dataclass_fields__, "has_gripper")])
"""`task.decisions.DecisionValues`."""
settings_dtype = np.dtype(
    [
        ("constants", constants_dtype),
        ("decisions", decisions_dtype),
        ("odds", "f8", (len(FoodType) - 1,)),  # of food types
        ("limit", "i8"),  # steps after which an episode ends
        ("holes", "i8"),  # of the robot's marker
    ],
    align=True,
)
"""What all worlds of a batch share."""

MOST_ROUNDS = 10**9
"""Largest limit of rounds: counts have 64 bits."""
_COUNTS = ("walls", "corners", "waypoints")
_MAP, _FLOOR, _PATHS = (
    [name for name in kind._fields if name not in ("walls", "paths", *PathTables._fields[8:], "home_x", "home_y")]
    for kind in (ArenaMap, Floor, PathTables)
)
arena_dtype = np.dtype(
    [
        *((name, "i8") for name in _COUNTS),
        *((name, "f8") for name in ("anchor_x", "anchor_y", "map_home_x", "map_home_y")),
        *((name, "f8") for name in ("floor_home_x", "floor_home_y")),
        *((f"map_{name}", "f8") for name in _MAP),
        *((f"floor_{name}", "f8") for name in _FLOOR),
        *((f"paths_{name}", "f8") for name in _PATHS),
    ]
)
"""One arena: counts of walls, corners and waypoints, where cables hang from, and the numbers of `ArenaMap` (pixels),
`Floor` (mm) and `PathTables`."""
_path_corner_dtype, _spot_dtype = dtype_of(Corner), dtype_of(Spot)
_ARENA, _WALL, _POINT, _CORNER, _SPOT = (
    kind.itemsize for kind in (arena_dtype, wall_dtype, corner_dtype, _path_corner_dtype, _spot_dtype)
)


class ArenaRecords(NamedTuple):
    """One arena.

    Attributes:
        numbers: `arena_dtype`, shape (1,).
        walls: `Wall` records in mm.
        map_walls: The same in pixels.
        corners: The corners that point into the floor, mm.
        path_corners: `Corner` records in pixels.
        waypoints: `Spot` records in pixels.
        lengths: Of the paths between waypoints; also the next two, as in `PathTables`.
        home_lengths: Likewise.
        seen: Likewise.
    """

    numbers: Any
    walls: Any
    map_walls: Any
    corners: Any
    path_corners: Any
    waypoints: Any
    lengths: Any
    home_lengths: Any
    seen: Any


@rule
def arena_at(blocks: Any, place: int) -> ArenaRecords:
    """The arena whose block begins at this place."""
    a = place + _ARENA
    numbers = blocks[place:a].view(arena_dtype)
    walls, corners, waypoints = numbers[0].walls, numbers[0].corners, numbers[0].waypoints
    b = a + walls * _WALL
    c = b + walls * _WALL
    d = c + corners * _POINT
    e = d + corners * _CORNER
    f = e + waypoints * _SPOT
    g = f + waypoints * waypoints * 8
    h = g + waypoints * 8
    i = h + waypoints * (CELLS * CELLS + 1)
    return ArenaRecords(
        numbers,
        blocks[a:b].view(wall_dtype),
        blocks[b:c].view(wall_dtype),
        blocks[c:d].view(corner_dtype),
        blocks[d:e].view(_path_corner_dtype),
        blocks[e:f].view(_spot_dtype),
        blocks[f:g].view(np.float64),
        blocks[g:h].view(np.float64),
        blocks[h:i],
    )


@rule
def map_of(arena: ArenaRecords) -> ArenaMap:
    """What a robot knows of the arena."""
    numbers = arena.numbers[0]
    home_x, home_y = numbers.map_home_x, numbers.map_home_y
    return ArenaMap(
        home_x,
        home_y,
        int(numbers.map_home_radius),
        numbers.map_start_x,
        numbers.map_start_y,
        numbers.map_home_opening,
        int(numbers.map_diagonal),
        numbers.map_left,
        numbers.map_bottom,
        numbers.map_right,
        numbers.map_top,
        arena.map_walls,
        PathTables(
            numbers.paths_clearance,
            home_x,
            home_y,
            numbers.paths_berth,
            numbers.paths_left,
            numbers.paths_bottom,
            numbers.paths_columns,
            numbers.paths_rows,
            arena.path_corners,
            arena.waypoints,
            arena.lengths,
            arena.home_lengths,
            arena.seen,
        ),
    )


@rule
def ground_of(arena: ArenaRecords) -> Floor:
    """The floor of the arena, on which everything is placed."""
    numbers = arena.numbers[0]
    return Floor(
        numbers.floor_left,
        numbers.floor_bottom,
        numbers.floor_right,
        numbers.floor_top,
        numbers.floor_home_x,
        numbers.floor_home_y,
        numbers.floor_home_radius,
        arena.walls,
    )


def arena_block(arena: Arena, anchor: tuple[float, float]) -> NDArray[np.uint8]:
    """The bytes of an arena, in which the robots' cables hang from an anchor, mm."""
    map_, floor = arena_map_of(arena), floor_of(arena)
    paths = map_.paths
    numbers = np.zeros(1, arena_dtype)
    numbers["walls"], numbers["corners"] = len(floor.walls), len(paths.corners)
    numbers["waypoints"] = len(paths.waypoints)
    numbers["anchor_x"], numbers["anchor_y"] = anchor
    for prefix, known in (("map", map_), ("floor", floor), ("paths", paths)):
        for name in known._fields:
            if f"{prefix}_{name}" in (arena_dtype.names or ()):
                numbers[f"{prefix}_{name}"] = getattr(known, name)
    parts = (
        numbers,
        _records(floor.walls, wall_dtype),
        _records(map_.walls, wall_dtype),
        _records([corner[:2] for corner in arena.corners], corner_dtype),
        _records(paths.corners, _path_corner_dtype),
        _records(paths.waypoints, _spot_dtype),
        np.array(paths.lengths, np.float64),
        np.array(paths.home_lengths, np.float64),
        np.frombuffer(paths.seen, np.uint8),
        np.zeros(-len(paths.seen) % 8, np.uint8),  # the next block is aligned
    )
    return np.concatenate([part.view(np.uint8) for part in parts])


def _records(rows: Any, kind: np.dtype[Any]) -> NDArray[Any]:
    return np.array(list(map(tuple, rows)), kind)


def settings_record(settings: Settings, foods: int, limit: int, holes: int) -> NDArray[Any]:
    """The settings of worlds with 1 to 16 food objects, as an array of one record; `holes` are of the robot's marker.

    Raises:
        ValueError: An argument out of range.
    """
    whole_number("foods", foods, 1, MOST_FOODS)
    record, (arena, noise, food_types, decisions, model) = np.zeros(1, settings_dtype), settings
    record["constants"] = array_of(constants_of(noise, timing_of(decisions), model))
    record["decisions"] = np.array([tuple(decisions.values(model.has_gripper))], decisions_dtype)  # type: ignore[arg-type]
    record["odds"] = food_odds(food_types, model.has_gripper, arena)
    record["limit"], record["holes"] = whole_number("limit", limit, 1, MOST_ROUNDS), holes
    return record


class PreparedArenas:
    """The arenas of a batch of worlds, each prepared when a world first enters it.

    Args:
        pool: All arenas.

    Attributes:
        blocks: The bytes of all arenas prepared so far, one after the other.
    """

    _MOST_BYTES = 1 << 27
    """Bytes of blocks above which arenas that no world is in are forgotten."""

    def __init__(self, pool: ArenaPool) -> None:
        self._pool = pool
        self._place_of: dict[int, int] = {}
        self._numbers: dict[int, int] = {}
        self.blocks, self._used = np.zeros(1 << 16, np.uint8), 0
        self.places(np.zeros(1, np.int64))

    def arena(self, place: int) -> Arena:
        """The arena whose block is at this place."""
        return self._pool[self._numbers[place]]

    def no_room(self, places: NDArray[np.int64], foods: int) -> ValueError:
        """The error of arenas at these places in one of which no random layout was found."""
        names = sorted({self.arena(place).name for place in places.tolist()})
        return no_room(", ".join(names[:3]) + (", ..." if len(names) > 3 else ""), foods)

    def places(self, numbers: NDArray[Any]) -> NDArray[np.int64]:
        """Places of the arenas with these numbers in the pool. New arenas are prepared.

        Raises:
            ValueError: An arena that is too narrow, or that the camera does not see.
        """
        listed = numbers.tolist()
        for number in sorted(set(listed).difference(self._place_of)):
            arena = self._pool[number]
            check_seen([arena])
            block = arena_block(arena, cable_anchor([arena]))
            end = self._used + len(block)
            if end > len(self.blocks):
                self.blocks = np.concatenate([self.blocks, np.zeros(end, np.uint8)])
            self.blocks[self._used : end] = block
            self._place_of[number], self._numbers[self._used] = self._used, number
            self._used = end
        return np.array([self._place_of[number] for number in listed], np.int64)

    def of_episodes(self, keys: NDArray[np.uint64], episodes: NDArray[np.int64]) -> NDArray[np.int64]:
        """Places of the arenas of an episode of each world, see `arena_number`; new arenas are prepared."""
        if len(self._pool) == 1:
            return np.zeros(len(keys), np.int64)
        return self.places(arena_number(keys, episodes.astype(np.uint64), len(self._pool)))

    def forget(self, places: NDArray[np.int64]) -> NDArray[np.int64]:
        """Forget all arenas but those at these places, if there are many; returns their new places."""
        if self._used < self._MOST_BYTES or len(self._pool) == 1:
            return places
        numbers = np.array([self._numbers[place] for place in places.tolist()], np.int64)
        self._place_of, self._numbers, self._used = {}, {}, 0
        return self.places(numbers)
