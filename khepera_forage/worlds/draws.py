"""Random numbers in blocks: one call of the generator for many rounds, which is what makes noise cheap."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

_BLOCK = 512


class Draws:
    """Rows of random numbers from one generator, in the generator's own order.

    Args:
        source: A method of the subsystem's own generator, such as `rng.random`.
        count: How many numbers a round takes.
    """

    def __init__(self, source: Callable[[tuple[int, int]], NDArray[np.float64]], count: int) -> None:
        self._source = source
        self._shape = (max(1, _BLOCK // count), count)
        self._rows: list[list[float]] = []

    def next(self) -> list[float]:
        """The numbers of the next round."""
        if not self._rows:
            self._rows = self._source(self._shape).tolist()[::-1]
        return self._rows.pop()
