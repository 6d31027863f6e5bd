"""One round of every world, and the beginning of an episode: the kernels that `BatchWorld` calls."""

import numba
import numpy as np
from numba import prange
from numpy.typing import NDArray

from khepera_forage.robots.khepera import ARM_RAISED, JAW_OPEN
from khepera_forage.worlds.batch import rows as at
from khepera_forage.worlds.batch import setting
from khepera_forage.worlds.batch.camera import expose
from khepera_forage.worlds.batch.compiling import inline, kernel
from khepera_forage.worlds.batch.contact import touch
from khepera_forage.worlds.batch.drive import aim, begin_round, glide, look_around, watch_food, watch_walls
from khepera_forage.worlds.batch.numbers import normal, word
from khepera_forage.worlds.batch.rows import LANES
from khepera_forage.worlds.batch.sensing import cast, end_round, measure
from khepera_forage.worlds.batch.tracks import track
from khepera_forage.worlds.batch.trigonometry import cosine_sine

_ONE, _32 = np.uint64(1), np.uint64(32)
_DRAWS = np.uint64(at.DRAWS)
_BIAS_LEFT, _BIAS_RIGHT, _BIAS_DITHER = (np.uint64(at.DRAWS - n) for n in (1, 2, 3))


@kernel
def look(
    s: NDArray[np.float64],
    f: NDArray[np.float64],
    keys: NDArray[np.uint64],
    foods: int,
    walls: NDArray[np.float64],
    noise: NDArray[np.float64],
) -> None:
    """What robots and camera sense at the end of a round, in every world of a block."""
    end_round(s, f, foods)
    cast(s, f, foods, walls)
    measure(s, keys, noise)
    expose(s, f, keys, foods, noise)
    track(s, f, foods, noise)


@kernel
def advance_block(
    s: NDArray[np.float64],
    f: NDArray[np.float64],
    keys: NDArray[np.uint64],
    foods: int,
    walls: NDArray[np.float64],
    corners: NDArray[np.float64],
    noise: NDArray[np.float64],
) -> None:
    """One round of 0.1 s in every world of a block."""
    for i in range(LANES):
        keys[at.ROUND * LANES + i] += _ONE
    begin_round(s, f, keys, foods, noise)
    look_around(s, f, foods, walls)
    aim(s)
    watch_walls(s, walls, corners)
    watch_food(s, f, foods)
    glide(s)
    touch(s, f, foods, walls, corners)
    look(s, f, keys, foods, walls, noise)


@numba.njit(parallel=True, error_model="numpy", boundscheck=False)
def advance_all(
    robots: NDArray[np.float64],
    food: NDArray[np.float64],
    keys: NDArray[np.uint64],
    foods: int,
    walls: NDArray[np.float64],
    corners: NDArray[np.float64],
    noise: NDArray[np.float64],
) -> None:
    """One round in every block; blocks are shared out among the processors."""
    for block in prange(robots.shape[0]):
        advance_block(robots[block], food[block], keys[block], foods, walls, corners, noise)


@numba.njit(error_model="numpy", boundscheck=False)
def look_all(
    robots: NDArray[np.float64],
    food: NDArray[np.float64],
    keys: NDArray[np.uint64],
    foods: int,
    walls: NDArray[np.float64],
    noise: NDArray[np.float64],
) -> None:
    """What is sensed in every block as it stands."""
    for block in range(robots.shape[0]):
        look(robots[block], food[block], keys[block], foods, walls, noise)


@inline
def stand(
    s: NDArray[np.float64],
    f: NDArray[np.float64],
    keys: NDArray[np.uint64],
    i: int,
    x: float,
    y: float,
    heading: float,
    foods: int,
    noise: NDArray[np.float64],
) -> None:
    """Put a robot down at the start of an episode, at rest, with its gripper raised and open; the camera knows nothing.

    The food's places are set beside this.
    """
    for row in range(at.ROBOT_ROWS):
        s[row * LANES + i] = 0.0
    key, first = keys[at.KEY * LANES + i], keys[at.ROUND * LANES + i] * _DRAWS
    dither = word(key, first + _BIAS_DITHER)
    s[at.BIAS_LEFT * LANES + i] = noise[setting.WHEEL_BIAS] * normal(word(key, first + _BIAS_LEFT), dither)
    s[at.BIAS_RIGHT * LANES + i] = noise[setting.WHEEL_BIAS] * normal(word(key, first + _BIAS_RIGHT), dither >> _32)
    s[at.X * LANES + i], s[at.Y * LANES + i], s[at.HEADING * LANES + i] = x, y, heading
    s[at.COS * LANES + i], s[at.SIN * LANES + i] = cosine_sine(heading)
    s[at.ARM * LANES + i] = s[at.ARM_TO * LANES + i] = ARM_RAISED
    s[at.JAW * LANES + i] = s[at.JAW_TO * LANES + i] = JAW_OPEN
    s[at.HELD * LANES + i] = -1.0
    s[at.NEW * LANES + i] = 1.0
    for food in range(foods):
        there = food * at.FOOD_ROWS * LANES + i
        for row in range(at.LOST, at.FOOD_ROWS):
            f[there + row * LANES] = 0.0
        for row in (at.TRACK, at.NOTE, at.GHOST, at.GHOST_NOTE):
            f[there + row * LANES] = -1.0


@numba.njit(error_model="numpy", boundscheck=False)
def stand_all(
    robots: NDArray[np.float64],
    food: NDArray[np.float64],
    keys: NDArray[np.uint64],
    poses: NDArray[np.float64],
    places: NDArray[np.float64],
    noise: NDArray[np.float64],
) -> None:
    """Put robots and food down, one pose and one row of places a lane."""
    foods = places.shape[1]
    for lane in range(poses.shape[0]):
        block, i = lane // LANES, lane % LANES
        x, y, heading = poses[lane, 0], poses[lane, 1], poses[lane, 2]
        stand(robots[block], food[block], keys[block], i, x, y, heading, foods, noise)
        for k in range(foods):
            there = k * at.FOOD_ROWS * LANES + i
            food[block, there + at.FOOD_X * LANES] = places[lane, k, 0]
            food[block, there + at.FOOD_Y * LANES] = places[lane, k, 1]
