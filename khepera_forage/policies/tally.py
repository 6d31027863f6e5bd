"""Distinct rows and how often each was seen with each class: what indexes of experience are made of."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray


class Tally:
    """Distinct rows of numbers and how often each was seen with each class; grows at a constant cost a row.

    Attributes:
        columns: The columns of the rows, each contiguous.
        counts: One array row for each distinct row, one column for each class.
    """

    def __init__(self, width: int, classes: int, dtype: type) -> None:
        self._places: dict[tuple[Any, ...], int] = {}
        self._values: NDArray[Any] = np.zeros((width, 4), dtype)
        self._counts = np.zeros((4, classes), np.int64)
        self._trim()

    def add(self, row: tuple[Any, ...], code: int, times: int = 1) -> None:
        """Count `row` for class `code`, once or several times."""
        place = self._places.setdefault(row, len(self._places))
        if place == len(self.counts):
            if place == len(self._counts):
                self._values = np.concatenate([self._values, np.zeros_like(self._values)], axis=1)
                self._counts = np.concatenate([self._counts, np.zeros_like(self._counts)])
            self._values[:, place] = row
            self._trim()
        self._counts[place, code] += times

    def recode(self, columns: Sequence[int], classes: int) -> None:
        """There are `classes` classes from now on; the one coded `i` so far becomes `columns[i]`."""
        counts = np.zeros((len(self._counts), classes), np.int64)
        counts[:, columns] = self._counts
        self._counts = counts
        self._trim()

    def votes(self, chosen: NDArray[np.intp]) -> list[int]:
        """The counts of the chosen rows together, for each class."""
        # Mostly it is one row, and summing one row would take a tenth of a decision.
        counts = self.counts[chosen[0]] if len(chosen) == 1 else self.counts.take(chosen, axis=0).sum(axis=0)
        votes: list[int] = counts.tolist()
        return votes

    def _trim(self) -> None:
        self.columns = tuple(self._values[:, : len(self._places)])
        self.counts = self._counts[: len(self._places)]

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._trim()  # a pickled view comes back as a copy
