"""What all worlds of a batch have in common, as plain arrays for the kernels: walls, and the sizes of the noise."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.geometry.polygon import area, edges, line_of
from khepera_forage.noise import Noise
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.layout_checks import cable_anchor

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


class Setting(NamedTuple):
    """What holds for every world of a batch.

    Attributes:
        foods: Food objects in each.
        walls: See `walls_of`.
        corners: See `edges_of`.
        noise: See `noise_of`.
    """

    foods: int
    walls: NDArray[np.float64]
    corners: NDArray[np.float64]
    noise: NDArray[np.float64]


def setting_of(
    arena: Arena, foods: int, noise: Noise | None = None, holes: int = 2, wheel_speed: float = 1.0
) -> Setting:
    """The setting of worlds in one arena.

    Args:
        arena: Every world's.
        foods: Food objects in each.
        noise: The laboratory's troubles by default.
        holes: Of the robots' marker, 1 or 2.
        wheel_speed: Share of the commanded speed that wheels reach.
    """
    sizes = noise_of(
        Noise.laboratory() if noise is None else noise, cable_anchor([arena]), holes, wheel_speed
    )
    return Setting(foods, walls_of(arena), edges_of(arena), sizes)


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
