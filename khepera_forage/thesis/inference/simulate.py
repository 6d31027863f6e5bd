"""The thesis's design, replicated under one laboratory: what the tables would say if it had been the thesis's."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.rollouts.compiled.training import train_learners
from khepera_forage.thesis.compiled_replications import recalls_of
from khepera_forage.thesis.design import THESIS, files_needed
from khepera_forage.thesis.inference.admissible import Check, check
from khepera_forage.thesis.inference.prior import Laboratory, Prior
from khepera_forage.thesis.inference.summary import CellRecalls, of_recalls, with_slopes


class Simulated(NamedTuple):
    """One set of decisions from the prior.

    Attributes:
        laboratory: Decisions and noise.
        check: Whether it is admissible.
        statistics: Of each experiment, shape (experiments, statistics of `summary`); empty if it is not admissible.
    """

    laboratory: Laboratory
    check: Check
    statistics: NDArray[np.float64]


def simulate(prior: Prior, seed: int, number: int, experiments: int) -> Simulated:
    """Draw a set from the prior, check it, and replicate the thesis under it if it is admissible.

    Args:
        prior: To draw from.
        seed: Of all sets.
        number: Of this set: it depends on seed and number alone.
        experiments: Replications of the whole design.
    """
    rng = np.random.default_rng((seed, number))
    laboratory = prior.draw(rng)
    first = int(rng.integers(2**62))
    found = check(laboratory, first)
    if found.reason:
        return Simulated(laboratory, found, np.zeros((0, 0)))
    return Simulated(laboratory, found, replicate(laboratory, first + 1, experiments))


def replicate(laboratory: Laboratory, seed: int, experiments: int) -> NDArray[np.float64]:
    """The statistics of some experiments of the thesis's size, shape (experiments, statistics).

    Args:
        laboratory: Decisions and noise.
        seed: Of the experiments.
        experiments: How many.
    """
    cells = recalls_under(laboratory, seed, experiments)
    return with_slopes([of_recalls(cell, recalls) for cell, recalls in zip(THESIS, cells, strict=True)])


def recalls_under(laboratory: Laboratory, seed: int, experiments: int) -> list[CellRecalls]:
    """The recalls of some experiments of the thesis's size, one element a cell of `THESIS`.

    Args:
        laboratory: Decisions and noise.
        seed: Of the experiments.
        experiments: How many.
    """
    decisions, noise = laboratory
    training, recalling = np.random.SeedSequence(seed).spawn(2)
    trained = train_learners(
        experiments,
        seed=int(training.generate_state(1)[0]),
        noise=noise,
        episodes=files_needed(THESIS),
        decisions=decisions,
    )
    cells = []
    for cell, seeds in zip(THESIS, recalling.spawn(len(THESIS)), strict=True):
        numbers = seeds.generate_state(experiments * cell.size).astype(np.int64)
        played = recalls_of(cell, trained, experiments, numbers, noise, decisions)
        shape = (experiments, len(cell.subsets), cell.recalls)
        arrays = (played.correct, played.steps, played.delivered, played.penalty)
        cells.append(CellRecalls(*(array.astype(np.float64).reshape(shape) for array in arrays)))
    return cells
