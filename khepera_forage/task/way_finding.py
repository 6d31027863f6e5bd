"""The way of a robot to its home and to food: straight, or around walls (`geometry.paths`).

The way to food leads past the home, and the way home past poison.
"""

import math
from typing import Any

from khepera_forage.geometry.angles import length
from khepera_forage.geometry.paths import has_path, is_straight, next_waypoint
from khepera_forage.task.arena_map import ArenaMap
from khepera_forage.task.past_poison import is_poison_about, past_poison

Way = tuple[float, float, float]
"""The way to a place in pixels: x and y of the next waypoint, and the length of the path, which is 0 if every way in
the arena is straight, and infinite if there is none."""


def way_home(x: float, y: float, tracker: Any, foods: Any, chosen: Any, arena: ArenaMap) -> Way:
    """The way home of a robot.

    Args:
        x: Of the robot, pixels.
        y: Of the robot, pixels.
        tracker: Its `FoodTracker` record.
        foods: The `FoodObject` records.
        chosen: `ChosenWaypoint` records: on its way home, then on its way to each food object; changed in place.
        arena: Its arena.
    """
    to_x, to_y, ways, walls = arena.home_x, arena.home_y, arena.ways, arena.walls
    way = to_x, to_y, 0.0
    if len(ways.corners) > 0:
        if is_straight(x, y, to_x, to_y, False, chosen[0], walls, ways):
            way = to_x, to_y, length(to_x - x, to_y - y)
        else:
            way = drivable(next_waypoint(x, y, to_x, to_y, False, chosen[0], walls, ways), to_x, to_y)
    if tracker.held < 0 or not is_poison_about(tracker.held, foods):
        return way
    return *past_poison(x, y, way[0], way[1], tracker.held, foods, arena), way[2]


def way_to_food(x: float, y: float, to_x: float, to_y: float, chosen: Any, arena: ArenaMap) -> Way:
    """The way past the home from a place to food.

    Args:
        x: Of the robot, pixels.
        y: Of the robot, pixels.
        to_x: Of the food's region.
        to_y: Of the food's region.
        chosen: The `ChosenWaypoint` record of the way to this food object; changed in place.
        arena: Its arena.
    """
    ways, walls = arena.ways, arena.walls
    if len(ways.corners) == 0:
        return to_x, to_y, 0.0
    if is_straight(x, y, to_x, to_y, True, chosen, walls, ways):
        return to_x, to_y, length(to_x - x, to_y - y)
    return next_waypoint(x, y, to_x, to_y, True, chosen, walls, ways)


def drivable(way: Way, to_x: float, to_y: float) -> Way:
    """The way that a robot takes: without a path, such as when it was pushed into a corner, it drives straight on."""
    if way[2] == math.inf:
        return to_x, to_y, 0.0
    return way


def can_be_reached(x: float, y: float, arena: ArenaMap) -> bool:
    """Whether there is a way home from a place in pixels, and a way past the home from it to the start of training."""
    ways, walls = arena.ways, arena.walls
    if len(ways.corners) == 0:
        return True
    return has_path(x, y, arena.home_x, arena.home_y, False, walls, ways) and has_path(
        x, y, arena.start_x, arena.start_y, True, walls, ways
    )
