"""Numbers that wander slowly and smoothly: light that comes and goes, cables that sway."""

import numpy as np
from numpy.typing import NDArray

_WAVES = 3
_PERIODS = (0.6, 1.7)
"""Shortest and longest period of a wave, as a share of the period asked for."""


class Slow:
    """So many independent numbers, each a sum of three waves of random periods and phases.

    Args:
        rng: Draws periods and phases, now.
        count: How many numbers.
        period: Of a typical wave in s.
    """

    def __init__(self, rng: np.random.Generator, count: int, period: float) -> None:
        periods = period * rng.uniform(*_PERIODS, (count, _WAVES))
        self._rates = 2 * np.pi / periods
        self._phases = rng.uniform(0, 2 * np.pi, (count, _WAVES))

    def at(self, seconds: float) -> NDArray[np.float64]:
        """The numbers at a time: about 0, within -1..1, with a standard deviation of 0.41."""
        waves: NDArray[np.float64] = np.sin(self._rates * seconds + self._phases)
        means: NDArray[np.float64] = waves.mean(axis=1)
        return means
