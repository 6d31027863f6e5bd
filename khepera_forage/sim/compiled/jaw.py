"""The jaw of a batch's robots, step by step: closing on food holds it, opening lets it go."""

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import inline
from khepera_forage.robots.khepera import (
    ARM_ON_FLOOR,
    CONTROL_PERIOD,
    FINGER_THICKNESS,
    FINGER_TIP,
    JAW_ON_FOOD,
    JAW_ROOT,
    JAW_SPEED,
    half_gap,
)
from khepera_forage.sim.compiled import rows as at
from khepera_forage.sim.compiled.gripper import between, floor_free, seen_from
from khepera_forage.sim.compiled.rows import LANES
from khepera_forage.sim.compiled.walls import behind
from khepera_forage.sim.pymunk.khepera import SUBSTEPS

_STEP = JAW_SPEED * CONTROL_PERIOD / SUBSTEPS
_CENTRED = 1.0
"""mm off the middle up to which food counts as between both fingers."""
_TOUCH = 0.5
"""mm by which a finger may stand in a wall."""

half_gap = inline(half_gap)


@inline
def move_jaw(
    s: NDArray[np.float64], f: NDArray[np.float64], foods: int, i: int, walls: NDArray[np.float64]
) -> None:
    """Move the jaw for one step: closing on food holds it, opening lets it go."""
    jaw, target = s[at.JAW * LANES + i], s[at.JAW_TO * LANES + i]
    held = int(s[at.HELD * LANES + i])
    if target == jaw or (held >= 0 and target < jaw):
        return
    new = min(target, jaw + _STEP) if target > jaw else max(target, jaw - _STEP)
    if new > jaw and _opens_into_wall(s, i, new, walls):
        return
    low = s[at.ARM * LANES + i] >= ARM_ON_FLOOR
    if held >= 0:
        if not low and not floor_free(s, f, foods, i):
            return
        c, d = s[at.COS * LANES + i], s[at.SIN * LANES + i]
        u, v = s[at.GRIP_X * LANES + i], s[at.GRIP_Y * LANES + i]
        base = held * at.FOOD_ROWS * LANES + i
        f[base + at.FOOD_X * LANES] = s[at.X * LANES + i] + u * c - v * d
        f[base + at.FOOD_Y * LANES] = s[at.Y * LANES + i] + u * d + v * c
        s[at.HELD * LANES + i] = -1.0
    elif new < jaw and low:
        food = between(s, f, foods, i, new)
        if food >= 0:
            new = JAW_ON_FOOD
            u, v = seen_from(s, f, food, i)
            if abs(v) < _CENTRED:
                s[at.HELD * LANES + i] = food
                s[at.GRIP_X * LANES + i], s[at.GRIP_Y * LANES + i] = u, v
    s[at.JAW * LANES + i] = new


@inline
def _opens_into_wall(s: NDArray[np.float64], i: int, jaw: float, walls: NDArray[np.float64]) -> bool:
    """Whether a finger at this position of the jaw would stand in a wall."""
    aside = half_gap(jaw) + FINGER_THICKNESS
    into = False
    for wall in range(walls.shape[0]):
        for corner in range(4):
            u = FINGER_TIP if corner < 2 else JAW_ROOT
            depth, _, _ = behind(s, i, u, aside if corner & 1 else -aside, walls, wall)
            into = into or depth > _TOUCH
    return into
