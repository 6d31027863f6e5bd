"""What all worlds of a batch have in common, as plain arrays for the kernels: walls, and the sizes of the noise."""

import numpy as np
from numpy.typing import NDArray

from khepera_forage.noise import Noise
from khepera_forage.worlds.arena import Arena
from khepera_forage.worlds.polygon import area, edges, line_of

# Columns of `walls_of`: one end, the way to the other, 1 / its squared length, unit normal and offset of the line.
X1, Y1, EX, EY, SHARE, NORMAL_X, NORMAL_Y, OFFSET = range(8)
# Columns of `noise_of`.
(
    WHEEL_SLIP,
    WHEEL_BIAS,
    PROXIMITY_GAIN,
    PROXIMITY_FLOOR,
    POSITION_JITTER,
    HEADING_JITTER,
    REVERSAL_RATE,
    LOSS_RATE_MARKER,
    LOSS_RATE_FOOD,
    LOSS_END,
    CABLE_FACTOR,
    ANCHOR_X,
    ANCHOR_Y,
    WHEEL_SPEED,
) = range(14)


def walls_of(arena: Arena) -> NDArray[np.float64]:
    """The walls of an arena, one a row."""
    rows = []
    for segment in arena.segments:
        x1, y1, x2, y2 = segment
        ex, ey = x2 - x1, y2 - y1
        rows.append((x1, y1, ex, ey, 1.0 / (ex * ex + ey * ey), *line_of(segment)))
    return np.array(rows)


def edges_of(arena: Arena) -> NDArray[np.float64]:
    """The corners of walls that point into the floor, one (x, y) a row: those that can get between two fingers."""
    corners = []
    for outer, polygon in [(True, arena.walls), *((False, o) for o in arena.obstacles)]:
        sides = edges(polygon)
        turning = 1.0 if (area(polygon) > 0) == outer else -1.0
        for (ax, ay, bx, by), (_, _, cx, cy) in zip(sides, (*sides[1:], sides[0]), strict=True):
            if turning * ((bx - ax) * (cy - by) - (by - ay) * (cx - bx)) < 0:
                corners.append((bx, by))
    return np.array(corners).reshape(-1, 2)


def noise_of(
    noise: Noise, anchor: tuple[float, float], holes: int, wheel_speed: float = 1.0
) -> NDArray[np.float64]:
    """Sizes of the noise, where the cable hangs from (mm), and the share of its speed that a wheel reaches."""
    return np.array(
        (
            noise.wheel_slip,
            noise.wheel_bias,
            noise.proximity_gain,
            noise.proximity_floor,
            noise.position_jitter,
            noise.heading_jitter,
            noise.reversal_rate,
            noise.loss_rate_one_hole if holes == 1 else noise.loss_rate_two_holes,
            noise.loss_rate_food,
            1.0 / noise.loss_rounds,
            noise.cable_loss_factor,
            *anchor,
            wheel_speed,
        )
    )
