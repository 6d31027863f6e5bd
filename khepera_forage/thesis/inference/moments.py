"""Which single set fits tables A.1 to A.4 best? The forest weights sets, but does not say.

A set is compatible with the tables if the thesis is no surprise among the set's own experiments. The test is that of
the method of simulated moments (McFadden 1989, "A method of simulated moments for estimation of discrete response
models without numerical integration", Econometrica 57: 995-1026): the squared distance of 23 statistics in the spread
of experiments is about 23 for an experiment of the set itself. Many sets are compatible. Among them, the best is the
one whose mean scores, mean shares of food and slopes of both over training episodes are nearest to the thesis's.
Slopes follow from means, but count again: between sets, the means of cells go up and down together, and sets in which a
learner learns little from more episodes would otherwise fit as well.
"""

import math

import numpy as np
from numpy.typing import NDArray

from khepera_forage.thesis.inference.posterior import fitted_columns
from khepera_forage.thesis.inference.summary import NAMES, SLOPES, thesis_statistics

Floats = NDArray[np.float64]
_OWN_CORRELATION = 0.8
"""Share of the correlations that are believed; it keeps their matrix well-conditioned."""
_USUAL = 5
"""Weight of the usual spread beside that of a set's own experiments, which are few."""


class Moments:
    """How well sets fit the corridor's tables.

    Args:
        statistics: Of sets, shape (sets, experiments, statistics of `summary`).
        weights: One a set. Their experiments, weighted, say how much statistics usually vary from one experiment to
            another under a set, and together.
    """

    def __init__(self, statistics: NDArray[np.float32], weights: Floats) -> None:
        self._columns = fitted_columns()
        self._thesis = thesis_statistics()[self._columns]
        names = [(*NAMES, *SLOPES)[k] for k in self._columns]
        self._is_mean = np.array([name.endswith((" score", " food")) for name in names])
        self._is_slope = np.isin(names, SLOPES)
        used = weights > 0
        own = statistics[used][:, :, self._columns].astype(np.float64)
        off = own - means_of(own)[:, None]
        off = np.where(np.isfinite(off), off, 0.0) * np.sqrt(weights[used])[:, None, None]
        rows = off.reshape(-1, len(self._columns))
        degrees = weights[used] @ np.maximum(np.isfinite(own).sum(axis=1) - 1, 0)
        self.spread = np.sqrt((rows**2).sum(axis=0) / np.maximum(degrees, 1e-12))
        """Usual standard deviation of each statistic between experiments."""
        rows = rows[:, ~self._is_slope]
        scale = np.sqrt(np.maximum((rows**2).sum(axis=0), 1e-12))
        correlation = _OWN_CORRELATION * rows.T @ rows / np.outer(scale, scale)
        np.fill_diagonal(correlation, 1.0)
        self._precision = np.linalg.inv(correlation)

    def misfit(self, statistics: Floats) -> float:
        """Distance of the means, and how much more surprising the thesis is than the set's own experiments.

        Args:
            statistics: Of experiments under the set, shape (experiments, statistics of `summary`).

        Returns:
            0 for a set with the thesis's means and slopes, under which the thesis is no surprise. Infinity if a
            statistic is missing in most experiments, such as the share of correct steps in failed recalls under a set
            that never fails.
        """
        surprise = self.surprise(statistics)
        if not math.isfinite(surprise):
            return math.inf
        off = (means_of(statistics[None, :, self._columns])[0] - self._thesis) / self.spread
        free = len(self._precision)
        return float((off[self._is_mean | self._is_slope] ** 2).sum() + max(surprise - free, 0.0))

    def surprise(self, statistics: Floats) -> float:
        """Squared distance of the thesis from the set's expected statistics, in the spread of the set's experiments.

        Args:
            statistics: Of experiments under the set, shape (experiments, statistics of `summary`).

        Returns:
            About 23 if the thesis were an experiment of this set; infinity as for `misfit`.
        """
        columns = self._columns[~self._is_slope]
        own = statistics[:, columns].astype(np.float64)
        known = np.isfinite(own)
        if (known.mean(axis=0) < 0.5).any():
            return math.inf
        means = means_of(own[None])[0]
        count = known.sum(axis=0)
        squares = (
            np.where(known, (own - means) ** 2, 0.0).sum(axis=0) + _USUAL * self.spread[~self._is_slope] ** 2
        )
        spread = np.sqrt(squares / (count - 1 + _USUAL) * (1 + 1 / count))
        off = (self._thesis[~self._is_slope] - means) / spread
        return float(off @ self._precision @ off)


def means_of(own: Floats) -> Floats:
    """Means over experiments, without missing values.

    Args:
        own: Statistics, shape (sets, experiments, statistics).

    Returns:
        Shape (sets, statistics); not a number if no experiment has the statistic.
    """
    known = np.isfinite(own)
    count = known.sum(axis=1)
    return np.where(count > 0, np.where(known, own, 0.0).sum(axis=1) / np.maximum(count, 1), np.nan)
