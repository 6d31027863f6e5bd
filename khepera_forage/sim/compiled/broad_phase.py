"""What a robot of a batch could touch in a round, and what it would touch at the free end of it."""

import math

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import inline, kernel
from khepera_forage.compilation.packing import pack, packed
from khepera_forage.robots.khepera import (
    ARM_ON_FLOOR,
    FINGER_THICKNESS,
    FINGER_TIP,
    FOOD_RADIUS,
    JAW_OPEN,
    JAW_ROOT,
    RADIUS,
    half_gap,
)
from khepera_forage.sim.broad_phase import GRIPPER_AHEAD, GRIPPER_RADIUS, PUSHED, SHOVED
from khepera_forage.sim.compiled import parameters as setting
from khepera_forage.sim.compiled import rows as at
from khepera_forage.sim.compiled.bodies import filled
from khepera_forage.sim.compiled.gripper import finger_overlap, palm_overlap
from khepera_forage.sim.compiled.rows import LANES

_PALM = half_gap(JAW_OPEN) + FINGER_THICKNESS
# What `watch_walls` looks at of the lanes near a wall, packed into the scratch rows.
_OF_ROUND = np.array((at.FREE_X, at.FREE_Y, at.FREE_COS, at.FREE_SIN, at.FREE_JAW))
_OF_ROBOT = np.array((at.X, at.Y, at.HELD, at.GRIP_X, at.GRIP_Y))
_X, _Y, _COS, _SIN, _JAW, _FROM_X, _FROM_Y, _HELD, _GRIP_X, _GRIP_Y, _LANE = (
    at.SCRATCH + n for n in range(11)
)
_TOUCHES = at.MARK
_FAR = 30.0
"""mm a round from which a finger could pass through food unnoticed: then every step of the round is looked at."""

half_gap = inline(half_gap)


@kernel
def look_around(
    s: NDArray[np.float64],
    w: NDArray[np.float64],
    f: NDArray[np.float64],
    foods: int,
    walls: NDArray[np.float64],
) -> None:
    """Mark what could be touched in this round, and from that how far the wheels lag: as `PymunkWorld` has it.

    Chipmunk moves bodies by the speed of the step before. So where it is at work, a robot changes its speed one physics
    step late: 20 ms, or less near a wall, where steps are finer. In the open, where no physics is needed, nothing lags.
    """
    for food in range(foods):
        base = food * at.FOOD_ROWS * LANES
        for i in range(LANES):
            dx = f[base + at.FOOD_X * LANES + i] - s[at.X * LANES + i]
            dy = f[base + at.FOOD_Y * LANES + i] - s[at.Y * LANES + i]
            reach = PUSHED if s[at.ARM * LANES + i] >= ARM_ON_FLOOR else SHOVED
            reach += w[at.TRAVEL * LANES + i]
            near = dx * dx + dy * dy < reach * reach and s[at.HELD * LANES + i] != food
            w[at.NEAR_FOOD * LANES + i] = 1.0 if near else w[at.NEAR_FOOD * LANES + i]
    for wall in range(walls.shape[0]):
        x1, y1, ex, ey = walls[wall, 0], walls[wall, 1], walls[wall, 2], walls[wall, 3]
        share = walls[wall, setting.SHARE]
        for i in range(LANES):
            x, y = s[at.X * LANES + i] - x1, s[at.Y * LANES + i] - y1
            travel = w[at.TRAVEL * LANES + i]
            t = min(1.0, max(0.0, (x * ex + y * ey) * share))
            dx, dy = x - t * ex, y - t * ey
            reach = travel + (PUSHED if w[at.NEAR_FOOD * LANES + i] != 0.0 else RADIUS)
            body = dx * dx + dy * dy < reach * reach
            x += GRIPPER_AHEAD * s[at.COS * LANES + i]
            y += GRIPPER_AHEAD * s[at.SIN * LANES + i]
            t = min(1.0, max(0.0, (x * ex + y * ey) * share))
            dx, dy = x - t * ex, y - t * ey
            reach = travel + GRIPPER_RADIUS
            near = body or dx * dx + dy * dy < reach * reach
            w[at.NEAR_WALL * LANES + i] = 1.0 if near else w[at.NEAR_WALL * LANES + i]


@kernel
def watch_walls(
    s: NDArray[np.float64], w: NDArray[np.float64], walls: NDArray[np.float64], corners: NDArray[np.float64]
) -> None:
    """Mark the worlds whose robot would touch a wall at the free end of the round: some of those that are near one."""
    count = pack(w, at.NEAR_WALL, _LANE, 0)
    for n in range(count):
        i = packed(w, _LANE, n)
        for row in range(len(_OF_ROUND)):
            w[(_X + row) * LANES + n] = w[_OF_ROUND[row] * LANES + i]
        for row in range(len(_OF_ROBOT)):
            w[(_FROM_X + row) * LANES + n] = s[_OF_ROBOT[row] * LANES + i]
        w[_TOUCHES * LANES + n] = 0.0
    whole = filled(count)
    for wall in range(walls.shape[0]):
        x1, y1, ex, ey = walls[wall, 0], walls[wall, 1], walls[wall, 2], walls[wall, 3]
        share = walls[wall, setting.SHARE]
        nx, ny, offset = walls[wall, 5], walls[wall, 6], walls[wall, 7]
        for n in range(whole):
            x, y = w[_X * LANES + n], w[_Y * LANES + n]
            c, d = w[_COS * LANES + n], w[_SIN * LANES + n]
            wide = half_gap(w[_JAW * LANES + n]) + FINGER_THICKNESS
            # Which side of the wall the robot is on now.
            side = nx * w[_FROM_X * LANES + n] + ny * w[_FROM_Y * LANES + n] - offset
            side = math.copysign(1.0, side)
            off = side * (nx * x + ny * y - offset)
            t = ((x - x1) * ex + (y - y1) * ey) * share
            t = min(1.0, max(0.0, t))
            dx, dy = x - x1 - t * ex, y - y1 - t * ey
            body = dx * dx + dy * dy < RADIUS * RADIUS
            # How far forward and left of the robot lead away from the wall.
            ahead, aside = side * (nx * c + ny * d), abs(nx * -d + ny * c)
            tip = off + FINGER_TIP * ahead - wide * aside < 0.0
            root = off + JAW_ROOT * ahead - _PALM * aside < 0.0
            held = w[_HELD * LANES + n] >= 0.0
            grip = (
                held
                and off + w[_GRIP_X * LANES + n] * ahead - aside * abs(w[_GRIP_Y * LANES + n]) < FOOD_RADIUS
            )
            # Beyond its ends a wall touches nothing; the robot reaches no further than 94 mm.
            along = (x - x1) * ex + (y - y1) * ey
            reach = 94.0 * math.sqrt(ex * ex + ey * ey)
            beside = along > -reach and along < ex * ex + ey * ey + reach
            if body or (beside and (tip or root or grip)):
                w[_TOUCHES * LANES + n] = 1.0
    for n in range(count):
        i = packed(w, _LANE, n)
        w[at.TOUCHES * LANES + i] = max(w[at.TOUCHES * LANES + i], w[_TOUCHES * LANES + n])
    for corner in range(corners.shape[0]):
        cx, cy = corners[corner, 0], corners[corner, 1]
        for i in range(LANES):
            dx, dy = cx - w[at.FREE_X * LANES + i], cy - w[at.FREE_Y * LANES + i]
            c, d = w[at.FREE_COS * LANES + i], w[at.FREE_SIN * LANES + i]
            u, v = dx * c + dy * d, dy * c - dx * d
            if finger_overlap(u, v, w[at.FREE_JAW * LANES + i], 0.0) > 0.0 or palm_overlap(u, v, 0.0) > 0.0:
                w[at.TOUCHES * LANES + i] = 1.0


@kernel
def watch_food(s: NDArray[np.float64], w: NDArray[np.float64], f: NDArray[np.float64], foods: int) -> None:
    """Mark the worlds whose robot would touch food, other than in its gripper, at the free end of the round."""
    for food in range(foods):
        base = food * at.FOOD_ROWS * LANES
        for i in range(LANES):
            x, y = f[base + at.FOOD_X * LANES + i], f[base + at.FOOD_Y * LANES + i]
            dx, dy = x - w[at.FREE_X * LANES + i], y - w[at.FREE_Y * LANES + i]
            c, d = w[at.FREE_COS * LANES + i], w[at.FREE_SIN * LANES + i]
            u, v = dx * c + dy * d, dy * c - dx * d
            low = s[at.ARM * LANES + i] >= ARM_ON_FLOOR
            held = s[at.HELD * LANES + i]
            reach = RADIUS + FOOD_RADIUS
            body = u * u + v * v < reach * reach
            fingers = finger_overlap(u, v, w[at.FREE_JAW * LANES + i], FOOD_RADIUS) > 0.0
            palm = palm_overlap(u, v, FOOD_RADIUS) > 0.0
            gx, gy = u - s[at.GRIP_X * LANES + i], v - s[at.GRIP_Y * LANES + i]
            other = held >= 0.0 and gx * gx + gy * gy < 4 * FOOD_RADIUS * FOOD_RADIUS
            fast = w[at.TRAVEL * LANES + i] > _FAR and u * u + v * v < (FINGER_TIP + 2 * FOOD_RADIUS) ** 2
            if held != food and (body or (low and (fingers or palm or other or fast))):
                w[at.TOUCHES * LANES + i] = 1.0
