"""The page of the questions to ask the author: which true values would tell us most?"""

from typing import NamedTuple

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from khepera_forage.estimates import Column, Table
from khepera_forage.study import Page
from khepera_forage.task.decisions import FIELDS
from khepera_forage.thesis.inference.parameters import Parameter
from khepera_forage.thesis.inference.posterior import Posterior
from khepera_forage.thesis.inference.summary import NAMES
from khepera_forage.thesis.inference.weighted import quantiles

Floats = NDArray[np.float64]
PARTS = 5
"""Classes of a number, of equal weight."""
PERMUTATIONS = 200
QUESTIONS = 3


class Explained(NamedTuple):
    """Of one decision.

    Attributes:
        name: Of the field.
        share: Of the posterior variance of the fourteen means that knowing it would remove on average.
        chance: The largest share of 95 % of decisions without any influence.
    """

    name: str
    share: float
    chance: float


def page(posterior: Posterior, statistics: NDArray[np.float32], seed: int) -> Page:
    """The decisions in the order of what their true values would tell."""
    rng = np.random.default_rng(seed)
    means = outcomes(statistics)
    found = [explained(parameter, posterior.weights, means, rng) for parameter in posterior.parameters]
    found.sort(key=lambda one: one.chance - one.share)
    return Page(
        "What to ask the author",
        [
            "What would we know better about the results if the true value of one decision were known? The posterior "
            "leaves the fourteen means of the thesis's design (score and food of each cell) uncertain. Knowing a "
            "decision would remove a share of that variance.",
            "\n".join(f"{k + 1}. {_question(one.name)}" for k, one in enumerate(found[:QUESTIONS])),
            _table(found),
        ],
    )


def outcomes(statistics: NDArray[np.float32]) -> Floats:
    """Mean score and share of food of each cell under each set, shape (sets, 14)."""
    columns = [k for k, name in enumerate(NAMES) if name.endswith((" score", " food"))]
    return np.asarray(statistics[:, :, columns].mean(axis=1), dtype=np.float64)


def explained(parameter: Parameter, weights: Floats, means: Floats, rng: Generator) -> Explained:
    """How much of the variance of the means a decision explains.

    Args:
        parameter: In all sets.
        weights: One a set.
        means: Shape (sets, outcomes).
        rng: Draws the permutations that show what chance explains.
    """
    used = weights > 0
    weights, means = weights[used] / weights.sum(), means[used]
    centre = weights @ means
    variance = weights @ (means - centre) ** 2
    varies = variance > 1e-12 * (centre**2 + variance)
    if not varies.any():
        return Explained(parameter.name, 0.0, 0.0)
    means = (means - centre)[:, varies] / np.sqrt(variance[varies])
    classes = _classes(parameter, used, weights)
    # Weights and means stay together, so that chance includes what a few heavy sets can do.
    by_chance = [_between(rng.permutation(classes), weights, means) for _ in range(PERMUTATIONS)]
    return Explained(parameter.name, _between(classes, weights, means), float(np.quantile(by_chance, 0.95)))


def _between(classes: Floats, weights: Floats, means: Floats) -> float:
    """Variance between classes of outcomes that have mean 0 and variance 1, on average over outcomes."""
    within = classes.T @ weights
    sums = (classes * weights[:, None]).T @ means
    return float((sums[within > 0] ** 2 / within[within > 0, None]).sum(axis=0).mean())


def _classes(parameter: Parameter, used: NDArray[np.bool_], weights: Floats) -> Floats:
    """Whether a set belongs to a class, 0 or 1; shape (sets, classes)."""
    if parameter.readings:
        return parameter.indicators[used]
    values = parameter.values[used]
    ends = quantiles(values, weights, [k / PARTS for k in range(1, PARTS)])
    return np.asarray(np.searchsorted(ends, values)[:, None] == np.arange(PARTS), dtype=np.float64)


def _question(name: str) -> str:
    if name in FIELDS:
        return f"`{name}` (section {FIELDS[name].section}). {FIELDS[name].reason}"
    return f"`{name}`: how exactly were robots and food placed by hand, and seen by the camera?"


def _table(found: list[Explained]) -> Table:
    return Table(
        "questions",
        "What knowing a decision would explain",
        "Share of the posterior variance of the fourteen means that the decision explains (correlation ratio; a number "
        f"is divided into {PARTS} classes of equal weight), and what 95 % of decisions without any influence stay "
        "below, which is the upper end of chance.",
        (Column("decision or noise"), Column("explained (%)"), Column("by chance (%)")),
        [(one.name, 100 * one.share, 100 * one.chance) for one in found],
    )
