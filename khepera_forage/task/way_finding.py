"""The way of a robot to its home and to food: straight, or around walls and past the home (`geometry.paths`)."""

import math
from typing import Any

from khepera_forage.geometry.angles import length
from khepera_forage.geometry.paths import find_lengths, is_clear, next_waypoint, waypoint_around
from khepera_forage.task.arena_map import ArenaMap

_MOVED = 1.0
"""Pixels by which food may move before the paths to it are looked up again."""

Way = tuple[float, float, float]
"""The way to a place: x and y of the next waypoint, and the length of the path, 0 where the way is straight."""


def way_home(x: float, y: float, arena: ArenaMap) -> Way:
    """The way home from a place, in pixels."""
    if len(arena.ways.corners) == 0:
        return arena.home_x, arena.home_y, 0.0
    return _way(x, y, arena.home_x, arena.home_y, arena.ways.home_lengths, False, arena)


def way_to_food(x: float, y: float, tracker: Any, food_lengths: Any, arena: ArenaMap) -> Way:
    """The way to the nearest food from a place, in pixels.

    Args:
        x: Of the robot.
        y: Of the robot.
        tracker: The `FoodTracker` record, after its round.
        food_lengths: Of the shortest paths from each waypoint to each food object.
        arena: Its arena.
    """
    if len(arena.ways.corners) == 0 or tracker.nearest < 0:
        return tracker.food_x, tracker.food_y, 0.0
    return _way(x, y, tracker.food_x, tracker.food_y, food_lengths[tracker.nearest], True, arena)


def _way(x: float, y: float, to_x: float, to_y: float, lengths: Any, past_home: bool, arena: ArenaMap) -> Way:
    way_x, way_y, path = next_waypoint(x, y, to_x, to_y, lengths, past_home, arena.walls, arena.ways)
    # Without a path, such as for a robot that was pushed into a corner, the robot drives straight on.
    return way_x, way_y, (path if path < math.inf else 0.0)


def path_to_food(
    x: float, y: float, to_x: float, to_y: float, food: Any, lengths: Any, arena: ArenaMap
) -> float:
    """Length of the path from a robot to food; infinite without one.

    Args:
        x: Of the robot.
        y: Of the robot.
        to_x: Of the food's region.
        to_y: Of the food's region.
        food: Its `FoodObject` record. `lengths_x` and `lengths_y`, the place for which `lengths` holds, are changed.
        lengths: Of the shortest path from each waypoint to the food; changed in place if the food has moved.
        arena: The arena.
    """
    if is_clear(x, y, to_x, to_y, True, arena.walls, arena.ways):
        return length(to_x - x, to_y - y)
    if length(to_x - food.lengths_x, to_y - food.lengths_y) > _MOVED:
        find_lengths(to_x, to_y, lengths, True, arena.walls, arena.ways)
        food.lengths_x, food.lengths_y = to_x, to_y
    return waypoint_around(x, y, to_x, to_y, lengths, True, arena.walls, arena.ways)[2]


def can_be_reached(x: float, y: float, arena: ArenaMap) -> bool:
    """Whether there is a way home from a place in pixels, and a way past the home from it to the start of training."""
    ways = arena.ways
    if len(ways.corners) == 0:
        return True
    home = next_waypoint(x, y, arena.home_x, arena.home_y, ways.home_lengths, False, arena.walls, ways)
    start = next_waypoint(x, y, arena.start_x, arena.start_y, ways.start_lengths, True, arena.walls, ways)
    return bool(max(home[2], start[2]) < math.inf)
