"""The overhead camera: what each frame shows of the robot and the food (see `vision.simulated_camera`).

The robot has the only marker of its kind, so its track never ends. Food becomes tracks in `tracking`.
"""

import math
from typing import Any

import numpy as np

from khepera_forage.compilation.decorators import inline, kernel
from khepera_forage.counter_rng import random_bits
from khepera_forage.robots.khepera import FOOD_RADIUS
from khepera_forage.sim.compiled.listed_walls import at
from khepera_forage.sim.compiled.near_walls import cable_anchors
from khepera_forage.sim.compiled.numbers import (
    DRAW_FOOD,
    DRAW_MARKER,
    DRAWS,
    FOOD_DRAWS,
    lower,
    normal,
    upper,
)
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.shapes import PICTURE_HEIGHT, PICTURE_WIDTH, Plate, touches_plate

_DRAWS, _32 = np.uint64(DRAWS), np.uint64(32)
_X, _Y, _DITHER, _TURN, _CHANCE = (np.uint64(DRAW_MARKER + n) for n in range(5))
_FOOD_Y, _FOOD_DITHER, _FOOD_CHANCE = (np.uint64(n) for n in (1, 2, 3))
_DEGREES = 180.0 / math.pi

touches_plate = inline(touches_plate)


@inline
def plate_of(robot: Any, i: int) -> Plate:
    """The marker of one robot."""
    return Plate(robot.x[i], robot.y[i], robot.cos[i], robot.sin[i])


@inline
def _is_lost(lost: float, chance: float, rate: float, end: float) -> float:
    """Whether the tracker does not see a region in this frame: losses begin at a rate and end with a chance."""
    stays = chance >= end
    begins = chance < rate
    return 1.0 if (stays if lost != 0.0 else begins) else 0.0


@kernel
def expose(robot: Any, foods: Any, near: Any, constants: Any) -> None:
    """Take one frame in every world of a block; in the first frame after a reset nothing is lost."""
    _expose_marker(robot, constants)
    jitter, rate, end = (constants[0].position_jitter, constants[0].loss_rate_food, constants[0].loss_end)
    factor, (anchors_x, anchors_y) = constants[0].cable_loss_factor, cable_anchors(near, constants)
    lanes = robot.x.shape[0]
    for k in range(foods.shape[0]):
        food = foods[k]
        draw = np.uint64(DRAW_FOOD + k * FOOD_DRAWS)
        for i in range(lanes):
            key, first = robot.key[i], robot.round[i] * _DRAWS + draw
            dither = random_bits(key, first + _FOOD_DITHER)
            x = food.x[i] / MM_PER_PIXEL + jitter * normal(random_bits(key, first), dither)
            y = food.y[i] / MM_PER_PIXEL + jitter * normal(random_bits(key, first + _FOOD_Y), dither >> _32)
            # The robot's cable is a straight line from the anchor to the middle of its marker.
            anchor_x, anchor_y = at(anchors_x, i), at(anchors_y, i)
            to_x, to_y = robot.x[i] - anchor_x, robot.y[i] - anchor_y
            dx, dy = food.x[i] - anchor_x, food.y[i] - anchor_y
            t = min(1.0, max(0.0, (dx * to_x + dy * to_y) / max(to_x * to_x + to_y * to_y, 1e-9)))
            dx, dy = dx - t * to_x, dy - t * to_y
            under_cable = dx * dx + dy * dy <= FOOD_RADIUS * FOOD_RADIUS
            chance = upper(random_bits(key, first + _FOOD_CHANCE))
            lost = _is_lost(food.lost[i], chance, rate * (factor if under_cable else 1.0), end)
            lost *= 1.0 - robot.first_frame[i]
            hidden = touches_plate(food.x[i], food.y[i], FOOD_RADIUS, plate_of(robot, i))
            inside = 0.0 < x < PICTURE_WIDTH and 0.0 < y < PICTURE_HEIGHT
            food.lost[i] = lost
            food.seen[i] = 1.0 if inside and lost == 0.0 and not hidden else 0.0
            food.seen_x[i] = x
            food.seen_y[i] = y
    for i in range(lanes):
        robot.first_frame[i] = 0.0


@inline
def _expose_marker(robot: Any, constants: Any) -> None:
    """What this frame shows of the robots' markers."""
    jitter, heading_jitter, reversal_rate = (
        constants[0].position_jitter,
        constants[0].heading_jitter,
        constants[0].reversal_rate,
    )
    rate, end = constants[0].loss_rate_marker, constants[0].loss_end
    for i in range(robot.x.shape[0]):
        key, first = robot.key[i], robot.round[i] * _DRAWS
        dither, chances = random_bits(key, first + _DITHER), random_bits(key, first + _CHANCE)
        x = robot.x[i] / MM_PER_PIXEL + jitter * normal(random_bits(key, first + _X), dither)
        y = robot.y[i] / MM_PER_PIXEL + jitter * normal(random_bits(key, first + _Y), dither >> _32)
        turn = random_bits(key, first + _TURN)
        degrees = robot.heading[i] * _DEGREES + heading_jitter * normal(turn, random_bits(turn, _DITHER))
        degrees += 180.0 if lower(chances) < reversal_rate else 0.0
        degrees = np.rint(degrees)
        degrees -= 360.0 * math.floor(degrees / 360.0)
        # A robot's own cable never disturbs its marker (3.7).
        lost = _is_lost(robot.marker_lost[i], upper(chances), rate, end)
        lost *= 1.0 - robot.first_frame[i]
        shown = lost == 0.0 and 0.0 < x < PICTURE_WIDTH and 0.0 < y < PICTURE_HEIGHT
        robot.marker_lost[i] = lost
        robot.marker_found[i] = 1.0 if shown else 0.0
        robot.marker_x[i] = x if shown else robot.marker_x[i]
        robot.marker_y[i] = y if shown else robot.marker_y[i]
        robot.marker_heading[i] = degrees if shown else robot.marker_heading[i]
