"""Rounds in which a robot touches something, step by step: walls turn it or hold it back, and it pushes food.

Positions are corrected rather than forces integrated. What overlaps is moved apart at once, the weaker yields: food
yields to the robot, and whatever moves to a wall. A wheel holds a robot against 0.6 of its weight and turning it
against the same force at the wheel, so a wall that meets a point further than half a wheel base aside of the middle
turns the robot, and a nearer one shifts it. A robot that cannot go on, because food before it cannot, stays.
A finger drags food along by friction, which keeps food before a closed jaw while the robot turns a little.
Pushed food stops with the robot: at friction 0.3 it would slide on by 1 mm from the fastest push.
"""

import math

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import inline, kernel
from khepera_forage.compilation.packing import pack, packed
from khepera_forage.compilation.trigonometry import cosine_sine
from khepera_forage.robots.khepera import (
    ARM_ON_FLOOR,
    CONTROL_PERIOD,
    FINGER_THICKNESS,
    FINGER_TIP,
    FOOD_RADIUS,
    JAW_OPEN,
    JAW_ROOT,
    RADIUS,
    WHEEL_BASE,
    half_gap,
)
from khepera_forage.sim.compiled import rows as at
from khepera_forage.sim.compiled.gripper import push_out, seen_from
from khepera_forage.sim.compiled.jaw import move_jaw
from khepera_forage.sim.compiled.pushing import push_food
from khepera_forage.sim.compiled.rows import LANES
from khepera_forage.sim.compiled.walls import behind, from_wall, squared_from_wall
from khepera_forage.sim.pymunk.khepera import SUBSTEPS as STEPS

_DT = CONTROL_PERIOD / STEPS
_REPEATS = 4
_PALM = half_gap(JAW_OPEN) + FINGER_THICKNESS
_REACH = FINGER_TIP + 2 * FOOD_RADIUS
"""mm from a robot's centre beyond which a wall is too far to be touched, by food in its gripper either."""
_TOLERATED = 0.5
"""mm of overlap up to which a robot goes on."""
_SETTLED = 1e-6

half_gap = inline(half_gap)


@kernel
def touch(
    s: NDArray[np.float64],
    w: NDArray[np.float64],
    f: NDArray[np.float64],
    foods: int,
    walls: NDArray[np.float64],
    corners: NDArray[np.float64],
) -> None:
    """Carry out the round of every world of a block that touches something."""
    for n in range(pack(w, at.TOUCHES, at.MARK, 0)):
        i = packed(w, at.MARK, n)
        # Away from walls there is none to look at.
        near = walls[: walls.shape[0] if w[at.NEAR_WALL * LANES + i] != 0.0 else 0]
        late = w[at.LAG * LANES + i] * STEPS
        allowed = max(_TOLERATED, _overlap(s, f, foods, i, near))
        for step in range(STEPS):
            share = late if step == 0 else 0.0
            goes = w[at.FORWARD * LANES + i] + share * (
                s[at.LAST_FORWARD * LANES + i] - w[at.FORWARD * LANES + i]
            )
            turns = w[at.TURN * LANES + i] + share * (s[at.LAST_TURN * LANES + i] - w[at.TURN * LANES + i])
            x, y, heading = s[at.X * LANES + i], s[at.Y * LANES + i], s[at.HEADING * LANES + i]
            move_jaw(s, f, foods, i, near)
            turn, forward = turns * _DT, goes * _DT
            c, d = cosine_sine(heading + turn / 2)
            _put(s, i, x + forward * c, y + forward * d, heading + turn)
            moved = 1.0
            for _ in range(_REPEATS):
                moved = _off_walls(s, i, near, corners) + push_food(s, f, foods, i, near, forward, turn)
                if moved < _SETTLED:
                    break
                forward = turn = 0.0
            held_back = moved >= _SETTLED and _overlap(s, f, foods, i, near) > allowed
            if held_back:
                _put(s, i, x, y, heading)
            if step == STEPS - 1:
                s[at.LAST_FORWARD * LANES + i] = 0.0 if held_back else w[at.FORWARD * LANES + i]
                s[at.LAST_TURN * LANES + i] = 0.0 if held_back else w[at.TURN * LANES + i]


@inline
def _put(s: NDArray[np.float64], i: int, x: float, y: float, heading: float) -> None:
    s[at.X * LANES + i], s[at.Y * LANES + i], s[at.HEADING * LANES + i] = x, y, heading
    s[at.COS * LANES + i], s[at.SIN * LANES + i] = cosine_sine(heading)


@inline
def _yield(s: NDArray[np.float64], i: int, u: float, v: float, nx: float, ny: float, depth: float) -> None:
    """Give way to a wall that pushes at (u, v) of the robot's frame, by `depth` mm along (nx, ny)."""
    c, d = s[at.COS * LANES + i], s[at.SIN * LANES + i]
    lever = (u * c - v * d) * ny - (u * d + v * c) * nx
    x, y, heading = s[at.X * LANES + i], s[at.Y * LANES + i], s[at.HEADING * LANES + i]
    if abs(lever) > WHEEL_BASE / 2:
        _put(s, i, x, y, heading + depth / lever)
    else:
        s[at.X * LANES + i], s[at.Y * LANES + i] = x + nx * depth, y + ny * depth


@inline
def _off_walls(
    s: NDArray[np.float64], i: int, walls: NDArray[np.float64], corners: NDArray[np.float64]
) -> float:
    """Move the robot off all walls; returns how far they stood in it, mm."""
    moved = 0.0
    wide = half_gap(s[at.JAW * LANES + i]) + FINGER_THICKNESS
    for wall in range(walls.shape[0]):
        if squared_from_wall(s[at.X * LANES + i], s[at.Y * LANES + i], walls, wall) > _REACH * _REACH:
            continue
        far, nx, ny = from_wall(s[at.X * LANES + i], s[at.Y * LANES + i], walls, wall)
        if far < RADIUS:
            s[at.X * LANES + i] += nx * (RADIUS - far)
            s[at.Y * LANES + i] += ny * (RADIUS - far)
            moved += RADIUS - far
        for corner in range(4):
            u = FINGER_TIP if corner < 2 else JAW_ROOT
            v = wide if corner < 2 else _PALM
            v = v if corner & 1 else -v
            depth, nx, ny = behind(s, i, u, v, walls, wall)
            if depth > 0.0:
                _yield(s, i, u, v, nx, ny, depth)
                moved += depth
        if s[at.HELD * LANES + i] >= 0.0:
            u, v = s[at.GRIP_X * LANES + i], s[at.GRIP_Y * LANES + i]
            c, d = s[at.COS * LANES + i], s[at.SIN * LANES + i]
            far, nx, ny = from_wall(
                s[at.X * LANES + i] + u * c - v * d, s[at.Y * LANES + i] + u * d + v * c, walls, wall
            )
            if far < FOOD_RADIUS:
                _yield(s, i, u, v, nx, ny, FOOD_RADIUS - far)
                moved += FOOD_RADIUS - far
    for corner in range(corners.shape[0]):
        dx, dy = corners[corner, 0] - s[at.X * LANES + i], corners[corner, 1] - s[at.Y * LANES + i]
        c, d = s[at.COS * LANES + i], s[at.SIN * LANES + i]
        u, v = dx * c + dy * d, dy * c - dx * d
        depth, along, aside = push_out(u, v, s[at.JAW * LANES + i], 0.0)
        if depth > 0.0:
            _yield(s, i, u, v, -(along * c - aside * d), -(along * d + aside * c), depth)
            moved += depth
    return moved


@inline
def _overlap(
    s: NDArray[np.float64], f: NDArray[np.float64], foods: int, i: int, walls: NDArray[np.float64]
) -> float:
    """The largest overlap that is left, mm: of the robot with walls or food, of food with walls or other food."""
    worst = 0.0
    held = s[at.HELD * LANES + i]
    low = s[at.ARM * LANES + i] >= ARM_ON_FLOOR
    c, d = s[at.COS * LANES + i], s[at.SIN * LANES + i]
    wide = half_gap(s[at.JAW * LANES + i]) + FINGER_THICKNESS
    for wall in range(walls.shape[0]):
        squared = squared_from_wall(s[at.X * LANES + i], s[at.Y * LANES + i], walls, wall)
        if squared > _REACH * _REACH:
            continue
        worst = max(worst, RADIUS - math.sqrt(squared))
        for corner in range(4):
            u = FINGER_TIP if corner < 2 else JAW_ROOT
            v = wide if corner < 2 else _PALM
            depth, _, _ = behind(s, i, u, v if corner & 1 else -v, walls, wall)
            worst = max(worst, depth)
    for food in range(foods):
        u, v = seen_from(s, f, food, i)
        if u * u + v * v > (FINGER_TIP + 8 * FOOD_RADIUS) ** 2:
            continue
        base = food * at.FOOD_ROWS * LANES + i
        x, y = f[base + at.FOOD_X * LANES], f[base + at.FOOD_Y * LANES]
        if food == held:
            x, y = (
                s[at.X * LANES + i] + s[at.GRIP_X * LANES + i] * c,
                s[at.Y * LANES + i] + s[at.GRIP_X * LANES + i] * d,
            )
        for wall in range(walls.shape[0]):
            worst = max(worst, FOOD_RADIUS - math.sqrt(squared_from_wall(x, y, walls, wall)))
        if food == held:
            continue
        worst = max(worst, RADIUS + FOOD_RADIUS - math.sqrt(u * u + v * v))
        if low:
            depth, _, _ = push_out(u, v, s[at.JAW * LANES + i], FOOD_RADIUS)
            worst = max(worst, depth)
        for other in range(food):
            if other != held:
                there = other * at.FOOD_ROWS * LANES + i
                dx, dy = f[there + at.FOOD_X * LANES] - x, f[there + at.FOOD_Y * LANES] - y
                worst = max(worst, 2 * FOOD_RADIUS - math.sqrt(dx * dx + dy * dy))
    return worst
