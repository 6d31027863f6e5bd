"""The overhead camera of a batch: what each frame shows of the robot and the food (see `vision.simulated_camera`).

One robot has the only marker of its kind, so its track never ends. Food becomes tracks in `tracks`.
"""

import math

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import inline, kernel
from khepera_forage.robots.khepera import FOOD_RADIUS, MARKER_LENGTH, MARKER_WIDTH
from khepera_forage.sim.compiled import parameters as setting
from khepera_forage.sim.compiled import rows as at
from khepera_forage.sim.compiled.numbers import lower, normal, upper, word
from khepera_forage.sim.compiled.rows import LANES
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.shapes import PICTURE_HEIGHT, PICTURE_WIDTH

_DRAWS, _32 = np.uint64(at.DRAWS), np.uint64(32)
_X, _Y, _DITHER, _TURN, _CHANCE = (np.uint64(at.DRAW_MARKER + n) for n in range(5))
_FOOD = tuple(np.uint64(n) for n in range(4))
_DEGREES = 180.0 / math.pi


@inline
def covered(x: float, y: float, radius: float, s: NDArray[np.float64], i: int) -> bool:
    """Whether a disc, in mm, touches the robot's marker: `under_plate` of `vision.shapes` for one marker."""
    dx, dy = x - s[at.X * LANES + i], y - s[at.Y * LANES + i]
    c, d = s[at.COS * LANES + i], s[at.SIN * LANES + i]
    ahead = max(abs(dx * c + dy * d) - MARKER_LENGTH / 2, 0.0)
    aside = max(abs(dy * c - dx * d) - MARKER_WIDTH / 2, 0.0)
    return bool(ahead * ahead + aside * aside <= radius * radius)


@inline
def _loses(lost: float, chance: float, rate: float, end: float) -> float:
    """Whether a region is under a loss in this frame."""
    stays = chance >= end
    begins = chance < rate
    return 1.0 if (stays if lost != 0.0 else begins) else 0.0


@kernel
def expose(
    s: NDArray[np.float64],
    f: NDArray[np.float64],
    keys: NDArray[np.uint64],
    foods: int,
    noise: NDArray[np.float64],
) -> None:
    """Take one frame of every world of a block; in the first after a reset nothing is lost."""
    jitter, turned, reversal = (
        noise[setting.POSITION_JITTER],
        noise[setting.HEADING_JITTER],
        noise[setting.REVERSAL_RATE],
    )
    marker_rate, food_rate, end = (
        noise[setting.LOSS_RATE_MARKER],
        noise[setting.LOSS_RATE_FOOD],
        noise[setting.LOSS_END],
    )
    factor, anchor_x, anchor_y = noise[setting.CABLE_FACTOR], noise[setting.ANCHOR_X], noise[setting.ANCHOR_Y]
    for i in range(LANES):
        key, first = keys[at.KEY * LANES + i], keys[at.ROUND * LANES + i] * _DRAWS
        dither, chances = word(key, first + _DITHER), word(key, first + _CHANCE)
        x = s[at.X * LANES + i] / MM_PER_PIXEL + jitter * normal(word(key, first + _X), dither)
        y = s[at.Y * LANES + i] / MM_PER_PIXEL + jitter * normal(word(key, first + _Y), dither >> _32)
        turn = word(key, first + _TURN)
        degrees = s[at.HEADING * LANES + i] * _DEGREES + turned * normal(turn, word(turn, _DITHER))
        degrees += 180.0 if lower(chances) < reversal else 0.0
        degrees = np.rint(degrees)
        degrees -= 360.0 * math.floor(degrees / 360.0)
        # Its own cable never disturbs a marker (3.7).
        lost = (1.0 - s[at.NEW * LANES + i]) * _loses(
            s[at.OWN_LOST * LANES + i], upper(chances), marker_rate, end
        )
        shown = lost == 0.0 and 0.0 < x < PICTURE_WIDTH and 0.0 < y < PICTURE_HEIGHT
        s[at.OWN_LOST * LANES + i] = lost
        s[at.OWN_FOUND * LANES + i] = 1.0 if shown else 0.0
        s[at.OWN_X * LANES + i] = x if shown else s[at.OWN_X * LANES + i]
        s[at.OWN_Y * LANES + i] = y if shown else s[at.OWN_Y * LANES + i]
        s[at.OWN_DEGREES * LANES + i] = degrees if shown else s[at.OWN_DEGREES * LANES + i]
    for food in range(foods):
        base = food * at.FOOD_ROWS * LANES
        stream = np.uint64(at.DRAW_FOOD + food * at.FOOD_DRAWS)
        for i in range(LANES):
            key, first = keys[at.KEY * LANES + i], keys[at.ROUND * LANES + i] * _DRAWS + stream
            dither = word(key, first + _FOOD[2])
            true_x, true_y = f[base + at.FOOD_X * LANES + i], f[base + at.FOOD_Y * LANES + i]
            x = true_x / MM_PER_PIXEL + jitter * normal(word(key, first), dither)
            y = true_y / MM_PER_PIXEL + jitter * normal(word(key, first + _FOOD[1]), dither >> _32)
            # The robot's cable, a straight line to its marker, lies over what it passes.
            to_x, to_y = s[at.X * LANES + i] - anchor_x, s[at.Y * LANES + i] - anchor_y
            dx, dy = true_x - anchor_x, true_y - anchor_y
            t = min(1.0, max(0.0, (dx * to_x + dy * to_y) / max(to_x * to_x + to_y * to_y, 1e-9)))
            dx, dy = dx - t * to_x, dy - t * to_y
            rate = food_rate * (factor if dx * dx + dy * dy <= FOOD_RADIUS * FOOD_RADIUS else 1.0)
            chance = upper(word(key, first + _FOOD[3]))
            lost = (1.0 - s[at.NEW * LANES + i]) * _loses(f[base + at.LOST * LANES + i], chance, rate, end)
            hidden = covered(true_x, true_y, FOOD_RADIUS, s, i)
            inside = 0.0 < x < PICTURE_WIDTH and 0.0 < y < PICTURE_HEIGHT
            f[base + at.LOST * LANES + i] = lost
            f[base + at.SEEN * LANES + i] = 1.0 if inside and lost == 0.0 and not hidden else 0.0
            f[base + at.SEEN_X * LANES + i] = x
            f[base + at.SEEN_Y * LANES + i] = y
    for i in range(LANES):
        s[at.NEW * LANES + i] = 0.0
