"""The nearest wall, without looking at every wall in every round. Plain functions, also compiled.

When a robot has moved a little, the nearest wall is still the same one, or, between two walls or beside a corner, the
one that was second. So each time all walls are compared, it is also found out how far the robot may move until a third
one could be nearer.
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
        room: How far it may move before they have to be compared again, pixels; 0 if they always have to.
        number: Number of the nearest wall.
        second: Number of the second nearest one.
    """

    x: float = 0.0
    y: float = 0.0
    room: float = 0.0
    number: int = 0
    second: int = 0


def to_nearest_wall(known: Any, x: float, y: float, walls: Any) -> tuple[float, float]:
    """From a robot to the nearest point of a wall, in pixels.

    Args:
        known: The `NearestWall` record of this robot in this arena; changed in place.
        x: Of the robot, pixels.
        y: Of the robot, pixels.
        walls: `geometry.walls.Wall` records in pixels.
    """
    if not is_still_nearest(known, x, y):
        find_nearest_walls(known, x, y, walls)
    one, other = walls[known.number], walls[known.second]
    one_x, one_y = to_wall(x, y, one.x1, one.y1, one.ex, one.ey, one.share)
    other_x, other_y = to_wall(x, y, other.x1, other.y1, other.ex, other.ey, other.share)
    if is_nearer(one_x, one_y, other_x, other_y):
        return one_x, one_y
    return other_x, other_y


def is_still_nearest(known: Any, x: float, y: float) -> bool:
    """Whether the nearest wall is certainly one of those that are known; arguments as for `to_nearest_wall`."""
    dx, dy, room = x - known.x, y - known.y, known.room
    still: bool = dx * dx + dy * dy < room * room
    return still


def is_nearer(x: float, y: float, other_x: float, other_y: float) -> bool:
    """Whether a way from a robot is not longer than another one."""
    return x * x + y * y <= other_x * other_x + other_y * other_y


def find_nearest_walls(known: Any, x: float, y: float, walls: Any) -> None:
    """Compare all walls; arguments as for `to_nearest_wall`."""
    first = second = third = math.inf
    number = other = 0
    for k in range(len(walls)):
        wall = walls[k]
        dx, dy = to_wall(x, y, wall.x1, wall.y1, wall.ex, wall.ey, wall.share)
        squared = dx * dx + dy * dy
        if squared < first:
            first, second, third = squared, first, second
            number, other = k, number
        elif squared < second:
            second, third, other = squared, second, k
        elif squared < third:
            third = squared
    known.x, known.y, known.number, known.second = x, y, number, other
    # The distance to the nearest wall grows, and that to the third one shrinks, by no more than the robot moves.
    known.room = max(0.0, (math.sqrt(third) - math.sqrt(first)) / 2.0 - _ROUNDING)
