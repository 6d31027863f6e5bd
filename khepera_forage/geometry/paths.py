"""Shortest paths around walls: where to drive next to get to a place. Plain functions, also compiled.

An arena is prepared once (`sim.ways`): the waypoints lie around the corners of walls and obstacles that point into the
floor, with room for a robot that turns with food in its gripper, and the lengths of the shortest paths between them are
known. The functions here look up, in every round, which waypoint comes next. An arena without such corners, like those
of the thesis, has no waypoints, and every way is straight.

Robots count in pixels. Lengths from all waypoints to one place are an array with one number a waypoint.
"""

import math
from typing import Any, NamedTuple

from khepera_forage.geometry.angles import length
from khepera_forage.geometry.walls import to_wall

_NEARER = 0.85
"""Share of the distance from an end of a way to the walls at a corner, at which the way may pass that corner."""

_BESIDE_HOME = 0.85
"""The same share for a robot or food beside the home."""
_REACHED = 1e-6
"""Pixels to a waypoint at which the next one is looked for."""


class Spot(NamedTuple):
    """A place in pixels."""

    x: float
    y: float


class Corner(NamedTuple):
    """A corner of walls that points into the floor.

    Attributes:
        x: In pixels.
        y: In pixels.
        before: Number of the wall that ends there.
        after: Number of the wall that begins there.
    """

    x: float
    y: float
    before: int
    after: int


class Ways(NamedTuple):
    """What is prepared of an arena.

    Attributes:
        clearance: Pixels at which a straight way must pass the corners of walls.
        home_x: Centre of the home in pixels.
        home_y: Likewise.
        berth: Pixels from that centre at which a robot on its way to food must pass the home, out of which it would be
            turned.
        corners: `Corner` records.
        waypoints: `Spot` records.
        lengths: Of the shortest path past the home from waypoint a to waypoint b, at a * number of waypoints + b;
            infinite without.
        start_lengths: Of the shortest path past the home from each waypoint to the start; infinite without.
        home_lengths: Of the shortest path from each waypoint to the home; infinite without.
    """

    clearance: float
    home_x: float
    home_y: float
    berth: float
    corners: Any
    waypoints: Any
    lengths: Any
    start_lengths: Any
    home_lengths: Any


NO_WAYS = Ways(0.0, 0.0, 0.0, 0.0, (), (), (), (), ())
"""Of an arena in which every way is straight."""


def is_clear(x: float, y: float, to_x: float, to_y: float, past_home: bool, walls: Any, ways: Ways) -> bool:
    """Whether a robot can drive straight from one place to another.

    A way crosses no wall, and passes every corner at the clearance, or at half its length if that is less: a robot just
    before food drives on to it. It may come about as near to a corner as its ends are to the walls that meet there: so
    a robot that stands beside a wall can leave it, and reach food that lies beside one.

    Args:
        x: Of the one place.
        y: Of the one place.
        to_x: Of the other place.
        to_y: Of the other place.
        past_home: Whether the way must pass the home at its berth. It may come about as near to it as its ends are.
        walls: `geometry.walls.Wall` records in pixels.
        ways: What is prepared of the arena.
    """
    dx, dy = to_x - x, to_y - y
    for k in range(len(walls)):
        wall = walls[k]
        here = wall.normal_x * x + wall.normal_y * y - wall.offset
        there = wall.normal_x * to_x + wall.normal_y * to_y - wall.offset
        if (here > 0.0) != (there > 0.0):
            share = here / (here - there)
            along = (x + share * dx - wall.x1) * wall.ex + (y + share * dy - wall.y1) * wall.ey
            if 0.0 <= along * wall.share <= 1.0:
                return False
    squared = dx * dx + dy * dy
    if past_home and _crosses_home(x, y, dx, dy, squared, ways):
        return False
    for k in range(len(ways.corners)):
        corner_x, corner_y = ways.corners[k].x - x, ways.corners[k].y - y
        along = corner_x * dx + corner_y * dy
        if 0.0 < along < squared:
            distance = math.sqrt(squared)
            aside = abs(corner_x * dy - corner_y * dx) / distance
            if aside < min(ways.clearance, distance / 2.0):
                before, after = walls[ways.corners[k].before], walls[ways.corners[k].after]
                nearest = min(
                    _distance(x, y, before),
                    _distance(x, y, after),
                    _distance(to_x, to_y, before),
                    _distance(to_x, to_y, after),
                )
                if aside < _NEARER * nearest:
                    return False
    return True


def _crosses_home(x: float, y: float, dx: float, dy: float, squared: float, ways: Ways) -> bool:
    """Whether a way passes the home more closely than at its berth."""
    home_x, home_y = ways.home_x - x, ways.home_y - y
    along = home_x * dx + home_y * dy
    if along <= 0.0 or along >= squared:
        return False
    aside = abs(home_x * dy - home_y * dx) / math.sqrt(squared)
    if aside >= ways.berth:
        return False
    return aside < _BESIDE_HOME * min(length(home_x, home_y), length(home_x - dx, home_y - dy))


def _is_in_home(point: Any, ways: Ways) -> bool:
    """Whether a waypoint lies in the home or its berth; only the way home leads there."""
    return length(point.x - ways.home_x, point.y - ways.home_y) < ways.berth


def _distance(x: float, y: float, wall: Any) -> float:
    dx, dy = to_wall(x, y, wall.x1, wall.y1, wall.ex, wall.ey, wall.share)
    return length(dx, dy)


def room_beside(x: float, y: float, to_x: float, to_y: float, past_home: bool, ways: Ways) -> float:
    """How far both ends of a clear way may move before it comes too near to a corner, or the home; negative if it is.

    A way whose ends move no further than this, and no further than to the next wall, stays clear: on its way to a wall
    it would first touch a corner.

    Args:
        x: Of the one end.
        y: Of the one end.
        to_x: Of the other end.
        to_y: Of the other end.
        past_home: As for `is_clear`.
        ways: What is prepared of the arena.
    """
    dx, dy = to_x - x, to_y - y
    share = 1.0 / max(dx * dx + dy * dy, _REACHED)
    nearest = math.inf
    for k in range(len(ways.corners)):
        off_x, off_y = to_wall(ways.corners[k].x, ways.corners[k].y, x, y, dx, dy, share)
        nearest = min(nearest, off_x * off_x + off_y * off_y)
    room = math.sqrt(nearest) - ways.clearance
    if past_home:
        off_x, off_y = to_wall(ways.home_x, ways.home_y, x, y, dx, dy, share)
        room = min(room, length(off_x, off_y) - ways.berth)
    return room


def next_waypoint(
    x: float, y: float, to_x: float, to_y: float, to_lengths: Any, past_home: bool, walls: Any, ways: Ways
) -> tuple[float, float, float]:
    """Where to drive next on the shortest path from one place to another.

    Args:
        x: Of the one place.
        y: Of the one place.
        to_x: Of the other place.
        to_y: Of the other place.
        to_lengths: Of the shortest path from each waypoint to the other place.
        past_home: As for `is_clear`.
        walls: `geometry.walls.Wall` records in pixels.
        ways: What is prepared of the arena.

    Returns:
        x and y of the next waypoint, which is the other place itself where the way is clear, and the length of the
        path. Where there is no path: the other place, and infinity.
    """
    if len(ways.corners) == 0 or is_clear(x, y, to_x, to_y, past_home, walls, ways):
        return to_x, to_y, length(to_x - x, to_y - y)
    return waypoint_around(x, y, to_x, to_y, to_lengths, past_home, walls, ways)


def waypoint_around(
    x: float, y: float, to_x: float, to_y: float, to_lengths: Any, past_home: bool, walls: Any, ways: Ways
) -> tuple[float, float, float]:
    """Where to drive next if the straight way is not clear: arguments and result as for `next_waypoint`."""
    # Whether a way is clear takes longest to find out. So waypoints are tried from the shortest path on.
    tried, last = -math.inf, -1
    for _ in range(len(ways.waypoints)):
        best, nearest = math.inf, -1
        for k in range(len(ways.waypoints)):
            point = ways.waypoints[k]
            first = length(point.x - x, point.y - y)
            total = first + to_lengths[k]
            untried = total > tried or (total == tried and k > last)
            allowed = first > _REACHED and not (past_home and _is_in_home(point, ways))
            if allowed and untried and total < best:
                best, nearest = total, k
        if nearest < 0:
            break
        point = ways.waypoints[nearest]
        if is_clear(x, y, point.x, point.y, past_home, walls, ways):
            return point.x, point.y, best
        tried, last = best, nearest
    return to_x, to_y, math.inf


def find_lengths(x: float, y: float, lengths: Any, past_home: bool, walls: Any, ways: Ways) -> None:
    """Find the lengths of the shortest paths from all waypoints to a place.

    Args:
        x: Of the place.
        y: Of the place.
        lengths: One number a waypoint; changed in place.
        past_home: As for `is_clear`.
        walls: `geometry.walls.Wall` records in pixels.
        ways: What is prepared of the arena.
    """
    count = len(ways.waypoints)
    for a in range(count):
        lengths[a] = math.inf
    for b in range(count):
        point = ways.waypoints[b]
        allowed = not (past_home and _is_in_home(point, ways))
        if allowed and is_clear(point.x, point.y, x, y, past_home, walls, ways):
            last = length(x - point.x, y - point.y)
            for a in range(count):
                lengths[a] = min(lengths[a], ways.lengths[a * count + b] + last)
