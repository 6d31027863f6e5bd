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
from khepera_forage.geometry.known_ways import is_known_clear
from khepera_forage.geometry.straight_ways import is_clear

_REACHED = 1e-6
"""Pixels to a waypoint at which the next one is looked for."""
KEPT = 8.0
"""Pixels (36 mm) for which a robot drives to a waypoint before it looks for a shorter way. Nearer than this to the
waypoint, it looks in every round, so that it turns to the next one in time."""


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


def has_path(
    x: float, y: float, to_x: float, to_y: float, to_lengths: Any, past_home: bool, walls: Any, ways: Ways
) -> bool:
    """Whether there is a path from one place to another.

    Args:
        x: Of the one place.
        y: Of the one place.
        to_x: Of the other place.
        to_y: Of the other place.
        to_lengths: Of the shortest path from each waypoint to the other place.
        past_home: As for `is_clear`.
        walls: `geometry.walls.Wall` records in pixels.
        ways: What is prepared of the arena.
    """
    if is_clear(x, y, to_x, to_y, past_home, walls, ways):
        return True
    for k in range(len(ways.waypoints)):
        point = ways.waypoints[k]
        if to_lengths[k] < math.inf and is_clear(x, y, point.x, point.y, past_home, walls, ways):
            return True
    return False


def next_waypoint(
    x: float,
    y: float,
    to_lengths: Any,
    past_home: bool,
    known: Any,
    to_waypoints: Any,
    walls: Any,
    ways: Ways,
) -> tuple[float, float, float]:
    """Where to drive next on the shortest path from one place to another, to which the straight way is not clear.

    Args:
        x: Of the one place.
        y: Of the one place.
        to_lengths: Of the shortest path from each waypoint to the other place.
        past_home: As for `is_clear`.
        known: `StraightWay` record of the way to the other place; changed in place.
        to_waypoints: `StraightWay` records of the ways to each waypoint; changed in place.
        walls: `geometry.walls.Wall` records in pixels.
        ways: What is prepared of the arena.

    Returns:
        x and y of the waypoint, and the length of the path, which is infinite where there is none.
    """
    number = known.waypoint
    if not _is_kept(x, y, to_lengths, past_home, known, to_waypoints, walls, ways):
        number = _choose_waypoint(x, y, to_lengths, past_home, known.waypoint, to_waypoints, walls, ways)
        if number < 0:
            return x, y, math.inf
        known.waypoint = number
        # While only the home is in the way, the record says where the clear way was examined.
        if known.blocker >= 0:
            known.x, known.y = x, y
    point = ways.waypoints[number]
    return point.x, point.y, length(point.x - x, point.y - y) + to_lengths[number]


def _is_kept(
    x: float,
    y: float,
    to_lengths: Any,
    past_home: bool,
    known: Any,
    to_waypoints: Any,
    walls: Any,
    ways: Ways,
) -> bool:
    """Whether the waypoint last chosen still comes next; arguments as for `next_waypoint`."""
    if known.blocker < 0 or length(x - known.x, y - known.y) >= KEPT:
        return False
    point = ways.waypoints[known.waypoint]
    if length(point.x - x, point.y - y) <= KEPT or to_lengths[known.waypoint] == math.inf:
        return False
    way = to_waypoints[known.waypoint]
    return is_known_clear(way, x, y, point.x, point.y, past_home, walls, ways)


def _choose_waypoint(
    x: float,
    y: float,
    to_lengths: Any,
    past_home: bool,
    last: int,
    to_waypoints: Any,
    walls: Any,
    ways: Ways,
) -> int:
    """Number of the next waypoint on the shortest path; -1 without a path.

    Args:
        x: As for `next_waypoint`; so are the others.
        y: Of the one place.
        to_lengths: Of the shortest path from each waypoint to the other place.
        past_home: As for `is_clear`.
        last: Number of the waypoint last chosen, which is tried first.
        to_waypoints: `StraightWay` records of the ways to each waypoint; changed in place.
        walls: `geometry.walls.Wall` records in pixels.
        ways: What is prepared of the arena.
    """
    best, found = math.inf, -1
    # Whether a way is clear takes longest to find out. From the last waypoint on, few others can be nearer.
    for k in range(-1, len(ways.waypoints)):
        number = last if k < 0 else k
        point = ways.waypoints[number]
        first = length(point.x - x, point.y - y)
        total = first + to_lengths[number]
        # Of two that are equally near, the first one counts, whichever is tried first.
        nearer = total < best or (total == best and number < found)
        if nearer and first > _REACHED:
            way = to_waypoints[number]
            if is_known_clear(way, x, y, point.x, point.y, past_home, walls, ways):
                best, found = total, number
    return found


def find_lengths(x: float, y: float, lengths: Any, past_home: bool, walls: Any, ways: Ways) -> None:
    """Find the lengths of the shortest paths from all waypoints to a place.

    Args:
        x: Of the place.
        y: Of the place.
        lengths: One number a waypoint; changed in place. Infinite without a path: with `past_home` also from waypoints
            in the home, to which only the way home leads.
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


def _is_in_home(point: Any, ways: Ways) -> bool:
    """Whether a waypoint lies in the home or its berth."""
    return length(point.x - ways.home_x, point.y - ways.home_y) < ways.berth
