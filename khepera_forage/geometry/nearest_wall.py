"""The nearest wall, without looking at every wall in every round. Plain functions, also compiled.

When a robot has moved a little, the nearest wall is still the same one, or, between two walls or beside a corner, the
one that was second. So each time all walls are compared, it is also found out how far the robot may move until a third
one could be nearer. Blocks of worlds look at the four nearest walls in place of two: they then have to compare all
walls less often, and to look at two more takes them little time.
"""

import math
from dataclasses import dataclass
from typing import Any

from khepera_forage.geometry.walls import to_wall

_ROUNDING = 1e-3
"""Pixels by which the room is made smaller: compiled worlds keep it in single precision, to save memory."""


@dataclass(slots=True)
class NearestWall:
    """Which walls are nearest to a robot.

    Attributes:
        x: Where the robot was when all walls were compared, pixels.
        y: Likewise.
        room_of_two: How far it may move while the nearest wall is certainly the first or the second, pixels; 0 if that
            is never certain.
        room_of_four: How far it may move while it is certainly one of all four.
        first: Number of the nearest wall.
        second: Number of the second nearest one.
        third: Likewise. In a room of three walls, again one of those.
        fourth: Likewise.
    """

    x: float = 0.0
    y: float = 0.0
    room_of_two: float = 0.0
    room_of_four: float = 0.0
    first: int = 0
    second: int = 0
    third: int = 0
    fourth: int = 0


def to_nearest_wall(known: Any, x: float, y: float, walls: Any) -> tuple[float, float]:
    """From a robot to the nearest point of a wall, in pixels.

    Args:
        known: The `NearestWall` record of this robot in this arena; changed in place.
        x: Of the robot, pixels.
        y: Of the robot, pixels.
        walls: `geometry.walls.Wall` records in pixels.
    """
    if not _is_within(known, x, y, known.room_of_two):
        find_nearest_walls(known, x, y, walls)
    one, other = walls[known.first], walls[known.second]
    one_x, one_y = to_wall(x, y, one.x1, one.y1, one.ex, one.ey, one.share)
    other_x, other_y = to_wall(x, y, other.x1, other.y1, other.ex, other.ey, other.share)
    if is_nearer(one_x, one_y, other_x, other_y):
        return one_x, one_y
    return other_x, other_y


def is_among_four(known: Any, x: float, y: float) -> bool:
    """Whether the nearest wall is certainly one of the four that are known; arguments as for `to_nearest_wall`."""
    return _is_within(known, x, y, known.room_of_four)


def _is_within(known: Any, x: float, y: float, room: float) -> bool:
    dx, dy = x - known.x, y - known.y
    within: bool = dx * dx + dy * dy < room * room
    return within


def is_nearer(x: float, y: float, other_x: float, other_y: float) -> bool:
    """Whether a way from a robot is not longer than another one."""
    return x * x + y * y <= other_x * other_x + other_y * other_y


def find_nearest_walls(known: Any, x: float, y: float, walls: Any) -> None:
    """Compare all walls; arguments as for `to_nearest_wall`."""
    nearest = second = third = fourth = fifth = math.inf
    a = b = c = d = 0  # numbers of the four nearest walls
    for k in range(len(walls)):
        wall = walls[k]
        dx, dy = to_wall(x, y, wall.x1, wall.y1, wall.ex, wall.ey, wall.share)
        squared = dx * dx + dy * dy
        if squared < nearest:
            nearest, second, third, fourth, fifth = squared, nearest, second, third, fourth
            a, b, c, d = k, a, b, c
        elif squared < second:
            second, third, fourth, fifth, b, c, d = squared, second, third, fourth, k, b, c
        elif squared < third:
            third, fourth, fifth, c, d = squared, third, fourth, k, c
        elif squared < fourth:
            fourth, fifth, d = squared, fourth, k
        elif squared < fifth:
            fifth = squared
    known.x, known.y, known.first, known.second, known.third, known.fourth = x, y, a, b, c, d
    known.room_of_two, known.room_of_four = _room(nearest, third), _room(nearest, fifth)


def _room(nearest: float, next_one: float) -> float:
    """How far a robot may move until another wall could be nearer; arguments are squared distances."""
    # The distance to the nearest wall grows, and that to another one shrinks, by no more than the robot moves.
    return max(0.0, (math.sqrt(next_one) - math.sqrt(nearest)) / 2.0 - _ROUNDING)
