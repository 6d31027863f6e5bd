"""Map and floor of the arena in which a world is: the same one for all worlds of a batch, or one of several."""

from typing import Any

from khepera_forage.compilation.decorators import types, variant
from khepera_forage.compilation.parts import part_of
from khepera_forage.envs.compiled.parameters import TaskParameters, arena_map, floor, floor_with, map_of
from khepera_forage.sim.compiled.near_walls import several
from khepera_forage.task.arena_map import ArenaMap, Floor


def are_several(maps: Any) -> bool:
    """Whether this is numba's type of the records of several arenas, and not that of a single map."""
    return isinstance(maps, types.NamedTuple) and maps.instance_class is TaskParameters


def arena_maps(near: Any, parameters: TaskParameters) -> Any:
    """What `map_in` needs, read once for a block: the map itself if all worlds are in one arena, or all records."""
    return arena_map(parameters)


@variant(arena_maps, several)
def _arena_maps(near: Any, parameters: TaskParameters) -> Any:
    return parameters


def map_in(maps: Any, task: Any, i: int) -> ArenaMap:
    """What the robot of one world knows of its arena.

    Args:
        maps: From `arena_maps`.
        task: `task_dtype` of the block.
        i: The lane.
    """
    return maps  # type: ignore[no-any-return]


@variant(map_in, are_several)
def _map_in(maps: Any, task: Any, i: int) -> ArenaMap:
    waypoint, count = task.first_waypoint[i], task.waypoints[i]
    return map_of(
        task,
        i,
        part_of(maps.map_walls, task.first_wall[i], task.walls[i]),
        part_of(maps.corners, task.first_corner[i], task.corners[i]),
        part_of(maps.waypoints, waypoint, count),
        part_of(maps.way_lengths, task.first_length[i], count * count),
        part_of(maps.start_lengths, waypoint, count),
        part_of(maps.home_lengths, waypoint, count),
    )


def enter_map(near: Any, task: Any, i: int, parameters: TaskParameters) -> None:
    """Copy what `map_in` reads of the arena of one world."""


@variant(enter_map, several)
def _enter_map(near: Any, task: Any, i: int, parameters: TaskParameters) -> None:
    arena = parameters.arena[near.lists[0].arena[i]]
    task.map_home_x[i], task.map_home_y[i] = arena.map_home_x, arena.map_home_y
    task.map_home_radius[i], task.map_home_opening[i] = arena.map_home_radius, arena.map_home_opening
    task.map_start_x[i], task.map_start_y[i] = arena.map_start_x, arena.map_start_y
    task.map_diagonal[i] = arena.map_diagonal
    task.map_left[i], task.map_bottom[i] = arena.map_left, arena.map_bottom
    task.map_right[i], task.map_top[i] = arena.map_right, arena.map_top
    task.map_clearance[i], task.map_berth[i] = arena.map_clearance, arena.map_berth
    task.first_wall[i], task.walls[i] = arena.first_wall, arena.walls
    task.first_corner[i], task.corners[i] = arena.first_corner, arena.corners
    task.first_waypoint[i], task.waypoints[i] = arena.first_waypoint, arena.waypoints
    task.first_length[i] = arena.first_length


def floor_in(near: Any, parameters: TaskParameters, i: int) -> Floor:
    """The floor of the arena of one world."""
    return floor(parameters)


@variant(floor_in, several)
def _floor_in(near: Any, parameters: TaskParameters, i: int) -> Floor:
    arena = parameters.arena[near.lists[0].arena[i]]
    return floor_with(arena, part_of(parameters.floor_walls, arena.first_wall, arena.walls))
