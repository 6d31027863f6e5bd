"""The end of a round: held food comes along, the optical barrier, arm and jaw, and the eight infra-reds."""

import math

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import inline, kernel
from khepera_forage.compilation.packing import pack, packed
from khepera_forage.robots.khepera import ARM_ON_FLOOR, FOOD_RADIUS, PRESENT
from khepera_forage.robots.proximity import _AT_RANGE as AT_RANGE
from khepera_forage.robots.proximity import _GAIN as GAIN
from khepera_forage.robots.proximity import _OFFSET as OFFSET
from khepera_forage.robots.proximity import HIDDEN_BY_ARM, MAX_READING, RANGE, REACH, SENSORS
from khepera_forage.sim.compiled import parameters as setting
from khepera_forage.sim.compiled import rows as at
from khepera_forage.sim.compiled.bodies import filled
from khepera_forage.sim.compiled.gripper import in_barrier
from khepera_forage.sim.compiled.numbers import lower, upper, word
from khepera_forage.sim.compiled.rows import LANES

_DRAWS = np.uint64(at.DRAWS)
_FIRST, _ONE = np.uint64(at.DRAW_PROXIMITY), np.uint64(1)
_SENSORS = np.array(SENSORS)
_FRONT = 6
"""Sensors that a lowered arm hides."""
_LOW, _SPAN = float(HIDDEN_BY_ARM[0]), float(HIDDEN_BY_ARM[1] - HIDDEN_BY_ARM[0] + 1)
# The lanes in reach of a wall or of food are packed into the scratch rows: what is there in the robot's frame.
_AHEAD, _ASIDE, _ALONG, _ACROSS, _SQUARE, _LANE, _NEAR, _HIDDEN = (at.SCRATCH + n for n in range(8))


@kernel
def end_round(s: NDArray[np.float64], f: NDArray[np.float64], foods: int) -> None:
    """Take held food along, and read barrier, arm and jaw."""
    for i in range(LANES):
        s[at.PRESENT * LANES + i] = 0.0
        s[at.ARM_READ * LANES + i] = math.floor(s[at.ARM * LANES + i] + 0.5)
        s[at.JAW_READ * LANES + i] = math.floor(s[at.JAW * LANES + i] + 0.5)
    for food in range(foods):
        base = food * at.FOOD_ROWS * LANES
        for i in range(LANES):
            held = s[at.HELD * LANES + i]
            c, d = s[at.COS * LANES + i], s[at.SIN * LANES + i]
            x, y = s[at.X * LANES + i], s[at.Y * LANES + i]
            u, v = s[at.GRIP_X * LANES + i], s[at.GRIP_Y * LANES + i]
            food_x = x + u * c - v * d if held == food else f[base + at.FOOD_X * LANES + i]
            food_y = y + u * d + v * c if held == food else f[base + at.FOOD_Y * LANES + i]
            f[base + at.FOOD_X * LANES + i] = food_x
            f[base + at.FOOD_Y * LANES + i] = food_y
            dx, dy = food_x - x, food_y - y
            crossed = in_barrier(dx * c + dy * d, dy * c - dx * d, s[at.JAW * LANES + i])
            reached = held == food or (held < 0.0 and s[at.ARM * LANES + i] >= ARM_ON_FLOOR)
            s[at.PRESENT * LANES + i] = PRESENT if crossed and reached else s[at.PRESENT * LANES + i]


@kernel
def cast(
    s: NDArray[np.float64],
    w: NDArray[np.float64],
    f: NDArray[np.float64],
    foods: int,
    walls: NDArray[np.float64],
) -> None:
    """Noise-free readings of all sensors: the function `cast` of `robots.proximity` for every world of a block."""
    for row in range(at.PROXIMITY, at.PROXIMITY + 8):
        for i in range(LANES):
            s[row * LANES + i] = 0.0
    for wall in range(walls.shape[0]):
        nx, ny, offset = (
            walls[wall, setting.NORMAL_X],
            walls[wall, setting.NORMAL_Y],
            walls[wall, setting.OFFSET],
        )
        for i in range(LANES):
            off = abs(nx * s[at.X * LANES + i] + ny * s[at.Y * LANES + i] - offset)
            _mark(s, w, i, off < REACH)
        sees, count = _pack(w)
        _cast_wall(s, w, walls, wall, sees, count)
    for food in range(foods):
        base = food * at.FOOD_ROWS * LANES
        for i in range(LANES):
            dx = f[base + at.FOOD_X * LANES + i] - s[at.X * LANES + i]
            dy = f[base + at.FOOD_Y * LANES + i] - s[at.Y * LANES + i]
            lifted = s[at.HELD * LANES + i] == food and s[at.ARM * LANES + i] < ARM_ON_FLOOR
            near = dx * dx + dy * dy < (REACH + FOOD_RADIUS) ** 2 and not lifted
            _mark(s, w, i, near)
        sees, count = _pack(w)
        _cast_food(s, w, f, base, sees, count)


@inline
def _mark(s: NDArray[np.float64], w: NDArray[np.float64], i: int, near: bool) -> None:
    """Note whether something is in reach: in one row or the other, as the arm hides the front sensors or not."""
    hidden = s[at.ARM * LANES + i] >= ARM_ON_FLOOR
    w[_NEAR * LANES + i] = 1.0 if near and not hidden else 0.0
    w[_HIDDEN * LANES + i] = 1.0 if near and hidden else 0.0


@inline
def _pack(w: NDArray[np.float64]) -> tuple[int, int]:
    """Write the numbers of the marked lanes side by side, those first whose arm does not hide the front sensors.

    Returns:
        How many these are, and how many there are in all.
    """
    sees = pack(w, _NEAR, _LANE, 0)
    return sees, pack(w, _HIDDEN, _LANE, sees)


@inline
def _cast_wall(
    s: NDArray[np.float64],
    w: NDArray[np.float64],
    walls: NDArray[np.float64],
    wall: int,
    sees: int,
    count: int,
) -> None:
    """One wall as some sensors of the packed lanes see it."""
    x1, y1, ex, ey = walls[wall, 0], walls[wall, 1], walls[wall, 2], walls[wall, 3]
    share = walls[wall, setting.SHARE]
    for n in range(count):
        i = packed(w, _LANE, n)
        c, d = s[at.COS * LANES + i], s[at.SIN * LANES + i]
        dx, dy = x1 - s[at.X * LANES + i], y1 - s[at.Y * LANES + i]
        w[_AHEAD * LANES + n] = dx * c + dy * d
        w[_ASIDE * LANES + n] = dy * c - dx * d
        w[_ALONG * LANES + n] = ex * c + ey * d
        w[_ACROSS * LANES + n] = ey * c - ex * d
    for sensor in range(8):
        reached = sees if sensor < _FRONT else count
        forward, left = _SENSORS[sensor, 0], _SENSORS[sensor, 1]
        axis, across = _SENSORS[sensor, 2], _SENSORS[sensor, 3]
        for n in range(filled(reached)):
            along, aside = w[_ALONG * LANES + n], w[_ACROSS * LANES + n]
            dx, dy = w[_AHEAD * LANES + n] - forward, w[_ASIDE * LANES + n] - left
            t = min(1.0, max(0.0, -(dx * along + dy * aside) * share))
            w[_SQUARE * LANES + n] = _reading(dx + t * along, dy + t * aside, axis, across, 0.0)
        _keep(s, w, sensor, reached)


@inline
def _cast_food(
    s: NDArray[np.float64],
    w: NDArray[np.float64],
    f: NDArray[np.float64],
    base: int,
    sees: int,
    count: int,
) -> None:
    """One food object as some sensors of the packed lanes see it."""
    for n in range(count):
        i = packed(w, _LANE, n)
        c, d = s[at.COS * LANES + i], s[at.SIN * LANES + i]
        dx = f[base + at.FOOD_X * LANES + i] - s[at.X * LANES + i]
        dy = f[base + at.FOOD_Y * LANES + i] - s[at.Y * LANES + i]
        w[_AHEAD * LANES + n] = dx * c + dy * d
        w[_ASIDE * LANES + n] = dy * c - dx * d
    for sensor in range(8):
        reached = sees if sensor < _FRONT else count
        forward, left = _SENSORS[sensor, 0], _SENSORS[sensor, 1]
        axis, across = _SENSORS[sensor, 2], _SENSORS[sensor, 3]
        for n in range(filled(reached)):
            dx, dy = w[_AHEAD * LANES + n] - forward, w[_ASIDE * LANES + n] - left
            w[_SQUARE * LANES + n] = _reading(dx, dy, axis, across, FOOD_RADIUS)
        _keep(s, w, sensor, reached)


@inline
def _reading(dx: float, dy: float, axis: float, across: float, radius: float) -> float:
    """Of one sensor, of an obstacle (dx, dy) mm from it: `response` times the share for its bearing."""
    along = dx * axis + dy * across
    distance = math.sqrt(dx * dx + dy * dy)
    near = max(distance - radius, 0.0) + OFFSET
    # One division for both: 1 / near ** 2 and along / distance.
    inverse = 1.0 / (near * near * distance)
    response = min(float(MAX_READING), GAIN * (inverse * distance - AT_RANGE))
    reading = response * (2.0 * along * (inverse * near * near) - 1.0)
    seen = along > 0.0 and distance - radius < RANGE and 2.0 * along > distance
    return reading if seen else 0.0


@inline
def _keep(s: NDArray[np.float64], w: NDArray[np.float64], sensor: int, count: int) -> None:
    """Keep the largest reading of one sensor."""
    row = (at.PROXIMITY + sensor) * LANES
    for n in range(count):
        i = packed(w, _LANE, n)
        s[row + i] = max(s[row + i], w[_SQUARE * LANES + n])


@kernel
def measure(s: NDArray[np.float64], keys: NDArray[np.uint64], noise: NDArray[np.float64]) -> None:
    """Readings as a robot reports them: `measured` of `robots.proximity` for every world of a block."""
    gain, floor = noise[setting.PROXIMITY_GAIN], noise[setting.PROXIMITY_FLOOR]
    for pair in range(4):
        number = _FIRST + np.uint64(pair)
        one, two = (at.PROXIMITY + 2 * pair) * LANES, (at.PROXIMITY + 2 * pair + 1) * LANES
        front = 2 * pair < _FRONT
        for i in range(LANES):
            bits = word(keys[at.KEY * LANES + i], keys[at.ROUND * LANES + i] * _DRAWS + number)
            hidden = front and s[at.ARM * LANES + i] >= ARM_ON_FLOOR
            s[one + i] = _measured(s[one + i], hidden, gain, floor, upper(bits))
            s[two + i] = _measured(s[two + i], hidden, gain, floor, lower(bits))


@inline
def _measured(clean: float, hidden: bool, gain: float, floor: float, draw: float) -> float:
    reading = min(clean * (1.0 + gain * (2.0 * draw - 1.0)), float(MAX_READING))
    low = (floor + 1.0) * draw if floor > 0.0 else reading
    reading = low if reading <= floor else reading
    behind = _LOW + _SPAN * (draw if gain > 0.0 else 0.5)
    return math.floor(behind if hidden else reading)
