"""Measures and their values: a line of the table, and how it is repeated."""

import gc
import statistics
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

LOWER_IS_BETTER = ("s", "MB", "bytes", "µs a step", "ns a step")
"""Units of which less is better; of the others (rates, shares) more is."""


class Measure(NamedTuple):
    """What is measured, and against which goal.

    Attributes:
        section: Heading it stands under.
        name: Its line.
        unit: Of its values.
        how: What was done, in a few words, beyond what the section's note says.
        goal: What it should reach, or stay below; None without one.
    """

    section: str
    name: str
    unit: str
    how: str = ""
    goal: float | None = None


Values = dict[Measure, float]
Job = Callable[[], Values]
"""One repeat of some work; gives one value for each measure taken on it."""


@dataclass(frozen=True, slots=True)
class Line:
    """A measure and what came of it.

    Attributes:
        section: Heading it stands under.
        name: What was measured.
        unit: Of all values.
        goal: What it should reach, or stay below; None without one.
        median: Of the repeats.
        lowest: Of the repeats.
        highest: Of the repeats.
        repeats: The value of each repeat, in order.
        how: What was done.
    """

    section: str
    name: str
    unit: str
    goal: float | None
    median: float
    lowest: float
    highest: float
    repeats: tuple[float, ...]
    how: str

    @classmethod
    def of(cls, measure: Measure, values: Sequence[float]) -> "Line":
        """The line of a measure with the value of each repeat."""
        median = statistics.median(values)
        return cls(
            measure.section,
            measure.name,
            measure.unit,
            measure.goal,
            median,
            min(values),
            max(values),
            tuple(values),
            measure.how,
        )

    @property
    def bound(self) -> str:
        """The goal in words; empty without one."""
        if self.goal is None:
            return ""
        return f"at {'most' if self.unit in LOWER_IS_BETTER else 'least'} {self.goal:,g}"

    @property
    def met(self) -> bool | None:
        """Whether the median is as good as the goal; None without one."""
        if self.goal is None:
            return None
        return self.median <= self.goal if self.unit in LOWER_IS_BETTER else self.median >= self.goal


def repeated(jobs: Sequence[Job], repeats: int) -> Iterator[list[Values]]:
    """Take all measures several times, every job once in each repeat.

    So a machine that is slow for a while slows a repeat of every measure, not all repeats of one.

    Args:
        jobs: The work.
        repeats: How many times.

    Yields:
        The values of all jobs, once a repeat.
    """
    gc.collect()
    gc.freeze()  # what a job keeps, such as a million vectors, is not searched at the cost of the others
    for _ in range(repeats):
        values = []
        for job in jobs:
            gc.collect()  # what one job leaves behind is not collected at the cost of the next
            values.append(job())
        yield values


def lines_of(repeats: Sequence[Sequence[Values]]) -> list[Line]:
    """One line a measure, in the order of the jobs."""
    by_measure: dict[Measure, list[float]] = {}
    for values in repeats:
        for measured in values:
            for measure, value in measured.items():
                by_measure.setdefault(measure, []).append(value)
    return [Line.of(measure, values) for measure, values in by_measure.items()]
