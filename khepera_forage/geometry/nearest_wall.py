"""The nearest wall, without looking at every wall in every round. Plain functions, also compiled.

When a robot has moved a little, the nearest wall is still the same. So each time it is found, it is also found out how
far the robot may move until another wall could be nearer.
"""

import math
from dataclasses import dataclass
from typing import Any

from khepera_forage.geometry.walls import to_wall

_SAME = 1e-12
"""Squared pixels within which two walls end at the same place."""
_ROUNDING = 1e-3
"""Pixels by which the room is made smaller: compiled worlds keep it in single precision, to save memory."""


@dataclass(slots=True)
class NearestWall:
    """Which wall is nearest to a robot; where two walls meet that are equally near, one of them.

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
    if not is_still_nearest(known, x, y):
        find_nearest_wall(known, x, y, walls)
    wall = walls[known.number]
    return to_wall(x, y, wall.x1, wall.y1, wall.ex, wall.ey, wall.share)


def is_still_nearest(known: Any, x: float, y: float) -> bool:
    """Whether the nearest wall is certainly the one that is known; arguments as for `to_nearest_wall`."""
    dx, dy, room = x - known.x, y - known.y, known.room
    return bool(dx * dx + dy * dy < room * room)


def find_nearest_wall(known: Any, x: float, y: float, walls: Any) -> None:
    """Compare all walls; arguments as for `to_nearest_wall`."""
    nearest, number = math.inf, 0
    for k in range(len(walls)):
        wall = walls[k]
        dx, dy = to_wall(x, y, wall.x1, wall.y1, wall.ex, wall.ey, wall.share)
        squared = dx * dx + dy * dy
        if squared < nearest:
            nearest, number = squared, k
    distance, room = math.sqrt(nearest), math.inf
    for k in range(len(walls)):
        wall = walls[k]
        off = abs(wall.normal_x * x + wall.normal_y * y - wall.offset)
        if k != number and off < distance + 2.0 * room:
            room = min(room, _room_to(x, y, wall, walls[number], distance))
    known.x, known.y, known.number = x, y, number
    known.room = max(0.0, room - _ROUNDING)


def _room_to(x: float, y: float, wall: Any, nearest: Any, distance: float) -> float:
    """How far a robot may move until another wall could be nearer than the nearest one.

    Args:
        x: Of the robot, pixels.
        y: Of the robot, pixels.
        wall: The other one.
        nearest: The nearest one.
        distance: To the nearest one.
    """
    dx, dy = to_wall(x, y, wall.x1, wall.y1, wall.ex, wall.ey, wall.share)
    # The distance to the one wall grows, and that to the other shrinks, by no more than the robot moves.
    apart = (math.sqrt(dx * dx + dy * dy) - distance) / 2.0
    along = (x - wall.x1) * wall.ex + (y - wall.y1) * wall.ey
    beyond = -along if along < 0.0 else along - 1.0 / wall.share
    if beyond <= 0.0 or not _ends_at(nearest, x + dx, y + dy):
        return float(apart)
    # Where two walls meet, neither is nearer than the other one until the robot is beside it.
    return float(max(apart, beyond * math.sqrt(wall.share)))


def _ends_at(wall: Any, x: float, y: float) -> bool:
    """Whether a wall has an end at a place."""
    first_x, first_y = x - wall.x1, y - wall.y1
    last_x, last_y = first_x - wall.ex, first_y - wall.ey
    return bool(min(first_x * first_x + first_y * first_y, last_x * last_x + last_y * last_y) < _SAME)
