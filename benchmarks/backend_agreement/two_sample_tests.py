"""Two-sample tests, and their power to detect a difference."""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from backend_agreement.samples import Condition, Sample
from khepera_forage.estimates import Estimate, percent

LEVEL = 0.05
Floats = NDArray[np.float64]


class Comparison(NamedTuple):
    """One quantity of one condition on both backends.

    Attributes:
        condition: Policy and arena.
        measure: A field of `Sample`.
        pymunk: Mean, with its 95 % interval.
        compiled: The same.
        difference: Compiled minus pymunk.
        p_mean: Of equal means (Welch's test).
        p_distribution: Of equal distributions (Kolmogorov-Smirnov test).
    """

    condition: Condition
    measure: str
    pymunk: Estimate
    compiled: Estimate
    difference: Estimate
    p_mean: float
    p_distribution: float


class Power(NamedTuple):
    """Rates at which tests on the steps of recalls detect slow wheels, and false alarms with equal wheels.

    Attributes:
        condition: Policy and arena.
        by_mean: Share of repeated samples with slow wheels in which the means differ at the 5 % level.
        by_distribution: Share in which the distributions differ.
        false_by_mean: The same with equal wheels.
        false_by_distribution: The same with equal wheels.
    """

    condition: Condition
    by_mean: Estimate
    by_distribution: Estimate
    false_by_mean: Estimate
    false_by_distribution: Estimate


def compare(condition: Condition, pymunk: Sample, compiled: Sample) -> list[Comparison]:
    """Every quantity of one condition."""
    found = []
    for measure in Sample._fields:
        a, b = getattr(pymunk, measure), getattr(compiled, measure)
        difference, p_mean = welch(a, b)
        found.append(
            Comparison(
                condition, measure, mean_of(a), mean_of(b), difference, p_mean, kolmogorov_smirnov(a, b)
            )
        )
    return found


def welch(a: Floats, b: Floats) -> tuple[Estimate, float]:
    """Mean of b minus mean of a with its 95 % interval, and the p-value of Welch's test."""
    value = float(b.mean() - a.mean())
    parts = a.var(ddof=1) / len(a), b.var(ddof=1) / len(b)
    spread = math.sqrt(sum(parts))
    if spread == 0.0:  # all values of a sample are equal
        return Estimate(value, value, value), 1.0 if value == 0.0 else 0.0
    freedom = sum(parts) ** 2 / (parts[0] ** 2 / (len(a) - 1) + parts[1] ** 2 / (len(b) - 1))
    half = float(stats.t.ppf(1 - LEVEL / 2, freedom)) * spread
    return Estimate(value, value - half, value + half), float(2 * stats.t.sf(abs(value) / spread, freedom))


def mean_of(values: Floats) -> Estimate:
    """The mean with its 95 % interval."""
    value, half = float(values.mean()), 1.96 * float(values.std(ddof=1)) / math.sqrt(len(values))
    return Estimate(value, value - half, value + half)


def kolmogorov_smirnov(a: Floats, b: Floats) -> float:
    """The p-value of the Kolmogorov-Smirnov test; too large for numbers with many ties, never too small."""
    return float(stats.ks_2samp(a, b, method="asymp").pvalue)


def power(
    condition: Condition, equal: Sample, slow: Sample, episodes: int, repeats: int, rng: np.random.Generator
) -> Power:
    """Test samples of pymunk's size against samples of the compiled size, again and again.

    Both are drawn with replacement from compiled recalls.

    Args:
        condition: Policy and arena.
        equal: Recalls with wheels of full speed.
        slow: Recalls with slow wheels.
        episodes: Of pymunk.
        repeats: How many times.
        rng: Draws the samples.
    """
    found = np.zeros((2, 2), np.int64)
    for _ in range(repeats):
        a = rng.choice(equal.steps, episodes)
        for row, other in enumerate((slow, equal)):
            b = rng.choice(other.steps, len(other.steps))
            found[row] += welch(a, b)[1] < LEVEL, kolmogorov_smirnov(a, b) < LEVEL
    return Power(condition, *(percent(int(count), repeats) for count in found.ravel()))
