"""Who votes: the experience vectors at the minimum distance from a state vector (section 4.6.1).

`PixelVotes` holds state vectors of whole numbers and counts distances in whole units of 1 / (55 * diagonal),
so that ties are exact. `PlainVotes` holds any other numbers. Both merge equal vectors into one row with a
count for every class.
"""

import operator
from collections.abc import Sequence
from fractions import Fraction
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from khepera_forage.policies.plane import Counts, Plane
from khepera_forage.policies.tally import Tally
from khepera_forage.task.states import StateVector

ARM_SPAN = 55
"""Xmax of equation 4.2: the thesis' maximum difference of ArmsHeight, larger than the 40 really used."""

MAX_PLANS = 4096
"""More than the kinds of query that foraging has (2 presences, 4 types, 41 heights)."""
PIXEL_LIMIT = 2**40
"""Magnitude below which whole numbers are compared as integers: floats hold them exactly."""
BEYOND = 2**44
"""A distance longer than any of two vectors below `PIXEL_LIMIT`, whatever the diagonal."""


def are_pixels(row: Sequence[float]) -> bool:
    """Whether a row can go into `PixelVotes`: five whole numbers, none too large."""
    return len(row) == 5 and all(-PIXEL_LIMIT < value < PIXEL_LIMIT and value % 1 == 0 for value in row)


def all_pixels(rows: NDArray[Any]) -> bool:
    """Whether every row is such a one."""
    return bool(rows.shape[1] == 5 and ((rows > -PIXEL_LIMIT) & (rows < PIXEL_LIMIT) & (rows % 1 == 0)).all())


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

    def add(self, row: Sequence[Any], code: int, times: int = 1) -> None:
        """Take in a vector of class `code`, once or several times."""
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
    left to compare, in a `Plane`, and a group whose other attributes alone are further away than the best vector so
    far is never looked at: of the groups, a query mostly needs one. One more vector never rebuilds anything: a new
    class neither, as planes keep classes by the order in which they came.
    """

    def __init__(self, classes: int) -> None:
        self._columns = list(range(classes))  # of the classes, in the order in which they came
        self._orders = list(range(classes))  # the other way round
        self._groups: dict[tuple[int, int, int], Plane] = {}
        self._plans: dict[tuple[int, int, int, int], list[tuple[int, Plane]]] = {}
        self._plain: PlainVotes | None = None

    def add(self, row: Sequence[int], code: int, times: int = 1) -> None:
        """See `VoteIndex.add`."""
        presence, home, food_type, arm, food = row
        group = self._groups.get((presence, food_type, arm))
        if group is None:
            group = self._groups[presence, food_type, arm] = Plane()
            self._plans = {}
        group.add(home, food, self._orders[code], times)
        self._plain = None

    def recode(self, columns: Sequence[int], classes: int) -> None:
        """See `VoteIndex.recode`."""
        known = [columns[column] for column in self._columns]
        self._columns = known + sorted(set(range(classes)) - set(known))
        self._orders = [self._columns.index(column) for column in range(classes)]
        self._plain = None

    def plain(self) -> "PlainVotes":
        """The same vectors, to be compared as floats."""
        plain = PlainVotes(5, len(self._columns))
        for (presence, food_type, arm), group in self._groups.items():
            for home, food, counts in group.items():
                for order, times in counts.items():
                    plain.add((presence, home, food_type, arm, food), self._columns[order], times)
        return plain

    def nearest(self, query: Sequence[float], diagonal: int, threshold: Fraction) -> Votes:
        """See `VoteIndex.nearest`. A query that is not whole is compared in floats."""
        if not are_pixels(query):
            if self._plain is None:
                self._plain = self.plain()
            return self._plain.nearest(query, diagonal, threshold)
        presence, home, food_type, arm, food = map(int, query)
        unit = ARM_SPAN * diagonal
        kind = (diagonal, presence, food_type, arm)
        plan = self._plans.get(kind) or self._plan(*kind)
        best = BEYOND * unit
        chosen: list[Counts] = []
        for base, group in plan:
            if base > best:
                break
            away, found = group.nearest(home, food, (best - base) // ARM_SPAN)
            if found:
                total = base + ARM_SPAN * away
                chosen = found if total < best else chosen + found
                best = total
        assert chosen, "no vectors"
        if threshold:
            reach = best + int(threshold * unit)  # rounded down: no distance lies in between
            chosen = []
            for base, group in plan:
                if base <= reach:
                    chosen += group.within(home, food, (reach - base) // ARM_SPAN)
        counts = [0] * len(self._columns)
        for seen in chosen:
            for order, times in seen.items():
                counts[self._columns[order]] += times
        return Votes(best / unit, counts)

    def _plan(self, diagonal: int, presence: int, food_type: int, arm: int) -> list[tuple[int, Plane]]:
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
