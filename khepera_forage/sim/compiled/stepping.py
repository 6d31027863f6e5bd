"""One round of every world, and the beginning of an episode: the kernels that `BatchWorld` calls."""

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import entrance, inline, kernel, sequence
from khepera_forage.compilation.trigonometry import cosine_sine
from khepera_forage.compilation.work_queue import take
from khepera_forage.robots.khepera import ARM_RAISED, JAW_OPEN
from khepera_forage.sim.compiled import rows as at
from khepera_forage.sim.compiled.bodies import Bodies, bodies_of
from khepera_forage.sim.compiled.broad_phase import look_around, watch_food, watch_walls
from khepera_forage.sim.compiled.camera import expose
from khepera_forage.sim.compiled.contact import touch
from khepera_forage.sim.compiled.drive import aim, begin_round, glide
from khepera_forage.sim.compiled.numbers import normal, word
from khepera_forage.sim.compiled.parameters import WHEEL_BIAS, WHEEL_SPEED, Setting
from khepera_forage.sim.compiled.rows import LANES
from khepera_forage.sim.compiled.sensing import cast, end_round, measure
from khepera_forage.sim.compiled.tracks import track

_ONE, _32 = np.uint64(1), np.uint64(32)
_KEPT = (
    *(at.PULSES_LEFT, at.PULSES_RIGHT, at.LEFT, at.RIGHT, at.PRESENT, at.ARM_READ, at.JAW_READ),
    *(at.OWN_X, at.OWN_Y, at.OWN_DEGREES, at.OWN_FOUND, at.OWN_LOST),
    *(at.NEXT_LABEL, at.GHOSTS, at.LAST_FORWARD, at.LAST_TURN),
)
"""Rows that one round hands to the next and that begin at 0; all others are written before they are read."""
_DRAWS = np.uint64(at.DRAWS)
_BIAS_LEFT, _BIAS_RIGHT, _BIAS_DITHER = (np.uint64(at.DRAWS - n) for n in (1, 2, 3))


@sequence
def look(bodies: Bodies, setting: Setting) -> None:
    """What robots and camera sense at the end of a round, in every world of a block."""
    s, w, f, keys = bodies.robots, bodies.work, bodies.food, bodies.keys
    end_round(s, f, setting.foods)
    cast(s, w, f, setting.foods, setting.walls)
    measure(s, keys, setting.noise)
    expose(s, f, keys, setting.foods, setting.noise)
    track(s, w, f, setting.foods, setting.noise)


@sequence
def advance_block(bodies: Bodies, setting: Setting) -> None:
    """One round of 0.1 s in every world of a block."""
    s, w, f, keys = bodies.robots, bodies.work, bodies.food, bodies.keys
    for i in range(LANES):
        keys[at.ROUND * LANES + i] += _ONE
    begin_round(s, w, f, keys, setting.foods, setting.noise)
    look_around(s, w, f, setting.foods, setting.walls)
    aim(s, w)
    watch_walls(s, w, setting.walls, setting.corners)
    watch_food(s, w, f, setting.foods)
    glide(s, w)
    touch(s, w, f, setting.foods, setting.walls, setting.corners)
    look(bodies, setting)


@kernel
def _advance(bodies: Bodies, setting: Setting) -> None:
    advance_block(bodies, setting)


@inline
def stand(bodies: Bodies, i: int, x: float, y: float, heading: float, setting: Setting) -> None:
    """Put a robot down at the start of an episode, at rest, with its gripper raised and open; the camera knows nothing.

    The food's places are set beside this.
    """
    s, f, keys = bodies.robots, bodies.food, bodies.keys
    for row in _KEPT:
        s[row * LANES + i] = 0.0
    key, first = keys[at.KEY * LANES + i], keys[at.ROUND * LANES + i] * _DRAWS
    dither = word(key, first + _BIAS_DITHER)
    mean = setting.noise[WHEEL_SPEED] - 1.0
    bias = setting.noise[WHEEL_BIAS]
    s[at.BIAS_LEFT * LANES + i] = mean + bias * normal(word(key, first + _BIAS_LEFT), dither)
    s[at.BIAS_RIGHT * LANES + i] = mean + bias * normal(word(key, first + _BIAS_RIGHT), dither >> _32)
    s[at.X * LANES + i], s[at.Y * LANES + i], s[at.HEADING * LANES + i] = x, y, heading
    s[at.COS * LANES + i], s[at.SIN * LANES + i] = cosine_sine(heading)
    s[at.ARM * LANES + i] = s[at.ARM_TO * LANES + i] = ARM_RAISED
    s[at.JAW * LANES + i] = s[at.JAW_TO * LANES + i] = JAW_OPEN
    s[at.HELD * LANES + i] = -1.0
    s[at.NEW * LANES + i] = 1.0
    for food in range(setting.foods):
        there = food * at.FOOD_ROWS * LANES + i
        for row in range(at.LOST, at.FOOD_ROWS):
            f[there + row * LANES] = 0.0
        for row in (at.TRACK, at.NOTE, at.GHOST, at.GHOST_NOTE):
            f[there + row * LANES] = -1.0


@entrance
def advance_all(thread: int, bodies: Bodies, begun: NDArray[np.int64], setting: Setting) -> None:
    """One round in every block that no other thread has taken."""
    block = take(begun)
    while block < bodies.robots.shape[0]:
        _advance(bodies_of(bodies, block, thread), setting)
        block = take(begun)


@entrance
def stand_all(
    bodies: Bodies, setting: Setting, poses: NDArray[np.float64], places: NDArray[np.float64]
) -> None:
    """Put robots and food down, one row of x, y and heading and one of places a lane."""
    for lane in range(poses.shape[0]):
        block, i = lane // LANES, lane % LANES
        x, y, heading = poses[lane, 0], poses[lane, 1], poses[lane, 2]
        stand(bodies_of(bodies, block, 0), i, x, y, heading, setting)
        for k in range(places.shape[1]):
            there = k * at.FOOD_ROWS * LANES + i
            bodies.food[block, there + at.FOOD_X * LANES] = places[lane, k, 0]
            bodies.food[block, there + at.FOOD_Y * LANES] = places[lane, k, 1]
