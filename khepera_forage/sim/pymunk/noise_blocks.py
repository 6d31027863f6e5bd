"""Random numbers in blocks: one call of the generator for many rounds, which is what makes noise cheap."""

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

_BLOCK = 512


class Draws:
    """Rows of random numbers from one generator, in the generator's own order.

    Args:
        source: A method of the subsystem's own generator, such as `rng.random`.
        count: How many numbers a row has: what one robot takes in a round.
    """

    def __init__(self, source: Callable[[tuple[int, int]], NDArray[np.float64]], count: int) -> None:
        self._source = source
        self._count = count
        self._shape = (max(1, _BLOCK // count), count)
        self._rows: Iterator[tuple[float, ...]] = iter(())

    def next(self) -> tuple[float, ...]:
        """The next row."""
        row = next(self._rows, None)
        if row is None:
            # Rows are cut from one flat list when they are needed: a list a row would only give the garbage
            # collector work.
            numbers = iter(self._source(self._shape).ravel().tolist())
            self._rows = zip(*[numbers] * self._count, strict=True)
            row = next(self._rows)
        return row
