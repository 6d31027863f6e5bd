"""The beginning of a round: the arm's move, what the wheels will travel, and where that leads if nothing resists."""

import math

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import inline, kernel
from khepera_forage.compilation.packing import pack, packed
from khepera_forage.compilation.trigonometry import cosine_sine
from khepera_forage.robots.khepera import (
    ARM_ON_FLOOR,
    ARM_SPEED,
    CONTROL_PERIOD,
    FINGER_TIP,
    JAW_SPEED,
    PULSE,
    SPEED_UNIT,
    WHEEL_BASE,
)
from khepera_forage.sim.compiled import parameters as setting
from khepera_forage.sim.compiled import rows as at
from khepera_forage.sim.compiled.gripper import room_below
from khepera_forage.sim.compiled.numbers import normal, word
from khepera_forage.sim.compiled.rows import LANES
from khepera_forage.sim.pymunk.khepera import FINE_TRAVEL, SUBSTEPS

_32 = np.uint64(32)
_DRAWS = np.uint64(at.DRAWS)
_FIRST, _SECOND, _DITHER = (np.uint64(at.DRAW_WHEELS + n) for n in range(3))
_ARM_STEP, _JAW_STEP = ARM_SPEED * CONTROL_PERIOD, JAW_SPEED * CONTROL_PERIOD
_PULSES = SPEED_UNIT * CONTROL_PERIOD / PULSE


@inline
def towards(target: float, value: float, step: float) -> float:
    """A value moved by at most `step` towards a target."""
    return min(target, value + step) if target > value else max(target, value - step)


@kernel
def begin_round(
    s: NDArray[np.float64],
    w: NDArray[np.float64],
    f: NDArray[np.float64],
    keys: NDArray[np.uint64],
    foods: int,
    noise: NDArray[np.float64],
) -> None:
    """Move the arms, draw the wheels' slip, and work out the free end of the round for every world of a block."""
    slip = noise[setting.WHEEL_SLIP]
    for i in range(LANES):
        arm, target = s[at.ARM * LANES + i], s[at.ARM_TO * LANES + i]
        moved = towards(target, arm, _ARM_STEP)
        w[at.SCRATCH * LANES + i] = 1.0 if moved >= ARM_ON_FLOOR and arm < ARM_ON_FLOOR else 0.0
        s[at.ARM * LANES + i] = moved
    for n in range(pack(w, at.SCRATCH, at.MARK, 0)):
        i = packed(w, at.MARK, n)
        if not room_below(s, f, foods, i):
            s[at.ARM * LANES + i] = ARM_ON_FLOOR - 1.0
    for i in range(LANES):
        key = keys[at.KEY * LANES + i]
        first = keys[at.ROUND * LANES + i] * _DRAWS
        dither = word(key, first + _DITHER)
        left_normal = normal(word(key, first + _FIRST), dither)
        right_normal = normal(word(key, first + _SECOND), dither >> _32)
        left = s[at.LEFT * LANES + i] * SPEED_UNIT * (1.0 + s[at.BIAS_LEFT * LANES + i] + slip * left_normal)
        right = (
            s[at.RIGHT * LANES + i] * SPEED_UNIT * (1.0 + s[at.BIAS_RIGHT * LANES + i] + slip * right_normal)
        )
        forward, turn = (left + right) / 2, (right - left) / WHEEL_BASE
        # A jaw that holds food closes no further; one that opens from it is followed step by step.
        held = s[at.HELD * LANES + i] >= 0.0
        jaw, jaw_to = s[at.JAW * LANES + i], s[at.JAW_TO * LANES + i]
        w[at.FREE_JAW * LANES + i] = jaw if held else towards(jaw_to, jaw, _JAW_STEP)
        travel = (abs(forward) + abs(turn) * FINGER_TIP) * CONTROL_PERIOD
        w[at.TRAVEL * LANES + i] = travel
        w[at.TOUCHES * LANES + i] = 1.0 if held and jaw_to > jaw else 0.0
        w[at.FORWARD * LANES + i] = forward
        w[at.TURN * LANES + i] = turn
        w[at.NEAR_WALL * LANES + i] = 0.0
        w[at.NEAR_FOOD * LANES + i] = 0.0


@kernel
def aim(s: NDArray[np.float64], w: NDArray[np.float64]) -> None:
    """Where the round ends if nothing resists."""
    for i in range(LANES):
        travel = w[at.TRAVEL * LANES + i]
        still = travel == 0.0 and w[at.FREE_JAW * LANES + i] == s[at.JAW * LANES + i]
        wall, food = w[at.NEAR_WALL * LANES + i] != 0.0, w[at.NEAR_FOOD * LANES + i] != 0.0
        steps = max(float(SUBSTEPS), math.ceil(travel / FINE_TRAVEL)) if wall else float(SUBSTEPS)
        lag = 1.0 / steps if (wall or food) and not still else 0.0
        w[at.LAG * LANES + i] = lag
        forward = w[at.FORWARD * LANES + i] + lag * (
            s[at.LAST_FORWARD * LANES + i] - w[at.FORWARD * LANES + i]
        )
        turn = w[at.TURN * LANES + i] + lag * (s[at.LAST_TURN * LANES + i] - w[at.TURN * LANES + i])
        heading = s[at.HEADING * LANES + i]
        # The direction in the middle of the round does for all of it: the chord ends where the arc does.
        c, d = cosine_sine(heading + turn * CONTROL_PERIOD / 2)
        end = heading + turn * CONTROL_PERIOD
        end_c, end_s = cosine_sine(end)
        w[at.FREE_X * LANES + i] = s[at.X * LANES + i] + forward * c * CONTROL_PERIOD
        w[at.FREE_Y * LANES + i] = s[at.Y * LANES + i] + forward * d * CONTROL_PERIOD
        w[at.FREE_HEADING * LANES + i] = end
        w[at.FREE_COS * LANES + i] = end_c
        w[at.FREE_SIN * LANES + i] = end_s


@kernel
def glide(s: NDArray[np.float64], w: NDArray[np.float64]) -> None:
    """Take the free end of the round where nothing is touched, or where nothing moves."""
    for i in range(LANES):
        still = (
            w[at.TRAVEL * LANES + i] == 0.0
            and s[at.LAST_FORWARD * LANES + i] == 0.0
            and s[at.LAST_TURN * LANES + i] == 0.0
            and w[at.FREE_JAW * LANES + i] == s[at.JAW * LANES + i]
        )
        opens = s[at.HELD * LANES + i] >= 0.0 and s[at.JAW_TO * LANES + i] > s[at.JAW * LANES + i]
        touches = w[at.TOUCHES * LANES + i] != 0.0 and (opens or not still)
        w[at.TOUCHES * LANES + i] = 1.0 if touches else 0.0
        s[at.PULSES_LEFT * LANES + i] += s[at.LEFT * LANES + i] * _PULSES
        s[at.PULSES_RIGHT * LANES + i] += s[at.RIGHT * LANES + i] * _PULSES
        _take(s, w, i, at.X, at.FREE_X, touches)
        _take(s, w, i, at.Y, at.FREE_Y, touches)
        _take(s, w, i, at.HEADING, at.FREE_HEADING, touches)
        _take(s, w, i, at.COS, at.FREE_COS, touches)
        _take(s, w, i, at.SIN, at.FREE_SIN, touches)
        _take(s, w, i, at.JAW, at.FREE_JAW, touches)
        _take(s, w, i, at.LAST_FORWARD, at.FORWARD, touches)
        _take(s, w, i, at.LAST_TURN, at.TURN, touches)


@inline
def _take(s: NDArray[np.float64], w: NDArray[np.float64], i: int, row: int, end: int, touches: bool) -> None:
    """Replace a number where nothing is touched."""
    # Both are read first: a condition that reads one of them only is a branch, and no lane is like its neighbour.
    stays, goes = s[row * LANES + i], w[end * LANES + i]
    s[row * LANES + i] = stays if touches else goes
