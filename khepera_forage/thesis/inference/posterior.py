"""What tables A.1 to A.4 say about the decisions: simulated sets, weighted by their likeness to an experiment.

Approximate Bayesian computation by random forests: a forest learns to predict decisions from summary statistics, so
that it finds out which statistics matter. A set that falls into the same leaves as an experiment has similar
statistics; the share of leaves that they have in common is its weight. Weighted sets are the posterior (Raynal et al.
2019, "ABC random forests for Bayesian parameter inference", Bioinformatics 35: 1720-1728; for several parameters
together, the forest predicts all of them, as in distributional random forests).

Sets that the forest has not seen stand in for the thesis to validate it. If the posterior is right, the true value of a
decision is equally likely to have any rank in it (Talts et al. 2018, "Validating Bayesian inference algorithms with
simulation-based calibration"), and an interval that claims 90 % contains it in 90 % of the sets.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.sparse import csr_array
from sklearn.ensemble import RandomForestRegressor

from khepera_forage.estimates import Estimate, bootstrap, percent, ratio
from khepera_forage.thesis.inference.prior import Laboratory, Prior, Range
from khepera_forage.thesis.inference.summary import FITTED, NAMES, SLOPES, thesis_statistics

Floats = NDArray[np.float64]
TREES = 200
LEAST_LEAF = 5
"""Fewest experiments in a leaf, of those that the tree was grown with."""
HELD_OUT = 10
"""One set in this many is not learned: it stands in for the thesis in the validation."""
MUCH = 0.9
"""Error, as a share of the error of a guess, below which the tables say much about a decision."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """A field that the prior draws, and its values in some sets.

    Attributes:
        name: Of the field of `Decisions` or `Noise`.
        readings: Its named readings; empty if it is a number.
        values: One a set; a reading is its place among the readings.
    """

    name: str
    readings: tuple[Any, ...]
    values: Floats

    def of(self, sets: NDArray[np.intp]) -> "Parameter":
        """The same in some of the sets."""
        return Parameter(self.name, self.readings, self.values[sets])

    @property
    def indicators(self) -> Floats:
        """Whether a set has a reading, 0 or 1; shape (sets, readings)."""
        return np.asarray(self.values[:, None] == np.arange(len(self.readings)), dtype=np.float64)

    @property
    def targets(self) -> Floats:
        """What a forest predicts, shape (sets, columns): the number, or one column a reading; variance 1 together."""
        columns = self.indicators if self.readings else self.values[:, None]
        variance = columns.var(axis=0).sum()
        return np.asarray(columns / np.sqrt(variance) if variance > 0 else columns)


def parameters_of(prior: Prior, laboratories: Sequence[Laboratory]) -> list[Parameter]:
    """What the prior draws, in the order of the prior.

    Args:
        prior: Says what is drawn.
        laboratories: One a set.
    """
    found = []
    for name, part in (*prior.decisions.items(), *prior.noise.items()):
        readings = () if isinstance(part, Range) else tuple(part.of)
        drawn = [_value_of(laboratory, name) for laboratory in laboratories]
        values = [readings.index(value) for value in drawn] if readings else drawn
        found.append(Parameter(name, readings, np.array(values, dtype=np.float64)))
    return found


def _value_of(laboratory: Laboratory, name: str) -> Any:
    decisions, noise = laboratory
    return getattr(decisions if hasattr(decisions, name) else noise, name)


def quantiles(values: Floats, weights: Floats, shares: Sequence[float]) -> list[float]:
    """Smallest values that at least a share of the weight does not exceed.

    Args:
        values: One a set.
        weights: One a set; their sum need not be 1.
        shares: 0 to 1.
    """
    found: list[float] = np.quantile(values, shares, weights=weights, method="inverted_cdf").tolist()
    return found


def rank(values: Floats, weights: Floats, value: float, percent: float = 100.0) -> float:
    """Percent of the weight that lies below a value; equal values count half.

    Args:
        values: One a set; nan is left out.
        weights: One a set.
        value: To be ranked.
        percent: Rank above all values.
    """
    known = np.isfinite(values)
    values, weights = values[known], weights[known]
    below = weights[values < value - 1e-9].sum() + 0.5 * weights[np.abs(values - value) <= 1e-9].sum()
    return float(percent * below / weights.sum()) if weights.sum() > 0 else float("nan")


def effective_number(weights: Floats) -> float:
    """How many sets of equal weight are as many (Kish's effective sample size)."""
    return float(weights.sum() ** 2 / (weights**2).sum())


def sample(weights: Floats, count: int, rng: Generator) -> NDArray[np.intp]:
    """Numbers of sets, drawn by weight, with systematic sampling: each set about as often as its weight says.

    Args:
        weights: One a set.
        count: Draws.
        rng: Draws the offset and the order.
    """
    points = (np.arange(count) + rng.random()) / count * weights.sum()
    drawn = np.searchsorted(np.cumsum(weights), points, side="right")
    return rng.permutation(np.minimum(drawn, len(weights) - 1))


class SetForest:
    """A forest on the experiments of simulated sets.

    Args:
        statistics: Of the experiments, shape (sets, experiments, statistics); they may be missing (nan).
        targets: What the trees predict, shape (sets, columns).
        seed: Of the forest.
        trees: Number of trees.
    """

    def __init__(self, statistics: Floats, targets: Floats, seed: int, trees: int = TREES) -> None:
        self._sets, experiments, _ = statistics.shape
        self._rows = np.ascontiguousarray(statistics.reshape(self._sets * experiments, -1), dtype=np.float32)
        self._owners = np.repeat(np.arange(self._sets), experiments)
        forest = RandomForestRegressor(
            trees,
            min_samples_leaf=LEAST_LEAF,
            max_features=1 / 3,
            max_samples=self._sets,  # about one experiment of each set, and others in the next tree
            random_state=seed,
        )
        values = targets[self._owners]
        self._trees = [
            one.tree_
            for one in forest.fit(self._rows, values[:, 0] if values.shape[1] == 1 else values).estimators_
        ]

    def weights(self, observed: Floats) -> Floats:
        """How much each set counts, given the statistics of an experiment.

        Args:
            observed: Statistics of some experiments, shape (queries, statistics).

        Returns:
            Shape (queries, sets); each row sums to 1.
        """
        queries = np.ascontiguousarray(observed, dtype=np.float32)
        total = np.zeros((len(queries), self._sets))
        for tree in self._trees:
            leaves = tree.apply(self._rows)
            size = np.bincount(leaves, minlength=tree.node_count)
            shares = csr_array((1.0 / size[leaves], (leaves, self._owners)), (tree.node_count, self._sets))
            total += shares[tree.apply(queries)].toarray()
        return total / len(self._trees)


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
        half: Percent of true values in the central 50 % interval.
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
    return percent(int((np.abs(ranks - 0.5) <= share / 2).sum()), len(ranks))


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


def fitted_columns() -> NDArray[np.intp]:
    """Places of the statistics that are fitted: those of tables A.1 to A.4 that the thesis has."""
    known = np.isfinite(thesis_statistics())
    names = (*NAMES, *SLOPES)
    return np.array([k for k, name in enumerate(names) if name in FITTED and known[k]], dtype=np.intp)


@dataclass(frozen=True, slots=True)
class Posterior:
    """Weights of admissible sets, given the thesis's tables.

    Attributes:
        parameters: What the prior draws, in all admissible sets.
        weights: One an admissible set, 1 together; held-out sets have none.
        calibrations: One a parameter, in the same order.
        held_out: Number of sets that the calibration tried to recover.
    """

    parameters: tuple[Parameter, ...]
    weights: Floats
    calibrations: tuple[Calibration, ...]
    held_out: int


def infer(
    parameters: Sequence[Parameter],
    statistics: NDArray[np.float32],
    seed: int,
    trees: int = TREES,
) -> Posterior:
    """Weight sets by their likeness to the thesis, and validate the weights on sets that were held out.

    Args:
        parameters: What the prior draws, in admissible sets.
        statistics: Of these sets, shape (sets, experiments, statistics of `summary`).
        seed: Of the forest.
        trees: Of the forest.

    Raises:
        ValueError: Fewer than three sets.
    """
    count = len(statistics)
    if count < 3:
        raise ValueError(f"{count} admissible sets; allowed: at least 3, to learn from and to validate with")
    columns = fitted_columns()
    held_out = np.arange(0, count, HELD_OUT)
    learned = np.setdiff1d(np.arange(count), held_out)
    targets = np.hstack([parameter.of(learned).targets for parameter in parameters])
    fitted = statistics[:, :, columns].astype(np.float64)
    forest = SetForest(fitted[learned], targets, seed, trees)
    observed = np.vstack([thesis_statistics()[columns], fitted[held_out, 0]])
    given = forest.weights(observed)
    weights = np.zeros(count)
    weights[learned] = given[0]
    rng = np.random.default_rng(seed)
    calibrations = [
        calibrate(parameter.of(learned), given[1:], parameter.of(held_out), rng) for parameter in parameters
    ]
    return Posterior(tuple(parameters), weights, tuple(calibrations), len(held_out))
