"""Rounds in which a robot touches something, step by step: walls turn it or hold it back, and it pushes food.

Positions are corrected rather than forces integrated. What overlaps is moved apart at once, the weaker yields: food
yields to the robot, and whatever moves to a wall. A wheel holds a robot against 0.6 of its weight and turning it
against the same force at the wheel, so a wall that meets a point further than half a wheel base aside of the middle
turns the robot, and a nearer one shifts it. A robot that cannot go on, because food before it cannot, stays.
Pushed food stops with the robot: at friction 0.3 it would slide on by 1 mm from the fastest push.
"""

import math

import numpy as np
from numpy.typing import NDArray

from khepera_forage.robots.khepera import (
    ARM_ON_FLOOR,
    CONTROL_PERIOD,
    FINGER_THICKNESS,
    FINGER_TIP,
    FOOD_RADIUS,
    JAW_ON_FOOD,
    JAW_OPEN,
    JAW_ROOT,
    JAW_SPEED,
    RADIUS,
    WHEEL_BASE,
    half_gap,
)
from khepera_forage.worlds.batch import rows as at
from khepera_forage.worlds.batch import setting
from khepera_forage.worlds.batch.compiling import inline, kernel
from khepera_forage.worlds.batch.gripper import between, floor_free, push_out, seen_from
from khepera_forage.worlds.batch.rows import LANES
from khepera_forage.worlds.batch.trigonometry import cosine_sine

STEPS = 5
"""Steps a round."""
_DT = CONTROL_PERIOD / STEPS
_REPEATS = 4
_PALM = half_gap(JAW_OPEN) + FINGER_THICKNESS
_CENTRED = 1.0
"""mm off the middle up to which food counts as between both fingers."""
_TOLERATED = 0.5
"""mm of overlap up to which a robot goes on."""
_SETTLED = 1e-6

half_gap = inline(half_gap)


@kernel
def touch(
    s: NDArray[np.float64],
    f: NDArray[np.float64],
    foods: int,
    walls: NDArray[np.float64],
    corners: NDArray[np.float64],
) -> None:
    """Carry out the round of every world of a block that touches something."""
    for i in range(LANES):
        if s[at.TOUCHES * LANES + i] == 0.0:
            continue
        # Away from walls there is none to look at.
        near = walls[: walls.shape[0] if s[at.NEAR_WALL * LANES + i] != 0.0 else 0]
        late = s[at.LAG * LANES + i] * STEPS
        allowed = max(_TOLERATED, _overlap(s, f, foods, i, near))
        for step in range(STEPS):
            share = late if step == 0 else 0.0
            goes = s[at.FORWARD * LANES + i] + share * (
                s[at.LAST_FORWARD * LANES + i] - s[at.FORWARD * LANES + i]
            )
            turns = s[at.TURN * LANES + i] + share * (s[at.LAST_TURN * LANES + i] - s[at.TURN * LANES + i])
            x, y, heading = s[at.X * LANES + i], s[at.Y * LANES + i], s[at.HEADING * LANES + i]
            _move_jaw(s, f, foods, i, near)
            turn, forward = turns * _DT, goes * _DT
            c, d = cosine_sine(heading + turn / 2)
            _put(s, i, x + forward * c, y + forward * d, heading + turn)
            moved = 1.0
            for _ in range(_REPEATS):
                moved = _off_walls(s, i, near, corners) + _push_food(s, f, foods, i, near)
                if moved < _SETTLED:
                    break
            held_back = moved >= _SETTLED and _overlap(s, f, foods, i, near) > allowed
            if held_back:
                _put(s, i, x, y, heading)
            if step == STEPS - 1:
                s[at.LAST_FORWARD * LANES + i] = 0.0 if held_back else s[at.FORWARD * LANES + i]
                s[at.LAST_TURN * LANES + i] = 0.0 if held_back else s[at.TURN * LANES + i]


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
def _from_wall(x: float, y: float, walls: NDArray[np.float64], wall: int) -> tuple[float, float, float]:
    """Distance of a place from a wall, and the way from the wall to it as a unit vector."""
    ex, ey = walls[wall, setting.EX], walls[wall, setting.EY]
    x, y = x - walls[wall, setting.X1], y - walls[wall, setting.Y1]
    t = min(1.0, max(0.0, (x * ex + y * ey) * walls[wall, setting.SHARE]))
    dx, dy = x - t * ex, y - t * ey
    far = max(math.sqrt(dx * dx + dy * dy), 1e-9)
    return far, dx / far, dy / far


@inline
def _off_walls(
    s: NDArray[np.float64], i: int, walls: NDArray[np.float64], corners: NDArray[np.float64]
) -> float:
    """Move the robot off all walls; returns how far they stood in it, mm."""
    moved = 0.0
    wide = half_gap(s[at.JAW * LANES + i]) + FINGER_THICKNESS
    for wall in range(walls.shape[0]):
        far, nx, ny = _from_wall(s[at.X * LANES + i], s[at.Y * LANES + i], walls, wall)
        if far > FINGER_TIP + 2 * FOOD_RADIUS:
            continue
        if far < RADIUS:
            s[at.X * LANES + i] += nx * (RADIUS - far)
            s[at.Y * LANES + i] += ny * (RADIUS - far)
            moved += RADIUS - far
        for corner in range(4):
            u = FINGER_TIP if corner < 2 else JAW_ROOT
            v = wide if corner < 2 else _PALM
            v = v if corner & 1 else -v
            depth, nx, ny = _behind(s, i, u, v, walls, wall)
            if depth > 0.0:
                _yield(s, i, u, v, nx, ny, depth)
                moved += depth
        if s[at.HELD * LANES + i] >= 0.0:
            u, v = s[at.GRIP_X * LANES + i], s[at.GRIP_Y * LANES + i]
            c, d = s[at.COS * LANES + i], s[at.SIN * LANES + i]
            far, nx, ny = _from_wall(
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
def _behind(
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


@inline
def _push_food(
    s: NDArray[np.float64], f: NDArray[np.float64], foods: int, i: int, walls: NDArray[np.float64]
) -> float:
    """Move food out of the robot's way, out of walls and off other food; returns how far in all, mm."""
    moved = 0.0
    held = s[at.HELD * LANES + i]
    low = s[at.ARM * LANES + i] >= ARM_ON_FLOOR
    for food in range(foods):
        if food == held:
            continue
        base = food * at.FOOD_ROWS * LANES + i
        from_x, from_y = f[base + at.FOOD_X * LANES], f[base + at.FOOD_Y * LANES]
        u, v = seen_from(s, f, food, i)
        if u * u + v * v > (FINGER_TIP + 4 * FOOD_RADIUS) ** 2:
            continue
        u, v = _apart(u, v, 0.0, 0.0, RADIUS + FOOD_RADIUS)
        if low:
            if held >= 0.0:
                u, v = _apart(u, v, s[at.GRIP_X * LANES + i], s[at.GRIP_Y * LANES + i], 2 * FOOD_RADIUS)
            depth, along, aside = push_out(u, v, s[at.JAW * LANES + i], FOOD_RADIUS)
            if depth > 0.0:
                u, v = u + depth * along, v + depth * aside
        c, d = s[at.COS * LANES + i], s[at.SIN * LANES + i]
        x, y = s[at.X * LANES + i] + u * c - v * d, s[at.Y * LANES + i] + u * d + v * c
        f[base + at.FOOD_X * LANES], f[base + at.FOOD_Y * LANES] = x, y
        moved += abs(x - from_x) + abs(y - from_y)
    if moved > 0.0:
        for food in range(foods):
            if food != held:
                moved += _settle(f, foods, i, food, held, walls)
    return moved


@inline
def _settle(
    f: NDArray[np.float64], foods: int, i: int, food: int, held: float, walls: NDArray[np.float64]
) -> float:
    """Move one food object out of walls, and others off it."""
    base = food * at.FOOD_ROWS * LANES + i
    x, y = f[base + at.FOOD_X * LANES], f[base + at.FOOD_Y * LANES]
    moved = 0.0
    for wall in range(walls.shape[0]):
        far, nx, ny = _from_wall(x, y, walls, wall)
        if far < FOOD_RADIUS:
            x, y = x + nx * (FOOD_RADIUS - far), y + ny * (FOOD_RADIUS - far)
            moved += FOOD_RADIUS - far
    f[base + at.FOOD_X * LANES], f[base + at.FOOD_Y * LANES] = x, y
    for other in range(foods):
        if other != food and other != held:
            there = other * at.FOOD_ROWS * LANES + i
            from_x, from_y = f[there + at.FOOD_X * LANES], f[there + at.FOOD_Y * LANES]
            to_x, to_y = _apart(from_x, from_y, x, y, 2 * FOOD_RADIUS)
            f[there + at.FOOD_X * LANES], f[there + at.FOOD_Y * LANES] = to_x, to_y
            moved += abs(to_x - from_x) + abs(to_y - from_y)
    return moved


@inline
def _apart(x: float, y: float, from_x: float, from_y: float, distance: float) -> tuple[float, float]:
    """A place, moved away from another to at least this distance."""
    dx, dy = x - from_x, y - from_y
    far = math.sqrt(dx * dx + dy * dy)
    if far >= distance or far < 1e-9:
        return x, y
    return from_x + dx * distance / far, from_y + dy * distance / far


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
        far, _, _ = _from_wall(s[at.X * LANES + i], s[at.Y * LANES + i], walls, wall)
        worst = max(worst, RADIUS - far)
        if far < FINGER_TIP + 2 * FOOD_RADIUS:
            for corner in range(4):
                u = FINGER_TIP if corner < 2 else JAW_ROOT
                v = wide if corner < 2 else _PALM
                depth, _, _ = _behind(s, i, u, v if corner & 1 else -v, walls, wall)
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
            far, _, _ = _from_wall(x, y, walls, wall)
            worst = max(worst, FOOD_RADIUS - far)
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


@inline
def _move_jaw(
    s: NDArray[np.float64], f: NDArray[np.float64], foods: int, i: int, walls: NDArray[np.float64]
) -> None:
    """Move the jaw for one step: closing on food holds it, opening lets it go."""
    jaw, target = s[at.JAW * LANES + i], s[at.JAW_TO * LANES + i]
    held = int(s[at.HELD * LANES + i])
    if target == jaw or (held >= 0 and target < jaw):
        return
    step = JAW_SPEED * _DT
    new = min(target, jaw + step) if target > jaw else max(target, jaw - step)
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
            depth, _, _ = _behind(s, i, u, aside if corner & 1 else -aside, walls, wall)
            into = into or depth > 0.5
    return into
