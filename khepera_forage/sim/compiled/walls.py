"""Distances of robots and food from walls."""

import math
from typing import Any

from khepera_forage.compilation.decorators import inline


@inline
def from_wall(x: float, y: float, wall: Any) -> tuple[float, float, float]:
    """Distance of a place from a wall in mm, and the unit vector from the wall to the place."""
    ex, ey = wall.ex, wall.ey
    x, y = x - wall.x1, y - wall.y1
    t = min(1.0, max(0.0, (x * ex + y * ey) * wall.share))
    dx, dy = x - t * ex, y - t * ey
    distance = max(math.sqrt(dx * dx + dy * dy), 1e-9)
    return distance, dx / distance, dy / distance


@inline
def squared_from_wall(x: float, y: float, wall: Any) -> float:
    """The square of the distance: enough to see that a wall is far, without a root or a division."""
    ex, ey = wall.ex, wall.ey
    x, y = x - wall.x1, y - wall.y1
    t = min(1.0, max(0.0, (x * ex + y * ey) * wall.share))
    dx, dy = x - t * ex, y - t * ey
    return float(dx * dx + dy * dy)


@inline
def behind(robot: Any, i: int, u: float, v: float, wall: Any) -> tuple[float, float, float]:
    """Depth of a point of the robot behind a wall.

    Args:
        robot: A block of robots.
        i: The lane.
        u: The point in the robot's frame, mm forward.
        v: mm left.
        wall: The wall.

    Returns:
        How far the point is behind the wall, seen from the robot's side, in mm (negative in front of the wall), and the
        unit normal of the wall on the robot's side.
    """
    cos, sin = robot.cos[i], robot.sin[i]
    x, y = robot.x[i], robot.y[i]
    nx, ny, offset = wall.normal_x, wall.normal_y, wall.offset
    side = math.copysign(1.0, nx * x + ny * y - offset)
    x, y = x + u * cos - v * sin, y + u * sin + v * cos
    t = (x - wall.x1) * wall.ex + (y - wall.y1) * wall.ey
    t *= wall.share
    depth = -side * (nx * x + ny * y - offset)
    return (depth if 0.0 <= t <= 1.0 else -1.0), side * nx, side * ny
