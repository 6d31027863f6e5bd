"""The rows of all blocks of a batch, or of one block."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import inline
from khepera_forage.compilation.threads import most_threads_for
from khepera_forage.sim.compiled import rows as at
from khepera_forage.sim.compiled.rows import LANES

_STRIDE = 8
"""Worlds to an instruction."""


class Bodies(NamedTuple):
    """Robots, food and random numbers: one row of an array a block, or the arrays of one block (see `rows`).

    Attributes:
        robots: `ROBOT_ROWS` rows.
        food: `FOOD_ROWS` rows a food object.
        keys: `KEY_ROWS` rows.
        work: `WORK_ROWS` rows, which hold nothing between rounds: one row of the array a thread.
    """

    robots: NDArray[np.float64]
    food: NDArray[np.float64]
    keys: NDArray[np.uint64]
    work: NDArray[np.float64]


def empty_bodies(blocks: int, foods: int) -> Bodies:
    """Room for some blocks, and for all threads that may work on them."""
    return Bodies(
        np.zeros((blocks, at.ROBOT_ROWS * LANES)),
        np.zeros((blocks, foods * at.FOOD_ROWS * LANES)),
        np.zeros((blocks, at.KEY_ROWS * LANES), np.uint64),
        np.zeros((most_threads_for(blocks), at.WORK_ROWS * LANES)),
    )


@inline
def bodies_of(bodies: Bodies, block: int, thread: int) -> Bodies:
    """Those of one block, as one thread works on them."""
    return Bodies(bodies.robots[block], bodies.food[block], bodies.keys[block], bodies.work[thread])


@inline
def filled(count: int) -> int:
    """A count of lanes rounded up: a loop over it has no rest to be done one by one. What is beyond is not used."""
    stride = min(_STRIDE, LANES)
    return (count + stride - 1) & -stride
