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
        self._count = count
        self._shape = (max(1, _BLOCK // count), count)
        self._numbers: list[float] = []
        self._next = 0

    def next(self) -> list[float]:
        """The numbers of the next round."""
        begin = self._next
        if begin == len(self._numbers):
            # One flat list: a list a row would only give the garbage collector work.
            self._numbers, begin = self._source(self._shape).ravel().tolist(), 0
        end = self._next = begin + self._count
        return self._numbers[begin:end]
