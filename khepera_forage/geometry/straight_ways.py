"""Straight ways between two places: whether a robot can drive them. Plain functions, also compiled.

Robots count in pixels. Walls are `geometry.walls.Wall` records, ways are `geometry.paths.Ways`.
"""

import math
from typing import Any

from khepera_forage.geometry.angles import length
from khepera_forage.geometry.walls import to_wall

NEARER = 0.85
"""Share of the distance from an end of a way to the walls at a corner, at which the way may pass that corner."""
_BESIDE_HOME = 0.85
"""The same share for a robot or food beside the home."""


def is_clear(x: float, y: float, to_x: float, to_y: float, past_home: bool, walls: Any, ways: Any) -> bool:
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
        ways: `geometry.paths.Ways`.
    """
    if past_home and crosses_home(x, y, to_x, to_y, ways):
        return False
    return is_unobstructed(x, y, to_x, to_y, walls, ways)


def is_unobstructed(x: float, y: float, to_x: float, to_y: float, walls: Any, ways: Any) -> bool:
    """Whether a way crosses no wall and passes every corner at the clearance."""
    for k in range(len(walls)):
        if is_crossed(x, y, to_x, to_y, walls[k]):
            return False
    for k in range(len(ways.corners)):
        aside = passed_aside(x, y, to_x, to_y, ways.corners[k], walls, ways)
        if aside >= 0.0:
            return False
    return True


def crosses_home(x: float, y: float, to_x: float, to_y: float, ways: Any) -> bool:
    """Whether a way passes the home more closely than at its berth; arguments as for `is_clear`."""
    dx, dy = to_x - x, to_y - y
    home_x, home_y = ways.home_x - x, ways.home_y - y
    squared = dx * dx + dy * dy
    along = home_x * dx + home_y * dy
    if along <= 0.0 or along >= squared:
        return False
    aside = abs(home_x * dy - home_y * dx) / math.sqrt(squared)
    if aside >= ways.berth:
        return False
    return bool(aside < _BESIDE_HOME * min(length(home_x, home_y), length(home_x - dx, home_y - dy)))


def is_crossed(x: float, y: float, to_x: float, to_y: float, wall: Any) -> bool:
    """Whether a way crosses a wall."""
    here = wall.normal_x * x + wall.normal_y * y - wall.offset
    there = wall.normal_x * to_x + wall.normal_y * to_y - wall.offset
    if (here > 0.0) == (there > 0.0):
        return False
    share = here / (here - there)
    crossing_x, crossing_y = x + share * (to_x - x) - wall.x1, y + share * (to_y - y) - wall.y1
    along = crossing_x * wall.ex + crossing_y * wall.ey
    return bool(0.0 <= along * wall.share <= 1.0)


def passed_aside(x: float, y: float, to_x: float, to_y: float, corner: Any, walls: Any, ways: Any) -> float:
    """The distance at which a way passes a corner too closely; -1 if it does not."""
    dx, dy = to_x - x, to_y - y
    corner_x, corner_y = corner.x - x, corner.y - y
    squared, along = dx * dx + dy * dy, corner_x * dx + corner_y * dy
    if along <= 0.0 or along >= squared:
        return -1.0
    distance = math.sqrt(squared)
    aside = abs(corner_x * dy - corner_y * dx) / distance
    if aside >= min(ways.clearance, distance / 2.0):
        return -1.0
    return aside if aside < NEARER * nearest_end(x, y, to_x, to_y, corner, walls) else -1.0


def nearest_end(x: float, y: float, to_x: float, to_y: float, corner: Any, walls: Any) -> float:
    """The distance of the nearer end of a way from the walls that meet at a corner."""
    before, after = walls[corner.before], walls[corner.after]
    return min(
        _distance(x, y, before),
        _distance(x, y, after),
        _distance(to_x, to_y, before),
        _distance(to_x, to_y, after),
    )


def _distance(x: float, y: float, wall: Any) -> float:
    dx, dy = to_wall(x, y, wall.x1, wall.y1, wall.ex, wall.ey, wall.share)
    return length(dx, dy)
