"""The arenas of compiled worlds as kernels read them, each prepared when a world first enters it."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.arena_pool import ArenaPool, Arenas
from khepera_forage.envs.arguments import FoodOdds
from khepera_forage.envs.compiled.parameters import TaskParameters, recall_parameters
from khepera_forage.envs.compiled.worlds import Worlds, empty_worlds
from khepera_forage.noise import Noise
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.compiled import records as bodies
from khepera_forage.sim.compiled.near_walls import empty_lists
from khepera_forage.sim.compiled.parameters import Parameters
from khepera_forage.sim.compiled.records import LANES
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.placement import arena_number


class PreparedArenas:
    """The arenas of a batch of worlds.

    With one arena, kernels read its records. With several, they read one array of each kind, in which the records of
    one arena follow those of another; a world has the index of its arena among them.

    Args:
        pool: All arenas.
        prepare: Parameters of one arena, those of all others with other walls.

    Attributes:
        parameters: Of the bodies, in all arenas prepared so far.
        task: Of the task, likewise.
    """

    def __init__(
        self, pool: ArenaPool, prepare: Callable[[Arena], tuple[Parameters, TaskParameters]]
    ) -> None:
        self._pool, self._prepare = pool, prepare
        self.several = len(pool) > 1
        self._numbers: list[int] = []
        self._index_of: dict[int, int] = {}
        self._pieces = _Pieces()
        self.parameters: Parameters
        self.task: TaskParameters
        if self.several:
            self.indices(np.zeros(1, np.int64))
        else:
            self._numbers = [0]
            self.parameters, self.task = prepare(pool[0])

    def __getitem__(self, index: int) -> Arena:
        """The arena with this index among those prepared."""
        return self._pool[self._numbers[index]]

    def indices(self, numbers: NDArray[Any]) -> NDArray[np.int64]:
        """Indices of the arenas with these numbers in the pool. New arenas are prepared.

        Raises:
            ValueError: An arena that is too narrow, or that the camera does not see.
        """
        new = [number for number in np.unique(numbers).tolist() if number not in self._index_of]
        for number in new:
            self._pieces.add(*self._prepare(self._pool[number]))
            self._index_of[number] = len(self._numbers)
            self._numbers.append(number)
        if new:
            self.parameters, self.task = self._pieces.joined()
        return np.array([self._index_of[number] for number in numbers.tolist()], np.int64)

    def next(self, keys: NDArray[np.uint64], episodes: NDArray[np.int64]) -> NDArray[np.int64]:
        """Indices of the arenas of episodes, see `task.placement.arena_number`; new arenas are prepared.

        Args:
            keys: Of worlds.
            episodes: Number of an episode of each.
        """
        return self.indices(arena_number(keys, episodes.astype(np.uint64), len(self._pool)))

    def with_room(self, worlds: Worlds) -> Worlds:
        """Worlds with room for all arenas prepared so far: these ones, or a copy if they have too little."""
        near, lengths, ways = worlds.bodies.near, worlds.food_lengths, worlds.to_waypoints
        present = near.walls.shape[1], near.corners.shape[1], lengths.shape[3]
        if all(size >= most for size, most in zip(present, self._most(), strict=True)):
            return worlds
        larger = self.empty_worlds(len(worlds.tasks), worlds.trackers.shape[1])
        larger.bodies.near.lists["arena"] = near.lists["arena"]  # the lists are made again
        larger.food_lengths[..., : lengths.shape[3]] = lengths
        larger.to_waypoints[..., : lengths.shape[3]] = ways
        return worlds._replace(
            bodies=worlds.bodies._replace(near=larger.bodies.near),
            to_waypoints=larger.to_waypoints,
            food_lengths=larger.food_lengths,
        )

    def empty_worlds(self, blocks: int, lanes: int = LANES) -> Worlds:
        """Records for some blocks of worlds, with room for all arenas prepared so far."""
        foods = self.parameters.foods
        if not self.several:
            return empty_worlds(blocks, foods, len(self.task.waypoints), lanes)
        walls, corners, waypoints = self._most()
        return empty_worlds(blocks, foods, waypoints, lanes, empty_lists(blocks, lanes, walls, corners))

    def _most(self) -> tuple[int, int, int]:
        """Most walls, corners and waypoints of an arena."""
        walls, corners, waypoints = (
            int(self.task.arena[name].max()) for name in ("walls", "corners", "waypoints")
        )
        return walls, corners, waypoints


def recall_arenas(
    arenas: Arenas,
    foods: int,
    limit: int,
    noise: Noise | str | None,
    food_types: FoodOdds,
    decisions: Decisions,
    wheel_speed: float = 1.0,
) -> PreparedArenas:
    """The arenas of recalls; arguments and errors as for `recall_parameters`."""
    prepare = partial(
        recall_parameters,
        foods=foods,
        limit=limit,
        noise=noise,
        food_types=food_types,
        decisions=decisions,
        wheel_speed=wheel_speed,
    )
    return PreparedArenas(ArenaPool(arenas, decisions), prepare)


def enter_arenas(worlds: Worlds, here: Any, indices: NDArray[np.int64]) -> None:
    """Move some worlds to other arenas, for their next episodes.

    Args:
        worlds: All of them.
        here: Block and lane of these worlds.
        indices: Of the arenas among those prepared.
    """
    if worlds.bodies.near:
        lists = worlds.bodies.near.lists[:, 0]
        lists["arena"][here], lists["listed_arena"][here] = indices, -1


class _Pieces:
    """The records of several arenas, joined."""

    def __init__(self) -> None:
        self._first: tuple[Parameters, TaskParameters]
        self._arrays: dict[str, _Growing] = {}

    def add(self, parameters: Parameters, task: TaskParameters) -> None:
        if not self._arrays:
            self._first = parameters, task
        record, own = task.arena.copy(), np.zeros(1, bodies.arena_dtype)
        for name, array in (("wall", task.map_walls), ("corner", task.corners), ("waypoint", task.waypoints)):
            record[f"{name}s"] = len(array)
        for name, joined in (
            ("first_wall", "walls"),
            ("first_corner", "corners"),
            ("first_waypoint", "waypoints"),
            ("first_length", "way_lengths"),
        ):
            record[name] = self._length(joined)
        for name in ("first_wall", "walls", "first_corner", "corners"):
            own[name] = record[name]
        for name in ("anchor_x", "anchor_y"):
            own[name] = parameters.constants[name]
        for name, rows in (
            *(("arenas", own), ("walls", parameters.walls), ("corners", parameters.corners)),
            *(("arena", record), ("map_walls", task.map_walls), ("floor_walls", task.floor_walls)),
            *(("way_corners", task.corners), ("waypoints", task.waypoints)),
            ("way_lengths", task.way_lengths),
            *(("start_lengths", task.start_lengths), ("home_lengths", task.home_lengths)),
        ):
            self._arrays.setdefault(name, _Growing(rows.dtype)).append(rows)

    def joined(self) -> tuple[Parameters, TaskParameters]:
        arrays = {name: growing.array for name, growing in self._arrays.items()}
        parameters, task = self._first
        return (
            parameters._replace(walls=arrays["walls"], corners=arrays["corners"], arenas=arrays["arenas"]),
            task._replace(
                corners=arrays["way_corners"],
                **{
                    name: arrays[name]
                    for name in (
                        *("arena", "map_walls", "floor_walls"),
                        *("waypoints", "way_lengths", "start_lengths", "home_lengths"),
                    )
                },
            ),
        )

    def _length(self, name: str) -> int:
        return len(self._arrays[name].array) if name in self._arrays else 0


class _Growing:
    """An array that grows at its end; its memory doubles when it is full."""

    def __init__(self, dtype: np.dtype[Any]) -> None:
        self._memory, self._count = np.zeros(64, dtype), 0

    @property
    def array(self) -> NDArray[Any]:
        return self._memory[: self._count]

    def append(self, rows: NDArray[Any]) -> None:
        end = self._count + len(rows)
        if end > len(self._memory):
            memory = np.zeros(2 * end, self._memory.dtype)
            memory[: self._count] = self.array
            self._memory = memory
        self._memory[self._count : end] = rows
        self._count = end
