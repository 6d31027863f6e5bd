"""Walls as a robot of a batch meets them: how far off they are, and which of its points stand behind one."""

import math

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import inline
from khepera_forage.sim.compiled import parameters as setting
from khepera_forage.sim.compiled import rows as at
from khepera_forage.sim.compiled.rows import LANES


@inline
def from_wall(x: float, y: float, walls: NDArray[np.float64], wall: int) -> tuple[float, float, float]:
    """Distance of a place from a wall, and the way from the wall to it as a unit vector."""
    ex, ey = walls[wall, setting.EX], walls[wall, setting.EY]
    x, y = x - walls[wall, setting.X1], y - walls[wall, setting.Y1]
    t = min(1.0, max(0.0, (x * ex + y * ey) * walls[wall, setting.SHARE]))
    dx, dy = x - t * ex, y - t * ey
    far = max(math.sqrt(dx * dx + dy * dy), 1e-9)
    return far, dx / far, dy / far


@inline
def squared_from_wall(x: float, y: float, walls: NDArray[np.float64], wall: int) -> float:
    """The square of that distance: enough to tell that a wall is far, and without a root or a division."""
    ex, ey = walls[wall, setting.EX], walls[wall, setting.EY]
    x, y = x - walls[wall, setting.X1], y - walls[wall, setting.Y1]
    t = min(1.0, max(0.0, (x * ex + y * ey) * walls[wall, setting.SHARE]))
    dx, dy = x - t * ex, y - t * ey
    return float(dx * dx + dy * dy)


@inline
def behind(
    s: NDArray[np.float64], i: int, u: float, v: float, walls: NDArray[np.float64], wall: int
) -> tuple[float, float, float]:
    """How far a point of the robot's frame is behind a wall, seen from the robot's side, and the way back."""
    c, d = s[at.COS * LANES + i], s[at.SIN * LANES + i]
    x, y = s[at.X * LANES + i], s[at.Y * LANES + i]
    nx, ny, offset = walls[wall, setting.NORMAL_X], walls[wall, setting.NORMAL_Y], walls[wall, setting.OFFSET]
    side = math.copysign(1.0, nx * x + ny * y - offset)
    x, y = x + u * c - v * d, y + u * d + v * c
    t = (x - walls[wall, setting.X1]) * walls[wall, setting.EX] + (y - walls[wall, setting.Y1]) * walls[
        wall, setting.EY
    ]
    t *= walls[wall, setting.SHARE]
    depth = -side * (nx * x + ny * y - offset)
    return (depth if 0.0 <= t <= 1.0 else -1.0), side * nx, side * ny
