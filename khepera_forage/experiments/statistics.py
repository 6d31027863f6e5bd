"""Bootstrap intervals over replications, and percentile ranks of one experiment among others.

Recalls of one replication share their training files and are not independent; replications are. The bootstrap
therefore resamples whole replications. Statistics are functions of sums over the rows of a replication, so that a
resample is one matrix product: `sums_by_replication` computes the sums, `bootstrap` resamples them.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from typing import NamedTuple, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

RESAMPLES = 2000
COVERAGE = 0.95
MIN_REPLICATIONS = 5
"""Fewest replications for an interval: the range of four values contains the true median with a probability of only
88 %, the range of five values with 94 %."""


class Estimate(NamedTuple):
    """A value and its 95 % interval; nan where the data are not enough."""

    value: float
    low: float
    high: float


UNKNOWN = Estimate(math.nan, math.nan, math.nan)


class PercentileRank(NamedTuple):
    """The rank of a single value among comparable experiments.

    Attributes:
        percentile: Percent of the experiments below the value; equal experiments count half.
        tail: Two-sided probability that one more experiment of the same kind is at least as extreme: twice the
            smaller tail, which includes the value itself, at most 1.
        experiments: Number of experiments.
    """

    percentile: float
    tail: float
    experiments: int


class Replicated(Protocol):
    """A row that belongs to a replication."""

    @property
    def replication(self) -> int:
        """Number of the replication."""
        ...


_R = TypeVar("_R", bound=Replicated)
Measure = Callable[[_R], float]


def replications(*groups: Iterable[Replicated]) -> list[int]:
    """The numbers of the replications in these rows, sorted."""
    return sorted({row.replication for rows in groups for row in rows})


def sums_by_replication(rows: Iterable[_R], numbers: Sequence[int], *measures: Measure[_R]) -> Floats:
    """Sums of measures over the rows of each replication.

    Args:
        rows: Rows, in any order.
        numbers: The replications, one for each line of the result; they include all of the rows.
        *measures: One for each column of the result.
    """
    rows = list(rows)
    line = {number: i for i, number in enumerate(numbers)}
    lines = np.array([line[row.replication] for row in rows], dtype=np.intp)
    sums = [np.bincount(lines, [measure(row) for row in rows], len(numbers)) for measure in measures]
    return np.stack(sums, axis=1)


def ratio(sums: Floats) -> Floats:
    """First column divided by the second, as a mean or a share; nan where the second is 0."""
    return _divide(sums[..., 0], sums[..., 1])


def contrast(*weights: float) -> Callable[[Floats], Floats]:
    """A weighted sum of ratios, each of two columns: `contrast(1, -1)` is the difference of two means."""

    def statistic(sums: Floats) -> Floats:
        means = _divide(sums[..., 0::2], sums[..., 1::2])
        return np.asarray(means @ np.array(weights), dtype=np.float64)

    return statistic


def bootstrap(
    sums: Floats,
    statistic: Callable[[Floats], Floats],
    rng: np.random.Generator,
    resamples: int = RESAMPLES,
) -> Estimate:
    """A statistic of all replications, with its percentile interval over resampled replications.

    Fewer than `MIN_REPLICATIONS` replications give a value without an interval. Resamples in which the statistic is
    undefined are ignored; if they are more than half, there is no interval either.

    Args:
        sums: One line for each replication, from `sums_by_replication`.
        statistic: Takes sums (..., columns) and returns (...).
        rng: Draws the resamples.
        resamples: Number of resamples.
    """
    count = len(sums)
    if not count:
        return UNKNOWN
    value = float(statistic(sums.sum(axis=0)))
    if count < MIN_REPLICATIONS or not math.isfinite(value):
        return Estimate(value, math.nan, math.nan)
    return Estimate(value, *_interval(statistic(_draw(count, rng, resamples) @ sums)))


def bootstrap_quantile(
    rows: Sequence[_R],
    measure: Measure[_R],
    quantile: float,
    rng: np.random.Generator,
    resamples: int = RESAMPLES,
) -> Estimate:
    """A quantile of a measure over all rows, with its interval over resampled replications.

    The quantile is the smallest value that at least this share of the rows does not exceed. It may be infinite.
    """
    if not rows:
        return UNKNOWN
    numbers = replications(rows)
    values = np.array([measure(row) for row in rows])
    order = np.argsort(values)
    owner = np.searchsorted(numbers, [rows[i].replication for i in order])

    def statistic(counts: Floats) -> Floats:
        shares = np.cumsum(counts[..., owner], axis=-1)
        reached = shares >= quantile * shares[..., -1:] - 1e-9
        return np.asarray(values[order][np.argmax(reached, axis=-1)], dtype=np.float64)

    value = float(statistic(np.ones(len(numbers))))
    if len(numbers) < MIN_REPLICATIONS:
        return Estimate(value, math.nan, math.nan)
    draws = statistic(_draw(len(numbers), rng, resamples))
    low, high = np.quantile(draws, [(1 - COVERAGE) / 2, (1 + COVERAGE) / 2], method="inverted_cdf")
    return Estimate(value, float(low), float(high))


def percentile_rank(value: float, experiments: Sequence[float]) -> PercentileRank:
    """The rank of a value among comparable experiments; nan for fewer than two experiments."""
    count = len(experiments)
    if count < 2:
        return PercentileRank(math.nan, math.nan, count)
    sample = np.asarray(experiments, dtype=np.float64)
    equal = int(np.isclose(sample, value, rtol=0.0, atol=1e-9).sum())
    below = int((sample < value - 1e-9).sum())
    above = count - below - equal
    tail = 2.0 * (min(below, above) + equal + 1) / (count + 1)
    return PercentileRank(100.0 * (below + equal / 2) / count, min(1.0, tail), count)


def wilson(successes: int, trials: int) -> Estimate:
    """A share with Wilson's 95 % score interval, for independent trials."""
    if trials == 0:
        return UNKNOWN
    z = 1.959964
    share = successes / trials
    spread = z * math.sqrt(share * (1 - share) / trials + z * z / (4 * trials * trials))
    centre = share + z * z / (2 * trials)
    scale = 1 + z * z / trials
    low, high = (centre - spread) / scale, (centre + spread) / scale
    return Estimate(share, max(0.0, low), min(1.0, high))  # rounding errors may exceed the range


def holm(values: Sequence[float]) -> list[float]:
    """Each p-value corrected for the number of tests by Holm's rule: any is below 0.05 by chance in 5 % of all runs."""
    adjusted, highest = [0.0] * len(values), 0.0
    for rank, place in enumerate(sorted(range(len(values)), key=lambda k: values[k])):
        highest = max(highest, min(1.0, (len(values) - rank) * values[place]))
        adjusted[place] = highest
    return adjusted


def _draw(count: int, rng: np.random.Generator, resamples: int) -> Floats:
    """How often each replication is drawn in each resample."""
    drawn = rng.integers(count, size=(resamples, count)) + count * np.arange(resamples)[:, None]
    return (
        np.bincount(drawn.ravel(), minlength=resamples * count).reshape(resamples, count).astype(np.float64)
    )


def _interval(draws: Floats) -> tuple[float, float]:
    defined = draws[np.isfinite(draws)]
    if 2 * len(defined) < len(draws):
        return math.nan, math.nan
    low, high = np.quantile(defined, [(1 - COVERAGE) / 2, (1 + COVERAGE) / 2])
    return float(low), float(high)


def _divide(numerator: Floats, denominator: Floats) -> Floats:
    """A quotient, nan where the denominator is 0."""
    result = np.full(np.shape(numerator), np.nan)
    np.divide(numerator, denominator, out=result, where=denominator != 0)
    return result
