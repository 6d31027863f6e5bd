"""Distances of robots and food from walls."""

import math
from typing import Any

from khepera_forage.compilation.decorators import inline
from khepera_forage.robots.khepera import FINGER_THICKNESS, FINGER_TIP, JAW_OPEN, JAW_ROOT, half_gap

_PALM = half_gap(JAW_OPEN) + FINGER_THICKNESS
"""Half the width of the palm, mm."""


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
def gripper_behind(
    robot: Any, i: int, corner: int, wide: float, wall: Any
) -> tuple[float, float, float, float, float]:
    """How far a corner of the gripper is behind a wall.

    A corner counts only if the gripper's own way to it crosses the wall: a finger from its root, the palm from the
    robot's centre. Beyond the end of a wall of an obstacle, a corner is behind its line without being in the obstacle.

    Args:
        robot: A block of robots.
        i: The lane.
        corner: 0 and 1 for the tips of the right and the left finger, 2 and 3 for the ends of the palm.
        wide: From the middle to the outside of the fingers, mm.
        wall: The wall.

    Returns:
        The corner in the robot's frame (mm forward, mm left), its depth behind the wall seen from the robot's side in
        mm (negative if the way to it does not cross the wall), and the wall's unit normal on the robot's side.
    """
    from_u, u = (JAW_ROOT, FINGER_TIP) if corner < 2 else (0.0, JAW_ROOT)
    v = wide if corner < 2 else _PALM
    v = v if corner & 1 else -v
    from_v = v if corner < 2 else 0.0
    cos, sin = robot.cos[i], robot.sin[i]
    nx, ny = wall.normal_x, wall.normal_y
    off = nx * robot.x[i] + ny * robot.y[i] - wall.offset
    side = math.copysign(1.0, off)
    from_x, from_y = from_u * cos - from_v * sin, from_u * sin + from_v * cos
    dx, dy = (u - from_u) * cos - (v - from_v) * sin, (u - from_u) * sin + (v - from_v) * cos
    front = side * (off + nx * from_x + ny * from_y)
    depth = -front - side * (nx * dx + ny * dy)
    if front < 0.0 or depth <= 0.0:
        return u, v, -1.0, side * nx, side * ny
    share = front / max(front + depth, 1e-9)
    x, y = robot.x[i] + from_x + share * dx, robot.y[i] + from_y + share * dy
    t = ((x - wall.x1) * wall.ex + (y - wall.y1) * wall.ey) * wall.share
    return u, v, (depth if 0.0 <= t <= 1.0 else -1.0), side * nx, side * ny
