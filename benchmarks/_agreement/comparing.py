"""Two-sample tests, and how surely they find a difference that is there."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from _agreement.samples import Condition, Sample
from khepera_forage.thesis.statistics import Estimate, wilson

LEVEL = 0.05
Floats = NDArray[np.float64]


class Comparison(NamedTuple):
    """One measure of one condition in both simulators.

    Attributes:
        condition: Who forages where.
        measure: A field of `Sample`.
        wheel_speed: Of the batch's robots; 1 where nothing is planted.
        pymunk: Mean, with its 95 % interval.
        batch: The same.
        difference: Batch less pymunk.
        p_mean: Of a difference of the means this large, if there were none (Welch's test).
        p_shape: Of distributions this far apart, if they were the same (Kolmogorov and Smirnov).
    """

    condition: Condition
    measure: str
    wheel_speed: float
    pymunk: Estimate
    batch: Estimate
    difference: Estimate
    p_mean: float
    p_shape: float


class Power(NamedTuple):
    """How often wheels that are slow would be found, by the steps of recalls; and found where they are not slow.

    Attributes:
        condition: Who forages where.
        by_mean: Share of repeated samples in which the means differ at the 5 % level.
        by_shape: Share in which the distributions do.
        false_by_mean: The same for wheels that are alike.
        false_by_shape: The same for wheels that are alike.
    """

    condition: Condition
    by_mean: Estimate
    by_shape: Estimate
    false_by_mean: Estimate
    false_by_shape: Estimate


def compare(condition: Condition, wheel_speed: float, pymunk: Sample, batch: Sample) -> list[Comparison]:
    """Every measure of one condition."""
    found = []
    for measure in Sample._fields:
        a, b = getattr(pymunk, measure), getattr(batch, measure)
        difference, p_mean = welch(a, b)
        found.append(
            Comparison(condition, measure, wheel_speed, _mean(a), _mean(b), difference, p_mean, shape(a, b))
        )
    return found


def welch(a: Floats, b: Floats) -> tuple[Estimate, float]:
    """Mean of b less mean of a with its 95 % interval, and the p of Welch's test."""
    value = float(b.mean() - a.mean())
    parts = a.var(ddof=1) / len(a), b.var(ddof=1) / len(b)
    spread = math.sqrt(sum(parts))
    if spread == 0.0:  # every recall ended alike
        return Estimate(value, value, value), 1.0 if value == 0.0 else 0.0
    freedom = sum(parts) ** 2 / (parts[0] ** 2 / (len(a) - 1) + parts[1] ** 2 / (len(b) - 1))
    half = float(stats.t.ppf(1 - LEVEL / 2, freedom)) * spread
    return Estimate(value, value - half, value + half), float(2 * stats.t.sf(abs(value) / spread, freedom))


def shape(a: Floats, b: Floats) -> float:
    """The p of the test of Kolmogorov and Smirnov; too large for numbers with many ties, never too small."""
    return float(stats.ks_2samp(a, b, method="asymp").pvalue)


def holm(values: Sequence[float]) -> list[float]:
    """Each p, corrected for the number of tests by Holm's rule: below 0.05 by chance anywhere in 5 % of all runs."""
    adjusted, highest = [0.0] * len(values), 0.0
    for rank, place in enumerate(sorted(range(len(values)), key=lambda k: values[k])):
        highest = max(highest, min(1.0, (len(values) - rank) * values[place]))
        adjusted[place] = highest
    return adjusted


def power(
    condition: Condition, same: Sample, slow: Sample, episodes: int, repeats: int, rng: np.random.Generator
) -> Power:
    """Test samples of the size that pymunk has against samples of the size that the batch has, again and again.

    Both are drawn with replacement from what the batch has played.

    Args:
        condition: Who forages where.
        same: Recalls with wheels of full speed.
        slow: Recalls with slow ones.
        episodes: Of pymunk.
        repeats: How many times.
        rng: Draws the samples.
    """
    found = np.zeros((2, 2), np.int64)
    for _ in range(repeats):
        a = rng.choice(same.steps, episodes)
        for row, other in enumerate((slow, same)):
            b = rng.choice(other.steps, len(other.steps))
            found[row] += welch(a, b)[1] < LEVEL, shape(a, b) < LEVEL
    shares = [Estimate(*(100 * share for share in wilson(int(n), repeats))) for n in found.ravel()]
    return Power(condition, *shares)


def _mean(values: Floats) -> Estimate:
    value, half = float(values.mean()), 1.96 * float(values.std(ddof=1)) / math.sqrt(len(values))
    return Estimate(value, value - half, value + half)
