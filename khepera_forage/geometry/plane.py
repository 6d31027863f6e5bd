"""Angles, lengths, and walls in the plane. Plain functions, also compiled.

A wall is a *record*: an object with the fields of `Wall`. In compiled code that is a record of a numpy array.
"""

import math
from functools import lru_cache
from typing import Any, NamedTuple

from khepera_forage.geometry.polygon import Corner, Segment, edges, line_of


def bearing_of(x: float, y: float) -> float:
    """Direction of a vector, degrees -180..180 counter-clockwise from the x axis."""
    return math.degrees(math.atan2(y, x))


def turn_to(direction: float, orientation: float) -> float:
    """Degrees to turn from an orientation to a direction, -180..180, left positive."""
    return (direction - orientation + 180.0) % 360.0 - 180.0


def length(x: float, y: float) -> float:
    """Length of a vector."""
    return math.sqrt(x * x + y * y)


def arcsine(value: float) -> float:
    """The angle in degrees, -90..90, that has this sine."""
    return math.degrees(math.asin(value))


def cosine_sine(radians: float) -> tuple[float, float]:
    """Cosine and sine of an angle in radians."""
    return math.cos(radians), math.sin(radians)


def heading_of(orientation: int) -> tuple[float, float]:
    """Cosine and sine of an orientation in degrees."""
    return cosine_sine(math.radians(orientation))


class Wall(NamedTuple):
    """One straight wall.

    Attributes:
        x1: One end.
        y1: One end.
        ex: From that end to the other.
        ey: From that end to the other.
        share: 1 / its squared length.
        normal_x: Unit normal of its line.
        normal_y: Unit normal of its line.
        offset: Of the line along its normal.
        y2: The other end: `y1 + ey` but for rounding.
        polygon: 0 for the outer wall, from 1 for obstacles. Walls of one polygon follow one another.
    """

    x1: float
    y1: float
    ex: float
    ey: float
    share: float
    normal_x: float
    normal_y: float
    offset: float
    y2: float
    polygon: int


def wall_of(segment: Segment, polygon: int = 0) -> Wall:
    """The wall along a line segment (x1, y1, x2, y2)."""
    x1, y1, x2, y2 = segment
    ex, ey = x2 - x1, y2 - y1
    return Wall(x1, y1, ex, ey, 1.0 / (ex * ex + ey * ey), *line_of(segment), y2, polygon)


@lru_cache(maxsize=256)
def walls_of(polygons: tuple[tuple[Corner, ...], ...]) -> tuple[Wall, ...]:
    """The walls of an enclosure.

    Args:
        polygons: Corners of the outer wall, then those of each obstacle.
    """
    return tuple(wall_of(side, k) for k, corners in enumerate(polygons) for side in edges(corners))


def to_wall(x: float, y: float, wall: Any) -> tuple[float, float]:
    """From a place to the nearest point of a wall."""
    dx, dy = wall.x1 - x, wall.y1 - y
    t = min(1.0, max(0.0, -(dx * wall.ex + dy * wall.ey) * wall.share))
    return dx + t * wall.ex, dy + t * wall.ey


def from_wall(x: float, y: float, wall: Any) -> tuple[float, float, float]:
    """Distance of a place from a wall, and the unit vector from the wall to the place."""
    dx, dy = to_wall(x, y, wall)
    distance = max(math.sqrt(dx * dx + dy * dy), 1e-9)
    return distance, -dx / distance, -dy / distance


def is_near(x: float, y: float, wall: Any, reach: float) -> bool:
    """Whether a wall is within reach of a place."""
    # The distance from its line is cheap, and mostly shows that it is not.
    if abs(wall.normal_x * x + wall.normal_y * y - wall.offset) >= reach:
        return False
    dx, dy = to_wall(x, y, wall)
    return bool(dx * dx + dy * dy < reach * reach)


def to_nearest_wall(x: float, y: float, walls: Any) -> tuple[float, float]:
    """From a place to the nearest point of a wall."""
    nearest, wall_x, wall_y = math.inf, 0.0, 0.0
    for k in range(len(walls)):
        dx, dy = to_wall(x, y, walls[k])
        squared = dx * dx + dy * dy
        if squared < nearest:
            nearest, wall_x, wall_y = squared, dx, dy
    return wall_x, wall_y


def clearance(x: float, y: float, walls: Any) -> float:
    """Distance from a place to the nearest wall; negative outside the outer wall and inside obstacles."""
    least = math.inf
    free, odd, polygon = True, False, 0
    for k in range(len(walls)):
        wall = walls[k]
        if wall.polygon != polygon:
            free = free and odd == (polygon == 0)
            odd, polygon = False, wall.polygon
        dx, dy = to_wall(x, y, wall)
        squared = dx * dx + dy * dy
        if squared < least:
            least = squared
        # A ray to the right of the place crosses a polygon an odd number of times from inside. A wall ends exactly
        # where the next one starts: with y1 + ey, a ray through that corner could cross one wall too many.
        if (wall.y1 > y) != (wall.y2 > y) and x < wall.x1 + (y - wall.y1) * wall.ex / wall.ey:
            odd = not odd
    free = free and odd == (polygon == 0)
    return math.sqrt(least) if free else -math.sqrt(least)
