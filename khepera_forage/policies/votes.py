"""Who votes: the experience vectors at the minimum distance from a state vector (section 4.6.1).

`PixelVotes` holds state vectors of whole numbers and counts distances in whole units of 1 / (55 * diagonal),
so that ties are exact. `PlainVotes` holds any other numbers. Both merge equal vectors into one row with a
count for every class. An index for millions of vectors (a k-d tree over the two distances of each group) can
take the place of `PixelVotes`: what the imitator needs of it is `VoteIndex` and `plain`.
"""

import operator
from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NamedTuple, Protocol

import numpy as np

from khepera_forage.foraging.states import StateVector
from khepera_forage.policies.tally import Tally

ARM_SPAN = 55
"""Xmax of equation 4.2: the thesis' maximum difference of ArmsHeight, larger than the 40 really used."""

MAX_PLANS = 4096
"""More than the kinds of query that foraging has (2 presences, 4 types, 41 heights)."""
PIXEL_LIMIT = 2**40
"""Magnitude below which whole numbers are compared as integers; their sums stay far from overflow."""


def are_pixels(row: Sequence[float]) -> bool:
    """Whether a row can go into `PixelVotes`: five whole numbers, none too large."""
    return len(row) == 5 and all(-PIXEL_LIMIT < value < PIXEL_LIMIT and value % 1 == 0 for value in row)


def distance(a: StateVector, b: StateVector, diagonal: int) -> Fraction:
    """How unlike two state vectors are: the sum of the five attribute distances of section 4.6.1, exactly.

    Args:
        a: A state vector; distances in pixels.
        b: Another one.
        diagonal: Of the arena foraged in now, in pixels; above 0.
    """
    differ = (a.object_presence != b.object_presence) + (a.food_type != b.food_type)
    arm = abs(a.arms_height - b.arms_height)
    home = abs(a.robot_home_distance - b.robot_home_distance)
    food = abs(a.robot_food_distance - b.robot_food_distance)
    return differ + Fraction(arm, ARM_SPAN) + Fraction(home + food, diagonal)


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

    def nearest(self, query: Sequence[Any], diagonal: int, threshold: Fraction) -> Votes:
        """The votes of all vectors within the minimum distance plus `threshold`; there must be a vector."""
        ...


class PixelVotes:
    """Votes among state vectors of whole numbers, as `are_pixels` has them.

    Vectors are grouped by presence, food type and arm. Within a group only the two distances in pixels are
    left to compare, and a group whose other attributes alone are further away than the best vector so far is
    never looked at: of the groups, a query mostly needs one.
    """

    def __init__(self, classes: int) -> None:
        self._classes = classes
        self._groups: dict[tuple[int, int, int], Tally] = {}
        self._plans: dict[tuple[int, int, int, int], list[tuple[int, Tally]]] = {}
        self._plain: PlainVotes | None = None

    def add(self, row: Sequence[int], code: int) -> None:
        """See `VoteIndex.add`."""
        presence, home, food_type, arm, food = row
        group = self._groups.get((presence, food_type, arm))
        if group is None:
            group = self._groups[presence, food_type, arm] = Tally(2, self._classes, np.int64)
            self._plans = {}
        group.add((home, food), code)
        self._plain = None

    def recode(self, columns: Sequence[int], classes: int) -> None:
        """See `VoteIndex.recode`."""
        self._classes = classes
        for group in self._groups.values():
            group.recode(columns, classes)
        self._plain = None

    def plain(self) -> "PlainVotes":
        """The same vectors, to be compared as floats."""
        plain = PlainVotes(5, self._classes)
        for (presence, food_type, arm), group in self._groups.items():
            homes, foods = group.columns
            for home, food, counts in zip(homes.tolist(), foods.tolist(), group.counts.tolist(), strict=True):
                for code, times in enumerate(counts):
                    if times:
                        plain.add((presence, home, food_type, arm, food), code, times)
        return plain

    def nearest(self, query: Sequence[float], diagonal: int, threshold: Fraction) -> Votes:
        """See `VoteIndex.nearest`. A query that is not whole is compared in floats."""
        if not are_pixels(query):
            if self._plain is None:
                self._plain = self.plain()
            return self._plain.nearest(query, diagonal, threshold)
        presence, home, food_type, arm, food = map(int, query)
        unit = ARM_SPAN * diagonal
        slack = int(threshold * unit) if threshold else 0  # rounded down: no distance lies in between
        kind = (diagonal, presence, food_type, arm)
        best = None
        seen = []
        for base, group in self._plans.get(kind) or self._plan(*kind):
            if best is not None and base > best + slack:
                break
            # Fresh arrays, not buffers kept for all queries: several threads may ask at once.
            homes, foods = group.columns
            pixels = np.subtract(homes, home)
            np.absolute(pixels, pixels)
            other = np.subtract(foods, food)
            pixels += np.absolute(other, other)
            least = base + ARM_SPAN * int(pixels[pixels.argmin()])
            if best is None or least < best:
                best = least
            seen.append((base, least, pixels, group))
        assert best is not None, "no vectors"
        counts = [0] * self._classes
        for base, least, pixels, group in seen:
            if least <= best + slack:
                chosen = (pixels <= (best + slack - base) // ARM_SPAN).nonzero()[0]
                counts = list(map(operator.add, counts, group.votes(chosen)))
        return Votes(best / unit, counts)

    def _plan(self, diagonal: int, presence: int, food_type: int, arm: int) -> list[tuple[int, Tally]]:
        """All groups, nearest first, each with the distance that presence, food type and arm make up."""
        unit = ARM_SPAN * diagonal
        plan = [
            (unit * ((p != presence) + (t != food_type)) + diagonal * abs(a - arm), group)
            for (p, t, a), group in self._groups.items()
        ]
        plan.sort(key=operator.itemgetter(0))
        if len(self._plans) >= MAX_PLANS:
            self._plans = {}
        self._plans[diagonal, presence, food_type, arm] = plan
        return plan

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "_plans": {}, "_plain": None}


class PlainVotes:
    """Votes among vectors of any numbers, in float arithmetic: slower, and ties are as exact as floats are.

    Five columns are a state vector; with any other number of columns each is a distance in pixels.
    """

    def __init__(self, width: int, classes: int) -> None:
        self._tally = Tally(width, classes, np.float64)

    def add(self, row: Sequence[float], code: int, times: int = 1) -> None:
        """See `VoteIndex.add`; the vector is taken in several times."""
        self._tally.add(tuple(row), code, times)

    def recode(self, columns: Sequence[int], classes: int) -> None:
        """See `VoteIndex.recode`."""
        self._tally.recode(columns, classes)

    def nearest(self, query: Sequence[float], diagonal: int, threshold: Fraction) -> Votes:
        """See `VoteIndex.nearest`."""
        apart = [np.abs(column - value) for column, value in zip(self._tally.columns, query, strict=True)]
        if len(apart) == 5:
            presence, home, food_type, arm, food = apart
            away = (presence != 0) + 1.0 * (food_type != 0) + arm / ARM_SPAN + (home + food) / diagonal
        else:
            away = np.sum(apart, axis=0) / diagonal
        best = float(away.min())
        chosen = (away <= best + float(threshold)).nonzero()[0]
        return Votes(best, self._tally.votes(chosen))
