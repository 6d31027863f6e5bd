"""What all compiled worlds of a batch have in common, for their bodies and for their task."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import inline
from khepera_forage.envs.arguments import FoodOdds, food_odds, timing_of, whole_number
from khepera_forage.envs.compiled.records import (
    arena_dtype,
    decisions_dtype,
    place_dtype,
    wall_dtype,
    way_corner_dtype,
)
from khepera_forage.envs.forager import arena_map_of, floor_of
from khepera_forage.geometry.paths import Ways
from khepera_forage.noise import Noise
from khepera_forage.sim.arena import MOST_FOODS, Arena
from khepera_forage.sim.compiled.listed_walls import at
from khepera_forage.sim.compiled.parameters import Parameters, parameters_of
from khepera_forage.sim.layout_checks import check_seen
from khepera_forage.task.arena_map import ArenaMap, Floor
from khepera_forage.task.decisions import Decisions


class TaskParameters(NamedTuple):
    """What is the same for the task of every world of a batch. Kernels read all of it at run time.

    Attributes:
        arena: `arena_dtype`, shape (1,).
        map_walls: `wall_dtype`, the walls in pixels.
        floor_walls: `wall_dtype`, the walls in mm.
        corners: `way_corner_dtype`, the corners that point into the floor, in pixels.
        waypoints: `place_dtype`, in pixels.
        way_lengths: Of the shortest paths between waypoints, shape (waypoints * waypoints,).
        start_lengths: Of the shortest path from each waypoint to the start.
        home_lengths: Of the shortest path from each waypoint to the home.
        decisions: `decisions_dtype`, shape (1,).
    """

    arena: NDArray[Any]
    map_walls: NDArray[Any]
    floor_walls: NDArray[Any]
    corners: NDArray[Any]
    waypoints: NDArray[Any]
    way_lengths: NDArray[np.float64]
    start_lengths: NDArray[np.float64]
    home_lengths: NDArray[np.float64]
    decisions: NDArray[Any]


def recall_parameters(
    arena: Arena,
    foods: int,
    limit: int,
    noise: Noise | str | None,
    food_types: FoodOdds,
    decisions: Decisions,
    wheel_speed: float = 1.0,
) -> tuple[Parameters, TaskParameters]:
    """The parameters of recalls in one arena, checked.

    Args:
        arena: From an `ArenaPool`.
        foods: Food objects in each world, 1 to 16.
        limit: Steps after which an episode ends.
        noise: The laboratory's troubles by default.
        food_types: One type, or odds by type.
        decisions: Of the task.
        wheel_speed: Share of the commanded speed that wheels reach.

    Raises:
        ValueError: An argument out of range, or an arena that the camera does not see.
    """
    check_seen([arena])
    if whole_number("foods", foods, 1) > MOST_FOODS:
        raise ValueError(f"foods is {foods!r}; allowed: 1 to {MOST_FOODS} in compiled worlds")
    bodies = parameters_of(
        arena,
        foods,
        noise,
        holes=decisions.recall_marker,
        wheel_speed=wheel_speed,
        timing=timing_of(decisions),
    )
    task = task_parameters(arena, whole_number("limit", limit, 1), food_odds(food_types), decisions)
    return bodies, task


def task_parameters(
    arena: Arena, limit: int, odds: tuple[float, ...], decisions: Decisions
) -> TaskParameters:
    """The task's parameters in one arena."""
    map_, floor = arena_map_of(arena), floor_of(arena)
    values: Any = decisions.values()
    record = np.zeros(1, arena_dtype)
    for prefix, known in (("map", map_), ("floor", floor)):
        for name, value in known._asdict().items():
            if name not in ("walls", "ways"):
                record[f"{prefix}_{name}"] = value
    record["map_clearance"], record["map_berth"] = map_.ways.clearance, map_.ways.berth
    record["odds"] = odds
    record["limit"] = limit
    return TaskParameters(
        record,
        np.array(list(map(tuple, map_.walls)), wall_dtype),
        np.array(list(map(tuple, floor.walls)), wall_dtype),
        np.array(list(map(tuple, map_.ways.corners)), way_corner_dtype),
        np.array(list(map(tuple, map_.ways.waypoints)), place_dtype),
        np.array(map_.ways.lengths, np.float64),
        np.array(map_.ways.start_lengths, np.float64),
        np.array(map_.ways.home_lengths, np.float64),
        np.array([tuple(values)], decisions_dtype),
    )


@inline
def arena_map(task: TaskParameters) -> ArenaMap:
    """What the robots know of their arena."""
    return map_of(
        task.arena[0],
        0,
        task.map_walls,
        task.corners,
        task.waypoints,
        task.way_lengths,
        task.start_lengths,
        task.home_lengths,
    )


@inline
def map_of(
    numbers: Any,
    i: int,
    walls: Any,
    corners: Any,
    waypoints: Any,
    lengths: Any,
    start_lengths: Any,
    home_lengths: Any,
) -> ArenaMap:
    """What the robots know of one arena, from its part of each array and its numbers.

    Args:
        numbers: A record with the fields `MAP`: of the arena, or of one block of worlds.
        i: The lane, if it is of worlds.
        walls: As in `TaskParameters`; so are the others.
        corners: Of this arena.
        waypoints: Of this arena.
        lengths: Of this arena.
        start_lengths: Of this arena.
        home_lengths: Of this arena.
    """
    home_x, home_y = at(numbers.map_home_x, i), at(numbers.map_home_y, i)
    return ArenaMap(
        home_x,
        home_y,
        int(at(numbers.map_home_radius, i)),
        at(numbers.map_start_x, i),
        at(numbers.map_start_y, i),
        at(numbers.map_home_opening, i),
        int(at(numbers.map_diagonal, i)),
        at(numbers.map_left, i),
        at(numbers.map_bottom, i),
        at(numbers.map_right, i),
        at(numbers.map_top, i),
        walls,
        Ways(
            at(numbers.map_clearance, i),
            home_x,
            home_y,
            at(numbers.map_berth, i),
            corners,
            waypoints,
            lengths,
            start_lengths,
            home_lengths,
        ),
    )


@inline
def floor(task: TaskParameters) -> Floor:
    """The floor on which everything is placed."""
    return floor_with(task.arena[0], task.floor_walls)


@inline
def floor_with(arena: Any, walls: Any) -> Floor:
    """The floor of one arena, from its `arena_dtype` record and its walls in mm."""
    return Floor(
        arena.floor_left,
        arena.floor_bottom,
        arena.floor_right,
        arena.floor_top,
        arena.floor_home_x,
        arena.floor_home_y,
        arena.floor_home_radius,
        walls,
    )
