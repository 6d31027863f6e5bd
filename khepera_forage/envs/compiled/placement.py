"""Random starts and food places (`task.placement.random_layout`), drawn by a world's own numbers inside the kernel."""

import math

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import inline, kernel
from khepera_forage.compilation.trigonometry import cosine_sine
from khepera_forage.robots.khepera import FINGER_TIP, FOOD_RADIUS, RADIUS, half_gap
from khepera_forage.sim.compiled import parameters as setting
from khepera_forage.sim.compiled import rows as body
from khepera_forage.sim.compiled.numbers import lower, upper, word
from khepera_forage.sim.compiled.rows import LANES
from khepera_forage.task.placement import _MARGIN, _TRIES, FOOD_CLEARANCE, FOOD_SPACING
from khepera_forage.task.states import CLOSE_TO_FOOD
from khepera_forage.vision.scene import MM_PER_PIXEL

_ONE, _TWO = np.uint64(1), np.uint64(2)
_WIDE = half_gap(200) + _MARGIN
_APART = CLOSE_TO_FOOD * MM_PER_PIXEL + _MARGIN
# Columns of the arena's array, mm: bounds, home.
LEFT, BOTTOM, RIGHT, TOP, HOME_X, HOME_Y, HOME_RADIUS = range(7)


@inline
def clearance(x: float, y: float, walls: NDArray[np.float64]) -> float:
    """Distance from a place to the nearest wall, mm; negative outside the free floor (`Arena.clearance`)."""
    least = np.inf
    inside = False
    for wall in range(walls.shape[0]):
        x1, y1, ex, ey = walls[wall, 0], walls[wall, 1], walls[wall, 2], walls[wall, 3]
        t = min(1.0, max(0.0, ((x - x1) * ex + (y - y1) * ey) * walls[wall, setting.SHARE]))
        dx, dy = x - x1 - t * ex, y - y1 - t * ey
        least = min(least, dx * dx + dy * dy)
        # The walls of obstacles are crossed twice by whoever is outside them.
        if (y1 > y) != (y1 + ey > y) and x < x1 + (y - y1) * ex / ey:
            inside = not inside
    return math.sqrt(least) if inside else -math.sqrt(least)


@inline
def _stands_free(x: float, y: float, heading: float, walls: NDArray[np.float64]) -> bool:
    if clearance(x, y, walls) < RADIUS + _MARGIN:
        return False
    c, d = cosine_sine(heading)
    for corner in range(4):
        u = FINGER_TIP if corner < 2 else FINGER_TIP / 2
        v = _WIDE if corner & 1 else -_WIDE
        if clearance(x + u * c - v * d, y + u * d + v * c, walls) < _MARGIN:
            return False
    return True


@inline
def _outside_home(x: float, y: float, radius: float, arena: NDArray[np.float64]) -> bool:
    dx, dy = x - arena[HOME_X], y - arena[HOME_Y]
    return bool(math.sqrt(dx * dx + dy * dy) > arena[HOME_RADIUS] + radius)


@kernel
def place_all(
    f: NDArray[np.float64],
    i: int,
    foods: int,
    key: np.uint64,
    walls: NDArray[np.float64],
    arena: NDArray[np.float64],
) -> tuple[float, float, float]:
    """Draw a start, and write food places into the food's rows; a start that is not finite says there is no room."""
    x1, y1 = arena[LEFT], arena[BOTTOM]
    width, height = arena[RIGHT] - x1, arena[TOP] - y1
    number = np.uint64(0)
    for _ in range(_TRIES):
        bits, more = word(key, number), word(key, number + _ONE)
        number += _TWO
        x, y = x1 + width * upper(bits), y1 + height * lower(bits)
        heading = -math.pi + 2.0 * math.pi * upper(more)
        if not (_outside_home(x, y, RADIUS, arena) and _stands_free(x, y, heading, walls)):
            continue
        placed = 0
        for _ in range(50 * foods):
            bits = word(key, number)
            number += _ONE
            food_x, food_y = x1 + width * upper(bits), y1 + height * lower(bits)
            if not (
                x1 + FOOD_CLEARANCE <= food_x <= arena[RIGHT] - FOOD_CLEARANCE
                and y1 + FOOD_CLEARANCE <= food_y <= arena[TOP] - FOOD_CLEARANCE
            ):
                continue
            far = math.sqrt((food_x - x) ** 2 + (food_y - y) ** 2)
            free = far > _APART and _outside_home(food_x, food_y, FOOD_RADIUS, arena)
            for other in range(placed):
                there = other * body.FOOD_ROWS * LANES + i
                dx, dy = f[there + body.FOOD_X * LANES] - food_x, f[there + body.FOOD_Y * LANES] - food_y
                free = free and math.sqrt(dx * dx + dy * dy) >= FOOD_SPACING
            if free and clearance(food_x, food_y, walls) >= FOOD_CLEARANCE:
                there = placed * body.FOOD_ROWS * LANES + i
                f[there + body.FOOD_X * LANES], f[there + body.FOOD_Y * LANES] = food_x, food_y
                placed += 1
                if placed == foods:
                    return x, y, heading
    return np.nan, np.nan, np.nan
