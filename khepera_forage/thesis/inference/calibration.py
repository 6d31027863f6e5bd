"""Simulation-based calibration: can sets be recovered from an experiment of the thesis's size?

Sets that the forest has not seen stand in for the thesis. If the posterior is right, the true value of a decision is
equally likely to have any rank in it (Talts et al. 2018, "Validating Bayesian inference algorithms with
simulation-based calibration"), and an interval that claims 90 % contains it in 90 % of the sets.
"""

from dataclasses import dataclass
from enum import StrEnum

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from khepera_forage.estimates import Estimate, bootstrap, ratio, wilson
from khepera_forage.thesis.inference.parameters import Parameter

Floats = NDArray[np.float64]
MUCH = 0.9
"""Error, as a share of the error of a guess, below which the tables say much about a decision."""


class Determined(StrEnum):
    """Whether tables of the thesis's size determine a decision."""

    YES = "yes"
    LITTLE = "a little"
    NO = "no"


@dataclass(frozen=True, slots=True)
class Calibration:
    """Of one decision.

    Attributes:
        name: Of the field.
        ranks: Of the true values in their posteriors, 0 to 1, shape (held-out sets,).
        half: Share of true values in the central 50 % interval.
        most: The same for 90 %.
        error: Error of the posterior divided by that of guessing from the prior.
    """

    name: str
    ranks: Floats
    half: Estimate
    most: Estimate
    error: Estimate

    @property
    def determined(self) -> Determined:
        """Whether experiments of this size determine the decision: by the upper end of the error's interval."""
        if not self.error.high < 1.0:
            return Determined.NO
        return Determined.YES if self.error.high < MUCH else Determined.LITTLE


def calibrate(learned: Parameter, weights: Floats, true: Parameter, rng: Generator) -> Calibration:
    """Compare posteriors with true values.

    Args:
        learned: The decision in the sets that the forest has learned.
        weights: Posteriors: weights of these sets, shape (held-out sets, learned sets), each row's sum is 1.
        true: The decision in the held-out sets.
        rng: Orders readings with equal ranks at random; draws resamples.
    """
    ranks = _ranks(learned, weights, true.values, rng)
    guess = np.full(weights.shape[1], 1.0 / weights.shape[1])
    errors = np.stack(
        [_errors(learned, weights, true), _errors(learned, np.broadcast_to(guess, weights.shape), true)],
        axis=1,
    )
    return Calibration(
        learned.name,
        ranks,
        _coverage(ranks, 0.5),
        _coverage(ranks, 0.9),
        bootstrap(errors, ratio, rng),
    )


def _ranks(learned: Parameter, weights: Floats, true: Floats, rng: Generator) -> Floats:
    """Weight below the true value, and a random share of the weight at it: uniform if the posterior is right."""
    ranks = np.empty(len(true))
    for k, (row, value) in enumerate(zip(weights, true, strict=True)):
        ranks[k] = row[learned.values < value].sum() + rng.random() * row[learned.values == value].sum()
    return np.clip(ranks, 0.0, 1.0)


def _coverage(ranks: Floats, share: float) -> Estimate:
    return wilson(int((np.abs(ranks - 0.5) <= share / 2).sum()), len(ranks))


def _errors(learned: Parameter, weights: Floats, true: Parameter) -> Floats:
    """Of each posterior: for readings Brier's score, for numbers the continuous ranked probability score."""
    if learned.readings:
        return np.asarray(((weights @ learned.indicators - true.indicators) ** 2).sum(axis=1))
    order = np.argsort(learned.values)
    values, sorted_weights = learned.values[order], weights[:, order]
    off = np.abs(values - true.values[:, None])
    below = np.cumsum(sorted_weights, axis=1)[:, :-1]
    spread = (below * (1.0 - below) * np.diff(values)).sum(axis=1)  # half the mean difference of two draws
    return np.asarray((sorted_weights * off).sum(axis=1) - spread)
