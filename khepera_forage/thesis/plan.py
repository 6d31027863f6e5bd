"""What a reproduction consists of: pieces of work that can be done in any order, one by one or in batches."""

from collections.abc import Iterator
from typing import NamedTuple, Protocol

from khepera_forage.rollouts.rows import RANDOM, TEACHER
from khepera_forage.thesis.design import (
    LABORATORY,
    NO_LOSSES,
    NO_NOISE,
    THESIS,
    Cell,
    noise_conditions,
)
from khepera_forage.thesis.replication import Attempts, Baseline, Outcome, Replication
from khepera_forage.thesis.statistics import FEWEST

PYMUNK, BATCH = "pymunk", "batch"
NOISE_CELLS: tuple[Cell, ...] = tuple(cell for cell in THESIS if cell.episodes == 10)
"""What is repeated under each single source of noise: ten training episodes, recalls in both arenas."""


class Work(Protocol):
    """A piece of the whole, which can be done in any order."""

    def run(self) -> Outcome:
        """Do it, and return the rows."""
        ...


class Amounts(NamedTuple):
    """How much of everything there is.

    Attributes:
        replications: Of the whole design.
        others: Of ten episodes' training and recalls, under each other noise condition.
        conditions: Those.
        blocks: Of forages of the teacher and of a random policy.
        forages: In each block of the teacher's; the random policy has a fifth of them.
    """

    replications: int
    others: int
    conditions: tuple[str, ...]
    blocks: int
    forages: int


def amounts(replications: int, physics: str, quick: bool = False) -> Amounts:
    """What goes with so many replications.

    Args:
        replications: Of the whole design; other noise conditions get a share of it, and enough for intervals.
        physics: `pymunk` or `batch`.
        quick: Only enough to exercise every part.
    """
    if quick:
        return Amounts(replications, 1, (NO_NOISE,), 2, 5)
    conditions = tuple(name for name in noise_conditions() if name != LABORATORY)
    share = 3 if physics == PYMUNK else 10
    return Amounts(replications, max(FEWEST, replications // share), conditions, 20, 25)


def plan(seed: int, how_much: Amounts) -> list[Work]:
    """All pieces of work with pymunk, the slowest kind first."""
    work: list[Work] = [Replication(seed, i) for i in range(how_much.replications)]
    for noise in how_much.conditions:
        work += [Replication(seed, i, noise, NOISE_CELLS) for i in range(how_much.others)]
    # Without losses only the attempts count, and there are to be as many of them as with losses.
    if NO_LOSSES in how_much.conditions:
        work += [Attempts(seed, i) for i in range(how_much.others, how_much.replications)]
    for arena, learner, forages in _baselines(how_much):
        work += [Baseline(seed, i, learner, arena, forages) for i in range(how_much.blocks)]
    return work


def batch_plan(seed: int, how_much: Amounts) -> list[Work]:
    """The same in batches.

    Raises:
        ImportError: numba is not installed.
    """
    try:
        from khepera_forage.thesis.compiled_replications import SIZE, BaselineBatch, ReplicationBatch
    except ImportError as missing:
        raise ImportError(
            "--physics batch needs numba: pip install 'khepera-forage[fast]', or take --physics pymunk"
        ) from missing

    def batches(count: int, noise: str, cells: tuple[Cell, ...]) -> list[Work]:
        return [
            ReplicationBatch(seed, first, min(SIZE, count - first), noise, cells)
            for first in range(0, count, SIZE)
        ]

    work = batches(how_much.replications, LABORATORY, THESIS)
    for noise in how_much.conditions:
        work += batches(how_much.others, noise, NOISE_CELLS)
    return work + [
        BaselineBatch(seed, how_much.blocks, learner, arena, forages)
        for arena, learner, forages in _baselines(how_much)
    ]


def _baselines(how_much: Amounts) -> Iterator[tuple[str, str, int]]:
    for arena in ("corridor", "rectangle"):
        yield arena, TEACHER, how_much.forages
        yield arena, RANDOM, how_much.forages // 5
