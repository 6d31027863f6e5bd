"""Synthetic likelihood: how probable are tables A.1 to A.4 under one set, judged by its own experiments?

Summary statistics of experiments of the thesis's size are taken as normally distributed (Wood 2010, "Statistical
inference for noisy nonlinear ecological dynamic systems", Nature 466: 1102-1104). Random forests weight all sets, but
do not say which single set fits best; this does.
"""

import math

import numpy as np
from numpy.typing import NDArray

from khepera_forage.thesis.inference.posterior import fitted_columns
from khepera_forage.thesis.inference.summary import NAMES, thesis_statistics

Floats = NDArray[np.float64]
_PRIOR_EXPERIMENTS = 5
"""Weight of the spread under all sets beside that of a set's own experiments, which are few."""
_OWN_CORRELATION = 0.8
"""Share of the correlations that are believed; it keeps their matrix well-conditioned."""


class Likelihood:
    """Of the corridor's tables.

    Args:
        statistics: Of admissible sets, shape (sets, experiments, statistics of `summary`): how much statistics vary
            between experiments, and together.
    """

    def __init__(self, statistics: NDArray[np.float32]) -> None:
        columns = fitted_columns()
        self._columns = columns[columns < len(NAMES)]  # slopes follow from the others
        self._thesis = thesis_statistics()[self._columns]
        own = statistics[:, :, self._columns].astype(np.float64)
        mean, deviation = _moments(own)
        self._usual = np.nanmedian(deviation, axis=0)
        off = (own - mean[:, None]) / np.where(deviation > 0, deviation, np.nan)[:, None]
        off = np.where(np.isfinite(off), off, 0.0).reshape(-1, len(self._columns))
        together = off.T @ off
        scale = np.sqrt(np.maximum(np.diag(together), 1e-12))
        correlation = _OWN_CORRELATION * together / np.outer(scale, scale)
        np.fill_diagonal(correlation, 1.0)
        self._precision = np.linalg.inv(correlation)

    def log(self, statistics: Floats) -> float:
        """Logarithm of the likelihood, but for a constant.

        Args:
            statistics: Of experiments under one set, shape (experiments, statistics of `summary`).

        Returns:
            Minus infinity if a statistic is missing in most experiments, such as the share of correct steps in failed
            recalls under a set that never fails.
        """
        own = statistics[:, self._columns]
        if (np.isfinite(own).mean(axis=0) < 0.5).any():
            return -math.inf
        mean, deviation = _moments(own[None])
        count = len(own)
        variance = ((count - 1) * deviation[0] ** 2 + _PRIOR_EXPERIMENTS * self._usual**2) / (
            count - 1 + _PRIOR_EXPERIMENTS
        )
        spread = np.sqrt(variance * (1 + 1 / count))
        off = (self._thesis - mean[0]) / spread
        return float(-0.5 * off @ self._precision @ off - np.log(spread).sum())


def _moments(own: Floats) -> tuple[Floats, Floats]:
    """Mean and standard deviation over experiments, without missing values; shape (sets, statistics) each."""
    known = np.isfinite(own)
    count = np.maximum(known.sum(axis=1), 1)
    mean = np.where(known, own, 0.0).sum(axis=1) / count
    squares = np.where(known, (own - mean[:, None]) ** 2, 0.0).sum(axis=1)
    return mean, np.sqrt(squares / np.maximum(count - 1, 1))
