"""Who votes: the experience vectors at the minimum distance from a state vector (section 4.6.1).

`PixelVotes` holds state vectors of whole numbers and counts distances in whole units of 1 / (55 * diagonal), so that
ties are exact. `PlainVotes` holds any other numbers. Both merge equal vectors into one row with a count for every
class. An index for millions of vectors (a k-d tree over the two distances of each group) can take the place of
`PixelVotes`: what the imitator needs of it is `VoteIndex`.
"""

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from khepera_forage.foraging.states import StateVector

ARM_SPAN = 55
"""Xmax of equation 4.2: the thesis' maximum difference of ArmsHeight, larger than the 40 really used."""

MAX_PLANS = 4096
"""More than the kinds of query that foraging has (2 presences, 4 types, 41 heights)."""


def distance(a: StateVector, b: StateVector, diagonal: int) -> Fraction:
    """How unlike two state vectors are: the sum of the five attribute distances of section 4.6.1, exactly.

    Args:
        a: A state vector; distances in pixels.
        b: Another one.
        diagonal: Of the arena foraged in now, in pixels; above 0.
    """
    differ = (a.object_presence != b.object_presence) + (a.food_type != b.food_type)
    pixels = abs(a.robot_home_distance - b.robot_home_distance) + abs(a.robot_food_distance - b.robot_food_distance)
    return differ + Fraction(abs(a.arms_height - b.arms_height), ARM_SPAN) + Fraction(pixels, diagonal)


class Votes(NamedTuple):
    """What the nearest vectors say.

    Attributes:
        distance: The minimum distance.
        counts: How many of the vectors that vote belong to each class.
    """

    distance: float
    counts: list[int]


class VoteIndex(Protocol):
    """A store of vectors with their classes that finds the ones nearest to a query."""

    def add(self, row: Sequence[Any], code: int) -> None:
        """Take in one vector of class `code`."""
        ...

    def recode(self, columns: Sequence[int], classes: int) -> None:
        """There are `classes` classes from now on; the one coded `i` so far becomes `columns[i]`."""
        ...

    def rows(self) -> tuple[NDArray[Any], NDArray[np.int64]]:
        """The distinct vectors, one a row, and their counts for each class."""
        ...

    def nearest(self, query: Sequence[Any], diagonal: int, threshold: Fraction) -> Votes:
        """The votes of all vectors within the minimum distance plus `threshold`. At least one vector is held."""
        ...


class Tally:
    """Distinct rows of numbers and how often each was seen with each class; grows at a constant cost a row.

    Attributes:
        values: One array row for each column of the rows, so that a column is contiguous.
        counts: One array row for each distinct row, one column for each class.
    """

    def __init__(self, width: int, classes: int, dtype: type) -> None:
        self._places: dict[tuple[Any, ...], int] = {}
        self._values = np.zeros((width, 4), dtype)
        self._counts = np.zeros((4, classes), np.int64)
        self._trim()

    def add(self, row: tuple[Any, ...], code: int) -> None:
        """Count `row` once more for class `code`."""
        place = self._places.setdefault(row, len(self._places))
        if place == len(self.counts):
            if place == len(self._counts):
                self._values = np.concatenate([self._values, np.zeros_like(self._values)], axis=1)
                self._counts = np.concatenate([self._counts, np.zeros_like(self._counts)])
            self._values[:, place] = row
            self._trim()
        self._counts[place, code] += 1

    def recode(self, columns: Sequence[int], classes: int) -> None:
        """See `VoteIndex.recode`."""
        counts = np.zeros((len(self._counts), classes), np.int64)
        counts[:, columns] = self._counts
        self._counts = counts
        self._trim()

    def votes(self, chosen: NDArray[np.intp]) -> NDArray[np.int64]:
        """The counts of the chosen rows together."""
        total: NDArray[np.int64] = np.add.reduce(self.counts.take(chosen, axis=0), axis=0)
        return total

    def _trim(self) -> None:
        self.values = self._values[:, : len(self._places)]
        self.counts = self._counts[: len(self._places)]

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._trim()  # a pickled view comes back as a copy


class PixelVotes:
    """Votes among state vectors of whole numbers, of magnitude below 2**40.

    Vectors are grouped by presence, food type and arm. Within a group only the two distances in pixels are left to
    compare, and a group whose other attributes alone are further away than the best vector so far is never looked
    at: of the groups, a query mostly needs one.
    """

    def __init__(self, classes: int) -> None:
        self._classes = classes
        self._groups: dict[tuple[int, int, int], Tally] = {}
        self._plans: dict[tuple[int, int, int, int], list[tuple[int, Tally]]] = {}

    def add(self, row: Sequence[int], code: int) -> None:
        """See `VoteIndex.add`."""
        presence, home, food_type, arm, food = row
        group = self._groups.get((presence, food_type, arm))
        if group is None:
            group = self._groups[presence, food_type, arm] = Tally(2, self._classes, np.int64)
            self._plans = {}
        group.add((home, food), code)

    def recode(self, columns: Sequence[int], classes: int) -> None:
        """See `VoteIndex.recode`."""
        self._classes = classes
        for group in self._groups.values():
            group.recode(columns, classes)

    def rows(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """See `VoteIndex.rows`."""
        vectors = [
            (presence, home, food_type, arm, food)
            for (presence, food_type, arm), group in self._groups.items()
            for home, food in group.values.T.tolist()
        ]
        counts = np.concatenate([group.counts for group in self._groups.values()])
        return np.array(vectors, np.int64), counts

    def nearest(self, query: Sequence[int], diagonal: int, threshold: Fraction) -> Votes:
        """See `VoteIndex.nearest`."""
        presence, home, food_type, arm, food = query
        unit = ARM_SPAN * diagonal
        slack = int(threshold * unit) if threshold else 0  # rounding down is exact: distances are whole numbers
        plan = self._plans.get((diagonal, presence, food_type, arm)) or self._plan(diagonal, presence, food_type, arm)
        best = -1
        seen = []
        for base, group in plan:
            if best >= 0 and base > best + slack:
                break
            # Fresh arrays, not buffers kept for all queries: several threads may ask at once.
            pixels = np.subtract(group.values[0], home)
            np.absolute(pixels, pixels)
            other = np.subtract(group.values[1], food)
            pixels += np.absolute(other, other)
            least = base + ARM_SPAN * int(pixels[pixels.argmin()])
            if best < 0 or least < best:
                best = least
            seen.append((base, least, pixels, group))
        limit = best + slack
        parts = [
            group.votes((pixels <= (limit - base) // ARM_SPAN).nonzero()[0])
            for base, least, pixels, group in seen
            if least <= limit
        ]
        total = parts[0] if len(parts) == 1 else sum(parts[1:], parts[0])
        return Votes(best / unit, total.tolist())

    def _plan(self, diagonal: int, presence: int, food_type: int, arm: int) -> list[tuple[int, Tally]]:
        """All groups, nearest first, each with the distance that presence, food type and arm make up."""
        unit = ARM_SPAN * diagonal
        plan = [
            (unit * ((p != presence) + (t != food_type)) + diagonal * abs(a - arm), group)
            for (p, t, a), group in self._groups.items()
        ]
        plan.sort(key=lambda step: step[0])
        if len(self._plans) >= MAX_PLANS:
            self._plans = {}
        self._plans[diagonal, presence, food_type, arm] = plan
        return plan

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_plans": {}}


class PlainVotes:
    """Votes among vectors of any numbers, in float arithmetic: slower, and ties are as exact as floats are.

    Five columns are a state vector; with any other number of columns each is a distance in pixels.
    """

    def __init__(self, width: int, classes: int) -> None:
        self._tally = Tally(width, classes, np.float64)

    def add(self, row: Sequence[float], code: int) -> None:
        """See `VoteIndex.add`."""
        self._tally.add(tuple(row), code)

    def recode(self, columns: Sequence[int], classes: int) -> None:
        """See `VoteIndex.recode`."""
        self._tally.recode(columns, classes)

    def rows(self) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
        """See `VoteIndex.rows`."""
        return self._tally.values.T, self._tally.counts

    def nearest(self, query: Sequence[float], diagonal: int, threshold: Fraction) -> Votes:
        """See `VoteIndex.nearest`."""
        apart = np.abs(self._tally.values - np.array(query, np.float64)[:, None])
        if len(apart) == 5:
            presence, home, food_type, arm, food = apart
            away = (presence != 0) + 1.0 * (food_type != 0) + arm / ARM_SPAN + (home + food) / diagonal
        else:
            away = apart.sum(axis=0) / diagonal
        best = float(away.min())
        chosen = (away <= best + float(threshold)).nonzero()[0]
        return Votes(best, self._tally.votes(chosen).tolist())
