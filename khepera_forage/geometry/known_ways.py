"""What a robot knows of straight ways, so that it need not look at every wall in every round. Also compiled.

In most rounds nothing has changed: a wall between a robot and its home still stands there when the robot has moved a
little. So each time a way is examined, it is also found out how far its ends may move until the next time.
"""

import math
from dataclasses import dataclass
from typing import Any

from khepera_forage.geometry.angles import length
from khepera_forage.geometry.straight_ways import (
    NEARER,
    crosses_home,
    is_crossed,
    is_unobstructed,
    nearest_end,
    passed_aside,
)
from khepera_forage.geometry.walls import to_wall

_SHORTEST = 1e-6
"""Squared pixels below which a way has no direction."""
_ROUNDING = 1e-3
"""Pixels by which rooms are made smaller: compiled worlds keep what is known in single precision, to save memory."""


@dataclass(slots=True)
class StraightWay:
    """What is known of the straight way from a robot to one place, the home left aside.

    Attributes:
        x: Where the robot was when the way was examined, pixels.
        y: Likewise.
        to_x: Where the place was.
        to_y: Likewise.
        room: How far each may move before the way has to be examined again, pixels; 0 if it always has to. From a clear
            way, they may move sideways: a robot that drives along the way need not examine it again.
        clear: Whether the way is clear.
        waypoint: Number of the waypoint that came next when it last was not.
    """

    x: float = 0.0
    y: float = 0.0
    to_x: float = 0.0
    to_y: float = 0.0
    room: float = 0.0
    clear: bool = False
    waypoint: int = 0


def is_known_clear(
    known: Any, x: float, y: float, to_x: float, to_y: float, past_home: bool, walls: Any, ways: Any
) -> bool:
    """The same as `is_clear`, from what is known of this way.

    Args:
        known: The `StraightWay` record of this way in this arena; changed in place.
        x: As for `is_clear`; so are the others.
        y: Of the one place.
        to_x: Of the other place.
        to_y: Of the other place.
        past_home: Whether the way must pass the home at its berth.
        walls: `geometry.walls.Wall` records in pixels.
        ways: `geometry.paths.Ways`.
    """
    if max(_moved(known, x, y), _square(to_x - known.to_x, to_y - known.to_y)) >= known.room * known.room:
        examine(known, x, y, to_x, to_y, walls, ways)
    return bool(known.clear) and not (past_home and crosses_home(x, y, to_x, to_y, ways))


def examine(known: Any, x: float, y: float, to_x: float, to_y: float, walls: Any, ways: Any) -> None:
    """Find out whether a way is clear, and for how long that will be known; arguments as for `is_known_clear`."""
    known.x, known.y, known.to_x, known.to_y = x, y, to_x, to_y
    known.clear = is_unobstructed(x, y, to_x, to_y, walls, ways)
    ends = x, y, to_x, to_y
    room = room_beside(*ends, walls, ways) if known.clear else room_behind(*ends, walls, ways)
    known.room = max(0.0, room - _ROUNDING)


def room_beside(x: float, y: float, to_x: float, to_y: float, walls: Any, ways: Any) -> float:
    """How far a clear way may move sideways while it certainly stays clear; 0 or less if that is not known.

    Within this distance of the way there is no wall, and no corner within the clearance more.

    Args:
        x: Of the one end.
        y: Of the one end.
        to_x: Of the other end.
        to_y: Of the other end.
        walls: `geometry.walls.Wall` records in pixels.
        ways: `geometry.paths.Ways`.
    """
    dx, dy = to_x - x, to_y - y
    share = 1.0 / max(_square(dx, dy), _SHORTEST)
    nearest = math.inf
    for k in range(len(ways.corners)):
        off_x, off_y = to_wall(ways.corners[k].x, ways.corners[k].y, x, y, dx, dy, share)
        nearest = min(nearest, _square(off_x, off_y))
    room = math.sqrt(nearest) - ways.clearance
    if room <= 0.0:
        return float(room)
    nearest = room * room
    for k in range(len(walls)):
        # Two lines that do not cross are nearest at one of their ends; a wall ends where another one starts.
        wall = walls[k]
        off_x, off_y = to_wall(x, y, wall.x1, wall.y1, wall.ex, wall.ey, wall.share)
        nearest = min(nearest, _square(off_x, off_y))
        off_x, off_y = to_wall(to_x, to_y, wall.x1, wall.y1, wall.ex, wall.ey, wall.share)
        nearest = min(nearest, _square(off_x, off_y))
        off_x, off_y = to_wall(wall.x1, wall.y1, x, y, dx, dy, share)
        nearest = min(nearest, _square(off_x, off_y))
    return math.sqrt(nearest)


def room_behind(x: float, y: float, to_x: float, to_y: float, walls: Any, ways: Any) -> float:
    """How far both ends of a way may move while something certainly stays in it; arguments as for `room_beside`."""
    room = 0.0
    for k in range(len(walls)):
        if is_crossed(x, y, to_x, to_y, walls[k]):
            room = max(room, _room_across(x, y, to_x, to_y, walls[k]))
    for k in range(len(ways.corners)):
        aside = passed_aside(x, y, to_x, to_y, ways.corners[k], walls, ways)
        if aside >= 0.0:
            room = max(room, _room_at_corner(x, y, to_x, to_y, aside, ways.corners[k], walls, ways))
    return room


def _room_across(x: float, y: float, to_x: float, to_y: float, wall: Any) -> float:
    """How far the ends of a way may move while it crosses a wall.

    The ends must stay on the two sides of the wall, and the ends of the wall on the two sides of the way.
    """
    dx, dy = to_x - x, to_y - y
    here = abs(wall.normal_x * x + wall.normal_y * y - wall.offset)
    there = abs(wall.normal_x * to_x + wall.normal_y * to_y - wall.offset)
    first = abs((wall.x1 - x) * dy - (wall.y1 - y) * dx)
    last = abs((wall.x1 + wall.ex - x) * dy - (wall.y1 + wall.ey - y) * dx)
    return float(min(here, there, min(first, last) / length(dx, dy)))


def _room_at_corner(
    x: float, y: float, to_x: float, to_y: float, aside: float, corner: Any, walls: Any, ways: Any
) -> float:
    """How far the ends of a way may move while it passes a corner too closely, at the distance `aside`.

    If both move by r, that distance grows by at most r, the length of the way shrinks by at most 2 r, the distance of
    its ends from the walls by at most r, and the corner must not get before or behind it.
    """
    dx, dy, corner_x, corner_y = to_x - x, to_y - y, corner.x - x, corner.y - y
    distance = length(dx, dy)
    along = corner_x * dx + corner_y * dy
    room = min(ways.clearance - aside, (distance / 2.0 - aside) / 2.0)
    nearest = nearest_end(x, y, to_x, to_y, corner, walls)
    room = min(room, (NEARER * nearest - aside) / (1.0 + NEARER))
    most = distance + 2.0 * ways.clearance
    before = along / (2.0 * length(corner_x, corner_y) + most)
    behind = (distance * distance - along) / (2.0 * length(corner_x - dx, corner_y - dy) + most)
    return float(min(room, before, behind))


def _moved(known: Any, x: float, y: float) -> float:
    """Squared distance by which the robot has moved since a way was examined; sideways, if the way was clear."""
    dx, dy, far_x, far_y = x - known.x, y - known.y, known.to_x - known.x, known.to_y - known.y
    along, squared = dx * far_x + dy * far_y, _square(far_x, far_y)
    if not known.clear or along <= 0.0 or along >= squared:
        return _square(dx, dy)
    aside = dx * far_y - dy * far_x
    return float(aside * aside / squared)


def _square(x: float, y: float) -> float:
    return x * x + y * y
