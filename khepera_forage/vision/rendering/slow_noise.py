"""Slow, smooth random signals: light that drifts and cables that sway."""

import numpy as np
from numpy.typing import NDArray

_WAVES = 3
_PERIODS = (0.6, 1.7)
"""Shortest and longest period of a wave, as a share of the typical period."""


class SlowNoise:
    """Independent random signals, each the mean of three sine waves with random periods and phases.

    Args:
        rng: Draws all periods and phases at construction.
        count: Number of signals.
        period: Typical period of a wave in s.
    """

    def __init__(self, rng: np.random.Generator, count: int, period: float) -> None:
        periods = period * rng.uniform(*_PERIODS, (count, _WAVES))
        self._rates = 2 * np.pi / periods
        self._phases = rng.uniform(0, 2 * np.pi, (count, _WAVES))

    def at(self, seconds: float) -> NDArray[np.float64]:
        """The signals at a time: mean 0, within -1..1, with a standard deviation of 0.41."""
        waves: NDArray[np.float64] = np.sin(self._rates * seconds + self._phases)
        means: NDArray[np.float64] = waves.mean(axis=1)
        return means
