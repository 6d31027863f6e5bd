"""Measures, their values in several repeats, and the comparison with their goals."""

import gc
import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

LOWER_IS_BETTER = ("s", "ms", "MB", "bytes", "µs a step", "ns a step")
"""Units of which less is better; of the others (rates, shares), more is better."""


class Measure(NamedTuple):
    """A quantity, and its goal.

    Attributes:
        section: Heading that it stands under.
        name: Its line in the table.
        unit: Of its values.
        how: How it is measured, beyond the note of the section.
        goal: What it should reach, or stay below; None without a goal.
    """

    section: str
    name: str
    unit: str
    how: str = ""
    goal: float | None = None


Values = dict[Measure, float]
Job = Callable[[], Values]
"""One repeat of some work; returns one value for each of its measures."""


@dataclass(frozen=True, slots=True)
class Measured:
    """One value of a measure; see `Measure` for the other fields.

    Attributes:
        repeat: From 0.
        value: In the unit.
    """

    section: str
    name: str
    unit: str
    how: str
    goal: float | None
    repeat: int
    value: float


class Repeat(NamedTuple):
    """All jobs once. A machine that is slow for a while then slows one repeat of every measure, not all of one measure.

    Attributes:
        group: Name of the jobs.
        number: From 0; -1 warms up and leaves no rows.
        jobs: The work.
    """

    group: str
    number: int
    jobs: Sequence[Job]

    @property
    def key(self) -> str:
        """Group and number."""
        return f"{self.group} {self.number}"

    def run(self) -> list[Measured]:
        """Take all measures."""
        if self.number < 0:
            gc.collect()
            gc.freeze()  # what a job keeps, such as a million vectors, is not searched at the cost of the others
        values: Values = {}
        for job in self.jobs:
            gc.collect()  # what one job leaves behind is not collected at the cost of the next
            values |= job()
        if self.number < 0:
            return []
        return [Measured(*measure, self.number, value) for measure, value in values.items()]


def repeats(group: str, jobs: Sequence[Job], count: int) -> list[Repeat]:
    """A repeat that warms up, and some that count."""
    return [Repeat(group, number, jobs) for number in range(-1, count)]


@dataclass(frozen=True, slots=True)
class Line:
    """A measure with its value in each repeat."""

    measure: Measure
    values: tuple[float, ...]

    @property
    def median(self) -> float:
        """Of the repeats."""
        return statistics.median(self.values)

    @property
    def bound(self) -> str:
        """The goal in words; empty without a goal."""
        if self.measure.goal is None:
            return ""
        return f"at {'most' if self.measure.unit in LOWER_IS_BETTER else 'least'} {self.measure.goal:,.12g}"

    @property
    def factor(self) -> float | None:
        """How many times as good as the goal the median is; None without a goal."""
        goal = self.measure.goal
        if goal is None:
            return None
        return goal / self.median if self.measure.unit in LOWER_IS_BETTER else self.median / goal


def digits(value: float) -> int:
    """Digits after the point in a table: three digits of small values, none after the point of large ones."""
    return 0 if value >= 1000 else 1 if value >= 10 else 2


def lines_of(rows: Sequence[Measured]) -> list[Line]:
    """One line a measure, in the order of the rows."""
    values: dict[Measure, list[float]] = {}
    for row in rows:
        measure = Measure(row.section, row.name, row.unit, row.how, row.goal)
        values.setdefault(measure, []).append(row.value)
    return [Line(measure, tuple(own)) for measure, own in values.items()]
