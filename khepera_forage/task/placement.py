"""Where robot and food stand at the start of an episode: at random (5.4.1.1) or on the marks of figure 5.1.

The functions take *records*: objects with the fields of `Start` and `Place`. All numbers come from the counter-based
generator, so that a seed gives the same layout on every backend.
"""

import math
from dataclasses import dataclass
from typing import Any

from khepera_forage.counter_rng import random_bits, standard_normal, uniform
from khepera_forage.geometry.plane import clearance
from khepera_forage.robots.footprint import body_is_free, discs_are_apart, gripper_is_free
from khepera_forage.robots.khepera import FOOD_RADIUS, RADIUS
from khepera_forage.task.arena_map import ArenaMap, Floor, can_be_reached
from khepera_forage.task.decisions import DecisionValues
from khepera_forage.task.food_tracking import drawn_type
from khepera_forage.task.states import FoodType
from khepera_forage.vision.scene import MM_PER_PIXEL

_MARGIN = 5.0
"""mm that a random start keeps clear around body and gripper, and food beyond the close threshold."""
_LAYOUTS = 1 << 48
"""First number of a key that is for layouts; devices of simulated worlds use the numbers below."""
_ARENAS = 1 << 49
"""First number of a key that is for arenas; 2**47 episodes need the numbers between it and `_LAYOUTS`."""
_FOOD_NUMBERS = 1 << 20
"""First number of a layout's key that is for food."""
TRIES = 200
"""Draws of a layout after which there is no room."""
_POISONOUS = FoodType.POISONOUS.value


@dataclass(slots=True)
class Start:
    """Where a robot starts: mm and radians."""

    x: float = 0.0
    y: float = 0.0
    heading: float = 0.0


@dataclass(slots=True)
class Place:
    """Where a food object lies: mm."""

    x: float = 0.0
    y: float = 0.0


def arena_number(key: Any, episode: Any, count: int) -> Any:
    """Number of the arena of an episode of a world, counted from its seed, if there are `count` arenas.

    Args:
        key: Of the world. With an array of keys and one of episodes, both 64 bits without sign, all at once.
        episode: Which of its episodes.
        count: Number of arenas.
    """
    return random_bits(key, _ARENAS + episode) % count


def layout_key(key: Any, episode: int) -> Any:
    """Key of the layout of an episode of a world, counted from its seed."""
    return random_bits(key, _LAYOUTS + 2 * episode)


def food_type_key(key: Any, episode: int) -> Any:
    """Key of the food types of an episode of a world, counted from its seed."""
    return random_bits(key, _LAYOUTS + 2 * episode + 1)


def draw_food_types(foods: Any, key: Any, odds: Any) -> None:
    """Draw the types of food objects by a `food_type_key`, and note whether they may be poison; see `drawn_type`."""
    for k in range(len(foods)):
        foods[k].type = drawn_type(uniform(key, k), odds)
        foods[k].may_be_poisonous = odds[_POISONOUS - 1] > 0.0


def draw_layout(
    start: Any,
    places: Any,
    key: Any,
    floor: Floor,
    arena: ArenaMap,
    decisions: DecisionValues,
    start_given: bool = False,
    places_given: bool = False,
) -> bool:
    """Draw a random start and random food places (5.4.1.1).

    The robot starts anywhere outside home, heading uniform. Food lies outside home, further from the robot than the
    close threshold, where a gripper fits around it. Both can be reached from home, and from one another past the home.

    Args:
        start: The `Start` record; changed in place.
        places: `Place` records; changed in place.
        key: From `layout_key`.
        floor: Where.
        arena: The same arena as the robot knows it.
        decisions: `DecisionValues`.
        start_given: Whether the start stays as it is.
        places_given: Whether the places stay as they are.

    Returns:
        Whether there is room.
    """
    # Numbers of their own: a given start leaves the food of a key where it is, and given food the start.
    number, food_number = 0, _FOOD_NUMBERS
    for _ in range(TRIES):
        if not start_given:
            start.x, start.y = _draw_place(key, number, floor)
            start.heading = math.pi * (2.0 * uniform(key, number + 2) - 1.0)
            number += 3
            if not (_is_outside_home(start, RADIUS, floor) and _robot_is_free(start, _MARGIN, floor)):
                continue
            if not can_be_reached(start.x / MM_PER_PIXEL, start.y / MM_PER_PIXEL, arena):
                continue
        if places_given:
            if layout_is_free(start, places, floor):
                return True
            continue
        placed = 0
        for _ in range(50 * len(places)):
            place = places[placed]
            place.x, place.y = _draw_place(key, food_number, floor)
            food_number += 2
            fits = _food_fits(place, places, placed, start, floor, decisions)
            if fits and can_be_reached(place.x / MM_PER_PIXEL, place.y / MM_PER_PIXEL, arena):
                placed += 1
                if placed == len(places):
                    return True
    return False


def _draw_place(key: Any, number: int, floor: Floor) -> tuple[float, float]:
    """A random place within the floor's bounds, from two numbers of a key."""
    x = floor.left + (floor.right - floor.left) * uniform(key, number)
    y = floor.bottom + (floor.top - floor.bottom) * uniform(key, number + 1)
    return x, y


def place_by_hand(
    start: Any, places: Any, key: Any, mark: Any, food_marks: Any, error: float, heading_error: float, floor: Floor
) -> bool:
    """Put a robot and food on their marks (figure 5.1), as well as an operator can (4.5.2).

    What would stand in a wall, or in something else, is put down again.

    Args:
        start: The `Start` record; changed in place.
        places: `Place` records; changed in place.
        key: From `layout_key`.
        mark: `Start` record of the robot's mark.
        food_marks: `Place` records of the food's marks.
        error: Standard deviation of each coordinate, mm.
        heading_error: Standard deviation of the heading, radians.
        floor: Where.

    Returns:
        Whether everything stands free.
    """
    numbers = 3 + 2 * len(places)
    for attempt in range(TRIES):
        first = attempt * numbers
        start.x = mark.x + error * standard_normal(key, first)
        start.y = mark.y + error * standard_normal(key, first + 1)
        start.heading = mark.heading + heading_error * standard_normal(key, first + 2)
        for k in range(len(places)):
            places[k].x = food_marks[k].x + error * standard_normal(key, first + 3 + 2 * k)
            places[k].y = food_marks[k].y + error * standard_normal(key, first + 4 + 2 * k)
        if layout_is_free(start, places, floor):
            return True
    return False


def layout_is_free(start: Any, places: Any, floor: Floor) -> bool:
    """Whether robot, gripper and food stand in no wall and not in one another."""
    if not _robot_is_free(start, 0.0, floor):
        return False
    for k in range(len(places)):
        place = places[k]
        if clearance(place.x, place.y, floor.walls) < FOOD_RADIUS:
            return False
        if not discs_are_apart(place.x, place.y, start.x, start.y, RADIUS + FOOD_RADIUS):
            return False
        for other in range(k):
            if not discs_are_apart(place.x, place.y, places[other].x, places[other].y, 2.0 * FOOD_RADIUS):
                return False
    return True


def _robot_is_free(start: Any, margin: float, floor: Floor) -> bool:
    return body_is_free(start.x, start.y, margin, floor.walls) and gripper_is_free(
        start.x, start.y, start.heading, margin, floor.walls
    )


def _is_outside_home(place: Any, radius: float, floor: Floor) -> bool:
    return discs_are_apart(place.x, place.y, floor.home_x, floor.home_y, floor.home_radius + radius)


def _food_fits(place: Any, places: Any, placed: int, start: Any, floor: Floor, decisions: DecisionValues) -> bool:
    """Whether food may lie here, beside the food placed so far."""
    distance = decisions.close_to_food * MM_PER_PIXEL + _MARGIN
    if not discs_are_apart(place.x, place.y, start.x, start.y, distance):
        return False
    if not _is_outside_home(place, FOOD_RADIUS, floor):
        return False
    for other in range(placed):
        if not discs_are_apart(place.x, place.y, places[other].x, places[other].y, decisions.food_spacing):
            return False
    return bool(clearance(place.x, place.y, floor.walls) >= decisions.food_to_walls)
