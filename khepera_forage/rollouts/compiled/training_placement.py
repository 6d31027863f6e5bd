"""Beginnings of attempts: robots and food on their marks in figure 5.1 (`task.placement.training_layout`)."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import inline
from khepera_forage.compilation.trigonometry import cosine_sine
from khepera_forage.envs.compiled import rows as at
from khepera_forage.envs.compiled.placement import clearance
from khepera_forage.envs.compiled.worlds import Worlds
from khepera_forage.robots.khepera import (
    FINGER_THICKNESS,
    FINGER_TIP,
    FOOD_RADIUS,
    JAW_OPEN,
    JAW_ROOT,
    RADIUS,
    half_gap,
)
from khepera_forage.rollouts.compiled import pair_rows as pair
from khepera_forage.sim.compiled import rows as body
from khepera_forage.sim.compiled.numbers import normal, upper, word
from khepera_forage.sim.compiled.parameters import Setting
from khepera_forage.sim.compiled.rows import LANES
from khepera_forage.sim.compiled.stepping import stand
from khepera_forage.task.identification import drawn_type
from khepera_forage.task.placement import _TRIES
from khepera_forage.vision.scene import MM_PER_PIXEL

_WIDE = half_gap(JAW_OPEN) + FINGER_THICKNESS
_PLACES = np.uint64(1 << 40)
_ONE, _32 = np.uint64(1), np.uint64(32)


class Marks(NamedTuple):
    """Where robots and food are put, one row a side.

    Attributes:
        starts: x mm, y mm and heading in radians.
        foods: x mm and y mm of each food object.
        error: Standard deviation in mm with which an operator puts something on its mark.
        heading_error: Of a robot's heading, in radians.
    """

    starts: NDArray[np.float64]
    foods: NDArray[np.float64]
    error: float
    heading_error: float


@inline
def _gripper_free(x: float, y: float, heading: float, walls: NDArray[np.float64]) -> bool:
    """Whether the open gripper is in no wall: `sim.layout_checks.check_robot`."""
    c, d = cosine_sine(heading)
    free = True
    for corner in range(4):
        u = FINGER_TIP if corner < 2 else JAW_ROOT
        v = _WIDE if corner & 1 else -_WIDE
        free = free and clearance(x + u * c - v * d, y + u * d + v * c, walls) >= 0.0
    return free


@inline
def _put(
    f: NDArray[np.float64],
    i: int,
    side: int,
    key: np.uint64,
    setting: Setting,
    marks: Marks,
    error: float,
    heading_error: float,
) -> tuple[bool, float, float, float]:
    """Put food into its rows, as badly as an operator does; tells whether all stands free, and where the robot is."""
    dither = word(key, np.uint64(2))
    x = marks.starts[side, 0] + error * normal(word(key, np.uint64(0)), dither)
    y = marks.starts[side, 1] + error * normal(word(key, _ONE), dither >> _32)
    turn = word(key, np.uint64(3))
    heading = marks.starts[side, 2] + heading_error * normal(turn, word(turn, _ONE))
    free = clearance(x, y, setting.walls) >= RADIUS and _gripper_free(x, y, heading, setting.walls)
    for food in range(setting.foods):
        own = word(key, np.uint64(4 + food))
        dither = word(own, np.uint64(2))
        food_x = marks.foods[side, food, 0] + error * normal(word(own, np.uint64(0)), dither)
        food_y = marks.foods[side, food, 1] + error * normal(word(own, _ONE), dither >> _32)
        there = food * body.FOOD_ROWS * LANES + i
        f[there + body.FOOD_X * LANES], f[there + body.FOOD_Y * LANES] = food_x, food_y
        free = free and clearance(food_x, food_y, setting.walls) >= FOOD_RADIUS
        free = free and math.sqrt((food_x - x) ** 2 + (food_y - y) ** 2) >= RADIUS + FOOD_RADIUS
        for other in range(food):
            there = other * body.FOOD_ROWS * LANES + i
            dx, dy = f[there + body.FOOD_X * LANES] - food_x, f[there + body.FOOD_Y * LANES] - food_y
            free = free and math.sqrt(dx * dx + dy * dy) >= 2.0 * FOOD_RADIUS
    return free, x, y, heading


@inline
def place_side(
    worlds: Worlds,
    i: int,
    side: int,
    key: np.uint64,
    setting: Setting,
    odds: NDArray[np.float64],
    types: np.uint64,
    marks: Marks,
) -> bool:
    """Put one side of a pair in its place; its first frame is taken in the coming round.

    What would stand in a wall, or in something else, is put down again.

    Args:
        worlds: Those of this side.
        i: The lane.
        side: `TEACHER` or `LEARNER`.
        key: Of this side's random numbers in this attempt.
        setting: This side's.
        odds: Of the food types.
        types: Random bits that both sides' types are drawn from: corresponding food shares one draw.
        marks: Where to.

    Returns:
        Whether there was room; otherwise everything stands on its mark.
    """
    keys, f, t, q = worlds.bodies.keys, worlds.bodies.food, worlds.tasks, worlds.registers
    keys[body.KEY * LANES + i] = key
    keys[body.ROUND * LANES + i] = 0
    x = y = heading = 0.0
    free = False
    for number in range(_TRIES):
        draws = word(key, _PLACES + np.uint64(number))
        free, x, y, heading = _put(f, i, side, draws, setting, marks, marks.error, marks.heading_error)
        if free:
            break
    if not free:
        _, x, y, heading = _put(f, i, side, key, setting, marks, 0.0, 0.0)
    stand(worlds.bodies, i, x, y, heading, setting)
    for row in range(at.TASK_ROWS):
        t[row * LANES + i] = 0.0
    t[at.HELD * LANES + i] = -1.0
    for food in range(setting.foods):
        mine, there = food * at.TASK_FOOD_ROWS * LANES + i, food * body.FOOD_ROWS * LANES + i
        for row in range(at.TASK_FOOD_ROWS):
            q[mine + row * LANES] = 0.0
        q[mine + at.PLACE_X * LANES] = f[there + body.FOOD_X * LANES] / MM_PER_PIXEL
        q[mine + at.PLACE_Y * LANES] = f[there + body.FOOD_Y * LANES] / MM_PER_PIXEL
        draw = upper(word(types, np.uint64(food)))
        q[mine + at.TYPE * LANES] = drawn_type(draw, odds[0], odds[1]).value
    return free


@inline
def forget(c: NDArray[np.float64], i: int) -> None:
    """A new company, in which nothing has happened yet."""
    for row in range(pair.EPISODE):
        c[row * LANES + i] = 0.0
