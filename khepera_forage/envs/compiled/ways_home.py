"""The ways home in every world of a block.

They take a large part of a round, and most behaviours do not use them. So they are looked up when a behaviour that uses
them is commanded; until then every way home counts as straight. Only if the state vector has distances along the path,
they are looked up at once.
"""

from typing import Any

from khepera_forage.compilation.decorators import inline, kernel, variant
from khepera_forage.envs.compiled.arena_maps import are_several, arena_maps, map_in
from khepera_forage.envs.compiled.parameters import TaskParameters
from khepera_forage.envs.compiled.raw_data import perceived, raw_data_in
from khepera_forage.envs.compiled.worlds import UNUSED, Worlds
from khepera_forage.task.behaviours import uses_way_home
from khepera_forage.task.perception import perceives_paths
from khepera_forage.task.states import FoodType
from khepera_forage.task.way_finding import KnownWays, Way, way_home

_POISONOUS = FoodType.POISONOUS - 1
"""Index of its odds."""


@inline
def known_ways_in(worlds: Worlds, i: int) -> KnownWays:
    """What the robot of one world knows of the ways in its arena."""
    return KnownWays(worlds.straight_ways[i], worlds.to_waypoints[i], worlds.food_lengths[i])


def have_corners(maps: Any) -> bool:
    """Whether there can be walls between a robot and its home."""
    return len(maps.ways.corners) > 0


@variant(have_corners, are_several)
def _have_corners(maps: Any) -> bool:
    return True


@inline
def _can_be_bent(maps: Any, parameters: TaskParameters) -> bool:
    """Whether a way home may lead around walls or past poison."""
    return have_corners(maps) or parameters.arena[0].odds[_POISONOUS] > 0.0


@inline
def begin_ways_home(worlds: Worlds, maps: Any, parameters: TaskParameters) -> None:
    """Begin with straight ways home, or look them up if the state vector needs them."""
    robot, task = worlds.bodies.robots, worlds.tasks
    for i in range(robot.x.shape[0]):
        arena = map_in(maps, task, i)
        task.home_way_x[i], task.home_way_y[i], task.home_path[i] = arena.home_x, arena.home_y, 0.0
    if perceives_paths(parameters.decisions[0]) and _can_be_bent(maps, parameters):
        for i in range(robot.x.shape[0]):
            task.home_way_x[i], task.home_way_y[i], task.home_path[i] = _way_home(worlds, maps, i)


@kernel
def find_ways_home(worlds: Worlds, parameters: TaskParameters, behaviours: Any) -> None:
    """Look up the ways home that the coming commands use.

    Args:
        worlds: The records of one block.
        parameters: Of the task.
        behaviours: One a lane: which will be commanded.
    """
    robot, task = worlds.bodies.robots, worlds.tasks
    maps = arena_maps(worlds.bodies.near, parameters)
    if perceives_paths(parameters.decisions[0]) or not _can_be_bent(maps, parameters):
        return
    for i in range(robot.x.shape[0]):
        raw = raw_data_in(robot, task, i, map_in(maps, task, i))
        # A robot before its first frame does nothing.
        if robot.first_frame[i] == 0.0 and uses_way_home(int(behaviours[i]), raw):
            task.home_way_x[i], task.home_way_y[i], task.home_path[i] = _way_home(worlds, maps, i)
    # In a loop of its own, because it does the same in every lane: one instruction then works on several.
    for i in range(robot.x.shape[0]):
        raw = perceived(worlds, i, map_in(maps, task, i))
        task.home_bearing[i], task.home_path[i] = raw.home_bearing, raw.home_path


@inline
def _way_home(worlds: Worlds, maps: Any, i: int) -> Way:
    robot, arena = worlds.bodies.robots, map_in(maps, worlds.tasks, i)
    # Robots in unused lanes would try all waypoints, in every round.
    if robot.x[i] < UNUSED / 2.0:
        return arena.home_x, arena.home_y, 0.0
    x, y, tracker = robot.marker_x[i], robot.marker_y[i], worlds.trackers[i]
    return way_home(x, y, tracker, worlds.foods[i], known_ways_in(worlds, i), arena)
