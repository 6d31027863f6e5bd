"""The records of all blocks of worlds, or of one block."""

from typing import Any, NamedTuple

from khepera_forage.compilation.aligned import aligned_zeros
from khepera_forage.compilation.decorators import sequence
from khepera_forage.compilation.threads import most_threads_for
from khepera_forage.sim.compiled.near_walls import lists_of
from khepera_forage.sim.compiled.records import (
    LANES,
    detection_dtype,
    food_dtype,
    robot_dtype,
    scratch_dtype,
    track_dtype,
)

APART = 8
"""Rows of a small scratch array from one thread to the next. Neighbours would write to the same cache line, and wait
for one another."""


class Bodies(NamedTuple):
    """Robots, food and tracks of all blocks; `bodies_of` gives those of one block.

    Attributes:
        robots: `robot_dtype`, shape (blocks,); of one block a record.
        foods: `food_dtype`, shape (blocks, foods); of one block an array with one record a food object.
        tracks: `track_dtype`, shape (blocks, lanes, 2 * foods); of one block shape (lanes, 2 * foods).
        scratch: `scratch_dtype`, shape (threads,); of one block a record. It holds nothing between rounds.
        detections: `detection_dtype`, shape (threads * APART, foods); of one block an array. It holds nothing between
            rounds.
        near: `Near` if worlds are in different arenas, and otherwise an empty tuple.
    """

    robots: Any
    foods: Any
    tracks: Any
    scratch: Any
    detections: Any
    near: Any = ()


def empty_bodies(blocks: int, foods: int, lanes: int = LANES, near: Any = ()) -> Bodies:
    """Records for some blocks, and for all threads that may work on them.

    Args:
        blocks: How many.
        foods: Food objects in each world.
        lanes: Worlds in a block.
        near: From `near_walls.empty_lists`, if worlds are in different arenas.
    """
    threads = most_threads_for(blocks)
    return Bodies(
        aligned_zeros(blocks, robot_dtype(lanes)),
        aligned_zeros((blocks, foods), food_dtype(lanes)),
        aligned_zeros((blocks, lanes, 2 * foods), track_dtype),
        aligned_zeros(threads, scratch_dtype(lanes)),
        aligned_zeros((threads * APART, foods), detection_dtype),
        near,
    )


@sequence  # compiled functions cannot return records within a tuple
def bodies_of(bodies: Bodies, block: int, thread: int) -> Bodies:
    """The records of one block, and the scratch records of one thread."""
    return Bodies(
        bodies.robots[block],
        bodies.foods[block],
        bodies.tracks[block],
        bodies.scratch[thread],
        bodies.detections[thread * APART],
        lists_of(bodies.near, block),
    )
