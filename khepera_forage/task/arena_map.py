"""What a robot knows of its arena from the beginning, in pixels, and how it finds its way there.

The way to food leads past the home. The way home of a robot with food in its gripper leads past poison, which it would
shove home before it. Both go straight, or around walls (`geometry.paths`). Plain functions, also compiled.
"""

import math
from typing import Any, NamedTuple

from khepera_forage.geometry.paths import PathTables, has_path, next_waypoint
from khepera_forage.geometry.plane import clearance, length
from khepera_forage.robots.khepera import FOOD_RADIUS, RADIUS
from khepera_forage.task.states import FoodType
from khepera_forage.vision.scene import MM_PER_PIXEL

OUTSIDE = 4.0
"""Pixels by which a region may seem to lie outside its arena and still belong to it."""
EVERY_SIDE = 360.0
"""The opening of a home that can be left and passed on every side: no direction has this number of degrees."""


class ArenaMap(NamedTuple):
    """What a robot knows of its own arena, in pixels.

    Attributes:
        home_x: Centre of its home.
        home_y: Centre of its home.
        home_radius: Whole pixels.
        start_x: Where training starts.
        start_y: Where training starts.
        home_opening: Degrees from the home to the side on which it can be left and passed: to the middle of the floor,
            or, where walls stand between, to the first waypoint towards the start. `EVERY_SIDE` where no wall is near.
        diagonal: Of the arena, whole pixels: the largest distance of 4.6.1.
        left: Smallest x of a region that belongs to it, `OUTSIDE` pixels to the left of its walls.
        bottom: Smallest y of such a region.
        right: Largest x of such a region.
        top: Largest y of such a region.
        walls: `geometry.plane.Wall` records.
        paths: How to drive around its walls.
    """

    home_x: float
    home_y: float
    home_radius: int
    start_x: float
    start_y: float
    home_opening: float
    diagonal: int
    left: float
    bottom: float
    right: float
    top: float
    walls: Any
    paths: PathTables


class Floor(NamedTuple):
    """The floor of an arena, in mm.

    Attributes:
        left: Smallest x.
        bottom: Smallest y.
        right: Largest x.
        top: Largest y.
        home_x: Centre of the home.
        home_y: Centre of the home.
        home_radius: Of the home.
        walls: `geometry.plane.Wall` records.
    """

    left: float
    bottom: float
    right: float
    top: float
    home_x: float
    home_y: float
    home_radius: float
    walls: Any


def whole_pixels(length: float) -> int:
    """A length in mm as robots know it: in whole pixels."""
    return round(length / MM_PER_PIXEL)


def is_within(x: float, y: float, arena: ArenaMap) -> bool:
    """Whether a region at this place, in pixels, lies in the arena."""
    # Without a chained comparison, which numba compiles to branches.
    return (arena.left <= x) & (x <= arena.right) & (arena.bottom <= y) & (y <= arena.top)


NextWaypoint = tuple[float, float, float]
"""The way to a place in pixels: x and y of the next waypoint, and the length of the path, which is 0 if every way in
the arena is straight, and infinite if there is none."""

_TOUCH = (RADIUS + FOOD_RADIUS) / MM_PER_PIXEL
"""Pixels from the centre of a robot to food that it touches."""
_BERTH = _TOUCH + 2.0
"""Pixels at which it passes poison."""
_ROOM = (RADIUS + 25.0) / MM_PER_PIXEL
"""Pixels to the walls that it needs there."""
_BESIDE = 0.85
"""Share of its distance from poison at which its way may pass that: a robot beside poison can leave it."""
_LEFT, _RIGHT, _NO_ROOM = 1, -1, 2
"""Values of `FoodObject.side`; the first two are the sign of the turn towards that side."""
_UNKNOWN, _POISONOUS = FoodType.UNKNOWN.value, FoodType.POISONOUS.value


def path_home(x: float, y: float, known: Any, arena: ArenaMap) -> NextWaypoint:
    """The way home of a robot at (x, y), pixels; chosen waypoint, and sides to pass poison, are changed in `known`."""
    chosen, held = known.chosen[0], known.tracker.held
    to_x, to_y, paths, walls = arena.home_x, arena.home_y, arena.paths, arena.walls
    way = to_x, to_y, 0.0
    if len(paths.corners) > 0:
        way = drivable(next_waypoint(x, y, to_x, to_y, False, chosen, walls, paths), to_x, to_y)
    if held < 0 or not is_poison_about(held, known.objects):
        return way
    return *past_poison(x, y, way[0], way[1], held, known.objects, arena), way[2]


def drivable(way: NextWaypoint, to_x: float, to_y: float) -> NextWaypoint:
    """The way that a robot takes: without a path, such as when it was pushed into a corner, it drives straight on."""
    if way[2] == math.inf:
        return to_x, to_y, 0.0
    return way


def can_be_reached(x: float, y: float, arena: ArenaMap) -> bool:
    """Whether there is a way home from a place in pixels, and a way past the home from it to the start of training."""
    paths, walls = arena.paths, arena.walls
    if len(paths.corners) == 0:
        return True
    return has_path(x, y, arena.home_x, arena.home_y, False, walls, paths) and has_path(
        x, y, arena.start_x, arena.start_y, True, walls, paths
    )


def is_poison_about(held: int, foods: Any) -> bool:
    """Whether food other than that in the gripper is poisonous, or may be as far as the robot knows.

    In most arenas none is, and `past_poison` need not be called.
    """
    suspects = 0
    for k in range(len(foods)):
        if k != held and _is_suspect(foods[k]):
            suspects += 1
    return suspects > 0


def past_poison(
    x: float, y: float, to_x: float, to_y: float, held: int, foods: Any, arena: ArenaMap
) -> tuple[float, float]:
    """Where to drive to get to a place without shoving poison: that place, or beside the poison before it.

    The straight way from (x, y) to (to_x, to_y), in pixels, is clear of walls. Food `held` is in the gripper; `side` of
    the others is changed.
    """
    distance = length(to_x - x, to_y - y)
    # Unit vector to the place; to the left of it is (-ahead_y, ahead_x).
    ahead_x, ahead_y = (to_x - x) / max(distance, 1.0), (to_y - y) / max(distance, 1.0)
    nearest, first = distance + _TOUCH, -1
    for k in range(len(foods)):
        food = foods[k]
        off_x, off_y = food.x - x, food.y - y
        along, aside = off_x * ahead_x + off_y * ahead_y, abs(off_y * ahead_x - off_x * ahead_y)
        near = aside < min(_TOUCH, _BESIDE * length(off_x, off_y))
        if not (near and 0.0 < along < distance + _TOUCH and k != held and _is_suspect(food)):
            food.side = 0
        elif along < nearest:
            nearest, first = along, k
    if first < 0:
        return to_x, to_y
    food = foods[first]
    # Decided once: noise must not change the side while the robot turns.
    if food.side == 0:
        food.side = _side_with_room(x, y, ahead_x, ahead_y, food, arena)
    if food.side == _NO_ROOM:
        return to_x, to_y
    # The tangent to a circle around the poison.
    off_x, off_y = food.x - x, food.y - y
    sine = min(1.0, _BERTH / max(length(off_x, off_y), 1.0))
    cosine = math.sqrt(1.0 - sine * sine)
    sine *= food.side
    return x + cosine * off_x - sine * off_y, y + sine * off_x + cosine * off_y


def _side_with_room(x: float, y: float, ahead_x: float, ahead_y: float, food: Any, arena: ArenaMap) -> int:
    """The side on which the way past poison is shorter, or the other one if a wall is too near there."""
    is_left = (food.y - y) * ahead_x - (food.x - x) * ahead_y > 0.0
    side = _RIGHT if is_left else _LEFT
    for _ in range(2):
        reach = side * _BERTH
        if clearance(food.x - reach * ahead_y, food.y + reach * ahead_x, arena.walls) >= _ROOM:
            return side
        side = -side
    return _NO_ROOM


def _is_suspect(food: Any) -> bool:
    """Whether food must not be shoved home: it is poisonous, or may be as far as the robot knows."""
    unknown = food.known == _UNKNOWN and food.may_be_poisonous
    return bool((unknown or food.known == _POISONOUS) and not food.delivered)
