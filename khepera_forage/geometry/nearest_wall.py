"""The nearest wall, without looking at every wall in every round. Plain functions, also compiled.

When a robot has moved a little, the nearest wall is still the same. So each time it is found, it is also found out how
far the robot may move until another wall could be nearer.
"""

import math
from dataclasses import dataclass
from typing import Any

from khepera_forage.geometry.walls import to_wall

_ROUNDING = 1e-3
"""Pixels by which the room is made smaller: compiled worlds keep it in single precision, to save memory."""


@dataclass(slots=True)
class NearestWall:
    """Which wall is nearest to a robot.

    Attributes:
        x: Where the robot was when all walls were compared, pixels.
        y: Likewise.
        room: How far it may move before they have to be compared again, pixels; 0 if they always have to.
        number: Number of the nearest wall.
    """

    x: float = 0.0
    y: float = 0.0
    room: float = 0.0
    number: int = 0


def to_nearest_wall(known: Any, x: float, y: float, walls: Any) -> tuple[float, float]:
    """From a robot to the nearest point of a wall, in pixels.

    Args:
        known: The `NearestWall` record of this robot in this arena; changed in place.
        x: Of the robot, pixels.
        y: Of the robot, pixels.
        walls: `geometry.walls.Wall` records in pixels.
    """
    dx, dy, room = x - known.x, y - known.y, known.room
    if dx * dx + dy * dy >= room * room:
        find_nearest_wall(known, x, y, walls)
    wall = walls[known.number]
    return to_wall(x, y, wall.x1, wall.y1, wall.ex, wall.ey, wall.share)


def find_nearest_wall(known: Any, x: float, y: float, walls: Any) -> None:
    """Compare all walls; arguments as for `to_nearest_wall`."""
    nearest = second = math.inf
    for k in range(len(walls)):
        wall = walls[k]
        dx, dy = to_wall(x, y, wall.x1, wall.y1, wall.ex, wall.ey, wall.share)
        squared = dx * dx + dy * dy
        if squared < nearest:
            nearest, second, known.number = squared, nearest, k
        elif squared < second:
            second = squared
    known.x, known.y = x, y
    # The distance to the one wall grows, and that to the other shrinks, by no more than the robot moves.
    known.room = max(0.0, (math.sqrt(second) - math.sqrt(nearest)) / 2.0 - _ROUNDING)
