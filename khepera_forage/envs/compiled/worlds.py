"""The rows of all blocks of a batch that forages, or of one block."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import inline
from khepera_forage.envs.compiled import rows as at
from khepera_forage.robots.khepera import ARM_RAISED, JAW_OPEN
from khepera_forage.sim.compiled import rows as body
from khepera_forage.sim.compiled.bodies import Bodies, bodies_of, empty_bodies
from khepera_forage.sim.compiled.rows import LANES


class Worlds(NamedTuple):
    """Bodies and their task: one array a block each, or the arrays of one block (see `rows`).

    Attributes:
        bodies: Robots, food and random numbers.
        tasks: `TASK_ROWS` rows.
        registers: `TASK_FOOD_ROWS` rows a food object.
    """

    bodies: Bodies
    tasks: NDArray[np.float64]
    registers: NDArray[np.float64]


@inline
def worlds_of(worlds: Worlds, block: int, thread: int) -> Worlds:
    """Those of one block, as one thread works on them."""
    return Worlds(bodies_of(worlds.bodies, block, thread), worlds.tasks[block], worlds.registers[block])


def empty_worlds(blocks: int, foods: int) -> Worlds:
    """Room for some blocks, in which lanes that no world uses can be advanced: at rest, far from anything."""
    bodies = empty_bodies(blocks, foods)
    robots = bodies.robots.reshape(blocks, body.ROBOT_ROWS, LANES)
    robots[:, body.X] = robots[:, body.Y] = -1e6
    robots[:, body.COS] = 1.0
    robots[:, body.ARM] = robots[:, body.ARM_TO] = ARM_RAISED
    robots[:, body.JAW] = robots[:, body.JAW_TO] = JAW_OPEN
    robots[:, body.HELD] = -1.0
    food = bodies.food.reshape(blocks, foods, body.FOOD_ROWS, LANES)
    food[:, :, [body.TRACK, body.NOTE, body.GHOST]] = -1.0
    tasks = np.zeros((blocks, at.TASK_ROWS * LANES))
    tasks.reshape(blocks, at.TASK_ROWS, LANES)[:, at.HELD] = -1.0
    return Worlds(bodies, tasks, np.zeros((blocks, foods * at.TASK_FOOD_ROWS * LANES)))
