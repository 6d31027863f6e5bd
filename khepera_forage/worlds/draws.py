"""Random numbers in blocks: one call of the generator for many rounds, which is what makes noise cheap."""

import numpy as np

_BLOCK = 1024


class Draws:
    """Standard normal numbers from one generator, in the generator's own order.

    Args:
        rng: The subsystem's own generator.
        count: How many numbers a round takes.
    """

    def __init__(self, rng: np.random.Generator, count: int) -> None:
        self._rng = rng
        self._count = count
        self._rows: list[list[float]] = []

    def next(self) -> list[float]:
        """The numbers of the next round."""
        if not self._rows:
            block = self._rng.standard_normal((_BLOCK // self._count, self._count))
            self._rows = block.tolist()[::-1]
        return self._rows.pop()
