"""Quantiles, shares and samples of weighted sets."""

from collections.abc import Sequence

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

Floats = NDArray[np.float64]


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
