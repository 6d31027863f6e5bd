"""Method of simulated moments: how far are the expected statistics under one set from tables A.1 to A.4?

The random forest weights sets, but does not say which single set fits best; this does. Differences are measured in the
spread of experiments of the thesis's size, so that 23 statistics of an experiment of the set itself would be at a
squared distance of about 23 (McFadden 1989, "A method of simulated moments for estimation of discrete response models
without numerical integration", Econometrica 57: 995-1026).
"""

import math

import numpy as np
from numpy.typing import NDArray

from khepera_forage.thesis.inference.posterior import fitted_columns
from khepera_forage.thesis.inference.summary import NAMES, thesis_statistics

Floats = NDArray[np.float64]
_OWN_CORRELATION = 0.8
"""Share of the correlations that are believed; it keeps their matrix well-conditioned."""


class Moments:
    """Squared distance from the corridor's tables.

    Args:
        statistics: Of sets, shape (sets, experiments, statistics of `summary`).
        weights: One a set. Their experiments, weighted, say how much statistics vary from one experiment to another
            under a set, and together.
    """

    def __init__(self, statistics: NDArray[np.float32], weights: Floats) -> None:
        columns = fitted_columns()
        self._columns = columns[columns < len(NAMES)]  # slopes follow from the others
        self._thesis = thesis_statistics()[self._columns]
        used = weights > 0
        own = statistics[used][:, :, self._columns].astype(np.float64)
        off = own - _means(own)[:, None]
        known = np.isfinite(off)
        off = np.where(known, off, 0.0) * np.sqrt(weights[used])[:, None, None]
        counts = np.tensordot(weights[used], known.sum(axis=1), axes=1)
        rows = off.reshape(-1, len(self._columns))
        scale = np.sqrt(np.maximum((rows**2).sum(axis=0), 1e-12))
        correlation = _OWN_CORRELATION * rows.T @ rows / np.outer(scale, scale)
        np.fill_diagonal(correlation, 1.0)
        experiments = own.shape[1]
        degrees = counts * (experiments - 1) / experiments if experiments > 1 else counts
        self.spread = np.sqrt((rows**2).sum(axis=0) / np.maximum(degrees, 1e-12))
        """Standard deviation of each statistic between experiments."""
        self._precision = np.linalg.inv(correlation)

    def distance(self, statistics: Floats) -> float:
        """Squared distance of a set's expected statistics from the thesis's.

        Args:
            statistics: Of experiments under the set, shape (experiments, statistics of `summary`).

        Returns:
            Infinity if a statistic is missing in most experiments, such as the share of correct steps in failed
            recalls under a set that never fails.
        """
        own = statistics[:, self._columns]
        if (np.isfinite(own).mean(axis=0) < 0.5).any():
            return math.inf
        off = (_means(own[None].astype(np.float64))[0] - self._thesis) / self.spread
        return float(off @ self._precision @ off)


def _means(own: Floats) -> Floats:
    """Means over experiments, without missing values; shape (sets, statistics)."""
    known = np.isfinite(own)
    return np.asarray(np.where(known, own, 0.0).sum(axis=1) / np.maximum(known.sum(axis=1), 1))
