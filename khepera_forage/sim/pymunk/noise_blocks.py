"""Random numbers of the robots in blocks: one call of a generator for many rounds, which is what makes noise cheap."""

from collections.abc import Iterator

import numpy as np

_BLOCK = 64
"""Rounds of one robot for which numbers are drawn at a time."""


class Draws:
    """The random numbers of one robot after another, round after round.

    Args:
        wheels: Draws two standard normal numbers for the wheels of a robot in a round.
        sensors: Draws eight uniform ones for its sensors.
    """

    def __init__(self, wheels: np.random.Generator, sensors: np.random.Generator) -> None:
        self._wheels, self._sensors = wheels, sensors
        self._rows: Iterator[tuple[tuple[float, ...], tuple[float, ...]]] = iter(())

    def next(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """The numbers of the wheels and of the sensors of one robot in one round."""
        row = next(self._rows, None)
        if row is None:
            # Rows are cut from flat lists when they are needed: a list a row would only give the garbage collector
            # work.
            wheels = iter(self._wheels.standard_normal(2 * _BLOCK).tolist())
            sensors = iter(self._sensors.random(8 * _BLOCK).tolist())
            self._rows = zip(zip(*[wheels] * 2, strict=True), zip(*[sensors] * 8, strict=True), strict=True)
            row = next(self._rows)
        return row
