"""Map and floor of the arena in which a world is: the same one for all worlds of a batch, or one of several."""

from typing import Any, NamedTuple

from khepera_forage.compilation.decorators import types, variant
from khepera_forage.compilation.parts import part_of
from khepera_forage.envs.compiled.parameters import TaskParameters, arena_map, floor, floor_with, map_of
from khepera_forage.geometry.paths import Ways
from khepera_forage.sim.compiled.near_walls import several
from khepera_forage.task.arena_map import ArenaMap, Floor


class ArenaMaps(NamedTuple):
    """What the maps of several arenas are read from.

    Attributes:
        lists: `lists_dtype`, shape (1,): the arena of each world.
        task: The records of all arenas.
    """

    lists: Any
    task: TaskParameters


def are_several(maps: Any) -> bool:
    """Whether this is numba's type of `ArenaMaps`, and not that of a single map."""
    return isinstance(maps, types.NamedTuple) and maps.instance_class is ArenaMaps


def arena_maps(near: Any, task: TaskParameters) -> Any:
    """What `map_in` needs, read once for a block: the map itself if all worlds are in one arena."""
    return arena_map(task)


@variant(arena_maps, several)
def _arena_maps(near: Any, task: TaskParameters) -> Any:
    return ArenaMaps(near.lists, task)


def map_in(maps: Any, i: int) -> ArenaMap:
    """What the robot of one world knows of its arena."""
    return maps  # type: ignore[no-any-return]


@variant(map_in, are_several)
def _map_in(maps: Any, i: int) -> ArenaMap:
    task = maps.task
    arena = task.arena[maps.lists[0].arena[i]]
    waypoint, count = arena.first_waypoint, arena.waypoints
    return map_of(
        arena,
        part_of(task.map_walls, arena.first_wall, arena.walls),
        part_of(task.corners, arena.first_corner, arena.corners),
        part_of(task.waypoints, waypoint, count),
        part_of(task.way_lengths, arena.first_length, count * count),
        part_of(task.start_lengths, waypoint, count),
        part_of(task.home_lengths, waypoint, count),
    )


def keep_numbers(maps: Any, task: Any, i: int) -> None:
    """Write the numbers of the map of one world into the record of its task, where `numbers_in` reads them."""


@variant(keep_numbers, are_several)
def _keep_numbers(maps: Any, task: Any, i: int) -> None:
    arena = maps.task.arena[maps.lists[0].arena[i]]
    task.map_home_x[i], task.map_home_y[i] = arena.map_home_x, arena.map_home_y
    task.map_home_radius[i], task.map_home_opening[i] = arena.map_home_radius, arena.map_home_opening
    task.map_diagonal[i] = arena.map_diagonal


def numbers_in(maps: Any, task: Any, i: int) -> ArenaMap:
    """The numbers of the map of one world, for loops over lanes; its start, bounds, walls and ways must not be read."""
    return maps  # type: ignore[no-any-return]


@variant(numbers_in, are_several)
def _numbers_in(maps: Any, task: Any, i: int) -> ArenaMap:
    every = maps.task
    return ArenaMap(
        task.map_home_x[i],
        task.map_home_y[i],
        int(task.map_home_radius[i]),
        0.0,
        0.0,
        task.map_home_opening[i],
        int(task.map_diagonal[i]),
        0.0,
        0.0,
        0.0,
        0.0,
        every.map_walls,
        Ways(
            0.0,
            0.0,
            0.0,
            0.0,
            every.corners,
            every.waypoints,
            every.way_lengths,
            every.start_lengths,
            every.home_lengths,
        ),
    )


def floor_in(near: Any, task: TaskParameters, i: int) -> Floor:
    """The floor of the arena of one world."""
    return floor(task)


@variant(floor_in, several)
def _floor_in(near: Any, task: TaskParameters, i: int) -> Floor:
    arena = task.arena[near.lists[0].arena[i]]
    return floor_with(arena, part_of(task.floor_walls, arena.first_wall, arena.walls))
