"""What tables A.1 to A.4 say about the decisions: simulated sets, weighted by their likeness to an experiment.

Approximate Bayesian computation by random forests: a forest learns to predict decisions from summary statistics, so
that it finds out which statistics matter. A set that falls into the same leaves as an experiment has similar
statistics; the share of leaves that they have in common is its weight. Weighted sets are the posterior (Raynal et al.
2019, "ABC random forests for Bayesian parameter inference", Bioinformatics 35: 1720-1728; for several parameters
together, the forest predicts all of them, as in distributional random forests).

Sets that a forest has not seen stand in for the thesis to validate it. If the posterior is right, the true value of a
decision is equally likely to have any rank in it (Talts et al. 2018, "Validating Bayesian inference algorithms with
simulation-based calibration"), and an interval that claims 90 % contains it in 90 % of the sets. Intervals are the
shortest ones, and end where the range does if hardly any weight lies beyond: equal tails can hardly contain a value at
the end of a range, and no draw is exactly there.

A forest finds neighbours for any experiment, even for one that no set resembles. Therefore the experiment is first
compared with all simulated ones.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any, NamedTuple

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy import stats
from scipy.sparse import csr_array
from sklearn.ensemble import RandomForestRegressor

from khepera_forage.estimates import UNKNOWN, Estimate, Floats, bootstrap, holm, percent, ratio
from khepera_forage.thesis.inference.prior import LabModel, Prior, PriorRange

TREES = 200
LEAST_LEAF = 5
"""Fewest experiments in a leaf, of those that the tree was grown with."""
HELD_OUT, VALIDATED = 10, 1000
"""One set in this many is not learned: it stands in for the thesis in the validation. Other sets follow, with another
forest each time, until about this many have been held out."""
CLASSES = 10
"""Of ranks, to test whether all are equally frequent."""
NEIGHBOURS, COMPARED = 50, 1000
"""Nearest experiments, and most experiments that are compared with the observed one."""
MOST_OUTSIDE = 0.2
"""Share of the statistics outside the central 95 % above which simulated experiments do not resemble the observed one;
statistics of one experiment depend on each other."""
UNBOUNDED = (-math.inf, math.inf)


@dataclass(frozen=True, slots=True)
class Parameter:
    """A field that the prior draws, and its values in some sets.

    Attributes:
        alternatives: Named ones; empty if the field is a number.
        values: One a set; an alternative is its place among the alternatives.
        ends: Least and greatest number of the prior.
    """

    name: str
    alternatives: tuple[Any, ...]
    values: Floats
    ends: tuple[float, float] = UNBOUNDED

    def of(self, sets: NDArray[np.intp]) -> "Parameter":
        """The same in some of the sets."""
        return replace(self, values=self.values[sets])

    @property
    def indicators(self) -> Floats:
        """Whether a set has an alternative, 0 or 1; shape (sets, alternatives)."""
        return np.asarray(self.values[:, None] == np.arange(len(self.alternatives)), dtype=np.float64)

    @property
    def targets(self) -> Floats:
        """What a forest predicts, shape (sets, columns): the number, or a column an alternative; variance 1 in all."""
        columns = self.indicators if self.alternatives else self.values[:, None]
        variance = columns.var(axis=0).sum()
        return np.asarray(columns / np.sqrt(variance) if variance > 0 else columns)


def parameters_of(prior: Prior, laboratories: Sequence[LabModel]) -> list[Parameter]:
    """What the prior draws, in the order of the prior, with the values in each laboratory."""
    found = []
    for name, part in prior.parts.items():
        alternatives = () if isinstance(part, PriorRange) else tuple(part.of)
        ends = (part.least, part.most) if isinstance(part, PriorRange) else UNBOUNDED
        drawn = [getattr(lab.decisions if name in prior.decisions else lab.noise, name) for lab in laboratories]
        values = [alternatives.index(value) for value in drawn] if alternatives else drawn
        found.append(Parameter(name, alternatives, np.array(values, dtype=np.float64), ends))
    return found


def quantiles(values: Floats, weights: Floats, shares: Sequence[float]) -> list[float]:
    """Smallest values that at least a share of the weight, 0 to 1, does not exceed."""
    found: list[float] = np.quantile(values, shares, weights=weights, method="inverted_cdf").tolist()
    return found


def shortest(
    values: Floats, weights: Floats, share: float, ends: tuple[float, float] = UNBOUNDED
) -> tuple[float, float]:
    """The shortest interval that contains at least a share of the weight, 0 to 1.

    No draw is exactly at one of the `ends` of the prior. An interval ends there if less weight lies beyond it than that
    of one of as many draws of equal weight.
    """
    values, weights = values[weights > 0], weights[weights > 0]  # most sets share no leaf with an experiment
    order = np.argsort(values)
    ordered, below = values[order], np.concatenate([[0.0], np.cumsum(weights[order])])
    last = np.searchsorted(below, below[:-1] + share * below[-1] - 1e-12, side="left") - 1
    possible = last < len(ordered)
    first = np.flatnonzero(possible)
    last = np.maximum(last[possible], first)
    best = int(np.argmin(ordered[last] - ordered[first]))
    left, right = below[first[best]], below[-1] - below[last[best] + 1]
    one = (1 - 1e-9) * below[-1] / effective_number(weights)
    low = ends[0] if left < one else float(ordered[first[best]])
    high = ends[1] if right < one else float(ordered[last[best]])
    return low, high


def rank(values: Floats, weights: Floats, value: float) -> float:
    """Percent of the weight that lies below a value; equal values count half, and nan is left out."""
    known = np.isfinite(values)
    values, weights = values[known], weights[known]
    below = weights[values < value - 1e-9].sum() + 0.5 * weights[np.abs(values - value) <= 1e-9].sum()
    return float(100.0 * below / weights.sum()) if weights.sum() > 0 else float("nan")


def central(values: Floats, weights: Floats) -> Estimate:
    """Median and central 95 % of values that may be missing."""
    known = np.isfinite(values)
    if not weights[known].sum() > 0:
        return UNKNOWN
    return Estimate(*quantiles(values[known], weights[known], (0.5, 0.025, 0.975)))


def effective_number(weights: Floats) -> float:
    """How many sets of equal weight are as many (Kish's effective sample size)."""
    return float(weights.sum() ** 2 / (weights**2).sum())


def forest_weights(statistics: Floats, targets: Floats, queries: Floats, seed: int, trees: int = TREES) -> Floats:
    """How much each simulated set counts for some experiments, shape (queries, sets); each row's sum is 1.

    Trees predict the targets, shape (sets, columns), from the statistics of the experiments under the sets, shape
    (sets, experiments, statistics), which may be missing (nan). Queries have the shape (queries, statistics).
    """
    sets, experiments, _ = statistics.shape
    rows = np.ascontiguousarray(statistics.reshape(sets * experiments, -1), dtype=np.float32)
    owners, asked = np.repeat(np.arange(sets), experiments), np.ascontiguousarray(queries, dtype=np.float32)
    forest = RandomForestRegressor(
        trees,
        min_samples_leaf=LEAST_LEAF,
        max_features=1 / 3,
        max_samples=sets,  # about one experiment of each set, and others in the next tree
        random_state=seed,
        n_jobs=-1,
    )
    values = targets[owners]
    forest.fit(rows, values[:, 0] if values.shape[1] == 1 else values)
    total = csr_array((len(asked), sets))
    for tree in (one.tree_ for one in forest.estimators_):
        leaves = tree.apply(rows)
        size = np.bincount(leaves, minlength=tree.node_count)
        shares = csr_array((1.0 / size[leaves], (leaves, owners)), (tree.node_count, sets))
        total = total + shares[tree.apply(asked)]
    return np.asarray(total.toarray() / trees)


class Told(StrEnum):
    """Whether tables of the thesis's size say anything about a decision."""

    SOMETHING = "something"
    NOTHING = "nothing"
    UNCALIBRATED = "not calibrated"


@dataclass(frozen=True, slots=True)
class Coverage:
    """Of one decision.

    Attributes:
        ranks: Of the true values in their posteriors, 0 to 1, one a held-out set.
        half: Percent of true values in the 50 % interval: the shortest one of a number, the central one of an
            alternative.
        most: The same for 90 %.
        error: Error of the posterior divided by that of guessing from the prior.
        equal_ranks: p-value of the test whether all ranks are equally frequent; nan with few sets.
        corrected: The same after correction for the number of decisions.
    """

    name: str
    ranks: Floats
    half: Estimate
    most: Estimate
    error: Estimate
    equal_ranks: float
    corrected: float = 1.0

    @property
    def told(self) -> Told:
        """By the upper end of the error's interval; never if posteriors are wrong, or validated with too few sets."""
        if not self.error.high < 1.0:
            return Told.NOTHING
        calibrated = np.isfinite(self.equal_ranks) and self.corrected >= 0.05
        return Told.SOMETHING if calibrated else Told.UNCALIBRATED


def calibrate(learned: Parameter, weights: Floats, true: Parameter, rng: Generator, guesses: Floats) -> Coverage:
    """Compare posteriors with true values: those of a decision in held-out sets.

    `learned` is the decision in all sets that forests have learned. A posterior is the weights of these sets, a row of
    `weights`; `guesses` are the same without any tables.
    """
    # Weight below the true value, and a random share of the weight at it: uniform if the posterior is right.
    ranks = np.empty(len(true.values))
    for k, (row, value) in enumerate(zip(weights, true.values, strict=True)):
        ranks[k] = row[learned.values < value].sum() + rng.random() * row[learned.values == value].sum()
    ranks = np.clip(ranks, 0.0, 1.0)
    errors = np.stack([_errors(learned, some, true) for some in (weights, guesses)], axis=1)
    counts, _ = np.histogram(ranks, CLASSES, range=(0.0, 1.0))
    return Coverage(
        learned.name,
        ranks,
        _coverage(learned, weights, true, ranks, 0.5),
        _coverage(learned, weights, true, ranks, 0.9),
        bootstrap(errors, ratio, rng),
        float(stats.chisquare(counts).pvalue) if len(ranks) >= 5 * CLASSES else float("nan"),
    )


def _coverage(learned: Parameter, weights: Floats, true: Parameter, ranks: Floats, share: float) -> Estimate:
    """Percent of the true values in an interval of their posteriors."""
    if learned.alternatives:
        inside = np.abs(ranks - 0.5) <= share / 2
    else:
        low, high = np.array([shortest(learned.values, row, share, learned.ends) for row in weights]).T
        inside = (low <= true.values) & (true.values <= high)
    return percent(int(inside.sum()), len(inside))


def _errors(learned: Parameter, weights: Floats, true: Parameter) -> Floats:
    """Of each posterior: for alternatives Brier's score, for numbers the continuous ranked probability score."""
    if learned.alternatives:
        return np.asarray(((weights @ learned.indicators - true.indicators) ** 2).sum(axis=1))
    order = np.argsort(learned.values)
    values, sorted_weights = learned.values[order], weights[:, order]
    off = np.abs(values - true.values[:, None])
    below = np.cumsum(sorted_weights, axis=1)[:, :-1]
    spread = (below * (1.0 - below)) @ np.diff(values)  # half the mean difference of two draws
    return np.asarray((sorted_weights * off).sum(axis=1) - spread)


class PriorCheck(NamedTuple):
    """How an experiment compares with the simulated ones.

    Attributes:
        intervals: Median and central 95 % of each statistic over all simulated experiments.
        ranks: Percent of them below the experiment's value; nan if the experiment has none.
        tail: Probability that a simulated experiment is at least as far from those of other sets.
        neighbours: Number of nearest experiments whose mean distance is compared.
    """

    intervals: list[Estimate]
    ranks: Floats
    tail: float
    neighbours: int

    @property
    def outside(self) -> int:
        """Number of statistics outside the central 95 %."""
        return int(((self.ranks < 2.5) | (self.ranks > 97.5)).sum())

    @property
    def warning(self) -> str:
        """One sentence if the simulated sets do not resemble the experiment, otherwise empty."""
        count = int(np.isfinite(self.ranks).sum())
        if self.outside <= MOST_OUTSIDE * count and self.tail >= 0.05:
            return ""
        return (
            f"The simulated sets do not resemble these tables: {self.outside} of {count} statistics are outside the "
            f"central 95 % of simulated experiments, joint p {self.tail:.3f}. The forest interpolates all the same, so "
            "that its posterior may mean nothing."
        )


def prior_check(statistics: NDArray[np.float32], observed: Floats, rng: Generator) -> PriorCheck:
    """Compare an experiment with all simulated ones, statistic by statistic and jointly; `rng` chooses some of these.

    The statistics, shape (sets, experiments, statistics), may be missing.
    """
    sets, experiments, width = statistics.shape
    flat = statistics.reshape(-1, width).astype(np.float64)
    even = np.ones(len(flat))
    intervals = [central(column, even) for column in flat.T]
    pairs = zip(flat.T, observed, strict=True)
    ranks = [rank(column, even, float(value)) if np.isfinite(value) else np.nan for column, value in pairs]
    middle = np.array([interval.value for interval in intervals])
    spread = np.nanstd(flat, axis=0)
    spread[~(spread > 0)] = 1.0

    def scaled(values: Floats) -> Floats:
        return np.asarray(np.where(np.isfinite(values), values - middle, 0.0) / spread)

    points, owners = scaled(flat), np.repeat(np.arange(sets), experiments)
    neighbours = min(NEIGHBOURS, len(points) - experiments)

    def distance(point: Floats, owner: int) -> float:
        squares = ((points[owners != owner] - point) ** 2).sum(axis=1)
        return float(np.sqrt(np.partition(squares, neighbours - 1)[:neighbours]).mean())

    own = distance(scaled(observed), -1)
    chosen = rng.permutation(sets)[:COMPARED]
    others = [distance(points[k * experiments + int(rng.integers(experiments))], int(k)) for k in chosen]
    farther = sum(other >= own for other in others)
    return PriorCheck(intervals, np.array(ranks), (1 + farther) / (1 + len(others)), neighbours)


@dataclass(frozen=True, slots=True)
class Posterior:
    """Weights of admissible sets, 1 together, given the tables of an experiment.

    Attributes:
        parameters: What the prior draws, in all admissible sets.
        calibrations: One a parameter, in the same order.
        held_out: Number of sets that the calibration tried to recover from forests without them.
        check: How the experiment compares with the simulated ones.
    """

    parameters: tuple[Parameter, ...]
    weights: Floats
    calibrations: tuple[Coverage, ...]
    held_out: int
    check: PriorCheck


def infer(
    parameters: Sequence[Parameter], statistics: NDArray[np.float32], observed: Floats, seed: int, trees: int = TREES
) -> Posterior:
    """Weight sets by their likeness to an experiment, and validate the weights on sets that were held out.

    The statistics of at least three admissible sets are the fitted ones, shape (sets, experiments, statistics).
    """
    count = len(statistics)
    targets = np.hstack([parameter.targets for parameter in parameters])
    fitted = statistics.astype(np.float64)
    weights = forest_weights(fitted, targets, observed[None], seed, trees)[0]
    folds = [np.arange(fold, count, HELD_OUT) for fold in range(min(HELD_OUT, count))]
    folds = folds[: math.ceil(VALIDATED / len(folds[0]))]
    held_out = np.concatenate(folds)
    posteriors, guesses = np.zeros((2, len(held_out), count))
    for fold in folds:
        learned, rows = np.setdiff1d(np.arange(count), fold), np.isin(held_out, fold)
        posteriors[np.ix_(rows, learned)] = forest_weights(
            fitted[learned], targets[learned], fitted[fold, 0], seed, trees
        )
        guesses[np.ix_(rows, learned)] = 1 / len(learned)
    rng = np.random.default_rng(seed)
    found = [calibrate(one, posteriors, one.of(held_out), rng, guesses) for one in parameters]
    corrected = holm([1.0 if np.isnan(one.equal_ranks) else one.equal_ranks for one in found])
    calibrations = tuple(replace(one, corrected=p) for one, p in zip(found, corrected, strict=True))
    check = prior_check(statistics, observed, rng)
    return Posterior(tuple(parameters), weights, calibrations, len(held_out), check)
