"""What a robot knows of straight ways, so that it need not look at every wall in every round. Also compiled.

In most rounds nothing has changed. A wall that stands between a robot and its home still stands there when the robot
has moved a little: what blocked the way is looked at first. And each time a way is found clear, it is also found out
how far its ends may move until the next time.
"""

import math
from dataclasses import dataclass
from typing import Any

from khepera_forage.geometry.angles import length
from khepera_forage.geometry.straight_ways import NEARER, blocks, crosses_home, find_blocker, nearest_end
from khepera_forage.geometry.walls import to_wall

_SHORTEST = 1e-6
"""Squared pixels below which a way has no direction."""
_FARTHEST = (1.0 - NEARER) / (1.0 + NEARER)
"""The most that `_room_near_walls` can be, as a share of the distance aside."""
_ROUNDING = 1e-3
"""Pixels by which rooms are made smaller: compiled worlds keep what is known in single precision, to save memory."""


@dataclass(slots=True)
class StraightWay:
    """What is known of the straight way from a robot to one place, the home left aside.

    Attributes:
        x: Where the robot was when a clear way was examined, or, while the way is blocked, when the waypoint was
            chosen; pixels. Infinite if none has been chosen since the way was clear.
        y: Likewise.
        to_x: Where the place was when a clear way was examined.
        to_y: Likewise.
        room: How far each may move sideways before a clear way has to be examined again, pixels; 0 if it always has to.
            A robot that drives along the way need not examine it again.
        blocker: What blocked the way, see `find_blocker`; -1 if it was clear, or is not known.
        waypoint: Number of the waypoint that came next when one was last chosen.
    """

    x: float = 0.0
    y: float = 0.0
    to_x: float = 0.0
    to_y: float = 0.0
    room: float = 0.0
    blocker: int = -1
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
    if known.blocker >= 0:
        if blocks(known.blocker, x, y, to_x, to_y, walls, ways):
            return False
        examine(known, x, y, to_x, to_y, walls, ways)
    elif max(_moved(known, x, y), _square(to_x - known.to_x, to_y - known.to_y)) >= known.room * known.room:
        examine(known, x, y, to_x, to_y, walls, ways)
    return bool(known.blocker < 0) and not (past_home and crosses_home(x, y, to_x, to_y, ways))


def examine(known: Any, x: float, y: float, to_x: float, to_y: float, walls: Any, ways: Any) -> None:
    """Find out whether a way is clear, and for how long that will be known; arguments as for `is_known_clear`."""
    was_clear = known.blocker < 0
    known.blocker = find_blocker(x, y, to_x, to_y, walls, ways)
    if known.blocker < 0:
        known.x, known.y, known.to_x, known.to_y = x, y, to_x, to_y
        known.room = max(0.0, room_beside(x, y, to_x, to_y, walls, ways) - _ROUNDING)
    elif was_clear:
        known.x = known.y = math.inf


def room_beside(x: float, y: float, to_x: float, to_y: float, walls: Any, ways: Any) -> float:
    """How far each end of a clear way may move sideways, in pixels, while the way certainly stays clear.

    Args:
        x: Of the one end.
        y: Of the one end.
        to_x: Of the other end.
        to_y: Of the other end.
        walls: `geometry.walls.Wall` records in pixels.
        ways: `geometry.paths.Ways`.
    """
    dx, dy = to_x - x, to_y - y
    squared = _square(dx, dy)
    share, half = 1.0 / max(squared, _SHORTEST), math.sqrt(squared) / 2.0
    room = math.inf
    for k in range(len(ways.corners)):
        corner = ways.corners[k]
        aside = length(*to_wall(corner.x, corner.y, x, y, dx, dy, share))
        # A corner may be passed at the clearance, or at half the length of the way, which can grow at both ends.
        beside = max(aside - ways.clearance, (aside - half) / 2.0)
        if beside < min(room, _FARTHEST * aside):
            beside = max(beside, _room_near_walls(aside, x, y, to_x, to_y, corner, walls))
        room = min(room, beside)
    if room <= 0.0:
        return float(room)
    nearest = room * room
    for k in range(len(walls)):
        wall = walls[k]
        here = wall.normal_x * x + wall.normal_y * y - wall.offset
        there = wall.normal_x * to_x + wall.normal_y * to_y - wall.offset
        # Most walls are too far away to matter: both ends lie on one side of its line, neither of them near.
        if here * there > 0.0 and min(here * here, there * there) >= nearest:
            continue
        # Two lines that do not cross are nearest at one of their ends; a wall ends where another one starts.
        off_x, off_y = to_wall(x, y, wall.x1, wall.y1, wall.ex, wall.ey, wall.share)
        nearest = min(nearest, _square(off_x, off_y))
        off_x, off_y = to_wall(to_x, to_y, wall.x1, wall.y1, wall.ex, wall.ey, wall.share)
        nearest = min(nearest, _square(off_x, off_y))
        off_x, off_y = to_wall(wall.x1, wall.y1, x, y, dx, dy, share)
        nearest = min(nearest, _square(off_x, off_y))
    return math.sqrt(nearest)


def _room_near_walls(
    aside: float, x: float, y: float, to_x: float, to_y: float, corner: Any, walls: Any
) -> float:
    """The room that a way has because it may pass a corner as closely as its ends are to the walls that meet there.

    Where the way passes the corner, it is no further from these walls than from the corner, which lies on them. An end
    that moves along the way to there is never further from them than it was, or than it is then.

    Args:
        aside: At which the way passes the corner.
        x: As for `room_beside`; so are the others.
        y: Of the one end.
        to_x: Of the other end.
        to_y: Of the other end.
        corner: `geometry.paths.Corner`.
        walls: `geometry.walls.Wall` records in pixels.
    """
    end = math.sqrt(nearest_end(x, y, to_x, to_y, corner, walls))
    return (aside - NEARER * max(aside, end)) / (1.0 + NEARER)


def _moved(known: Any, x: float, y: float) -> float:
    """Squared distance by which the robot has moved sideways since a clear way was examined."""
    dx, dy, far_x, far_y = x - known.x, y - known.y, known.to_x - known.x, known.to_y - known.y
    along, squared = dx * far_x + dy * far_y, _square(far_x, far_y)
    if along <= 0.0 or along >= squared:
        return _square(dx, dy)
    aside = dx * far_y - dy * far_x
    return float(aside * aside / squared)


def _square(x: float, y: float) -> float:
    return x * x + y * y
