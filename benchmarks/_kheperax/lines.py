"""What is timed, in which order, and what came of it."""

import statistics
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from _kheperax.ours import Bodies, whole_task
from _kheperax.theirs import Kheperax, Timed
from khepera_forage.thesis.statistics import Estimate


class Pair(NamedTuple):
    """Two lines that do the nearest equal work.

    Attributes:
        name: Of the pair.
        theirs: Kheperax' line.
        ours: Our line.
        noisy: Whether each side's noise is on.
        calls: Whether Python gets the readings after every step.
    """

    name: str
    theirs: str
    ours: str
    noisy: bool
    calls: bool


NOISE = Pair("noise", "Kheperax, its noise on", "BatchWorld, the laboratory's noise", True, False)
CLEAN = Pair("no noise", "Kheperax, no noise", "BatchWorld, no noise", False, False)
CALLS = Pair(
    "from Python",
    "Kheperax, its noise on, a call a step, readings as an array",
    "BatchWorld, the laboratory's noise, `advance` and `senses` a step",
    True,
    True,
)
PAIRS = (NOISE, CLEAN, CALLS)
AS_IT_COMES = "Kheperax as it comes: its standard maze, three lasers, no noise"
TASKS = {
    "corridor": "`run_teacher`, corridor, one food object",
    "rectangle": "`run_teacher`, rectangle, four food objects",
}
"""The whole task, by arena."""


@dataclass(frozen=True, slots=True)
class Row:
    """One line in one repeat.

    Attributes:
        line: Its name.
        worlds: How many were asked for.
        repeat: Its number, from 0.
        steps: Of all robots together.
        seconds: That they took.
        first_call: Seconds of the first call with these worlds, compiling included.
    """

    line: str
    worlds: int
    repeat: int
    steps: int
    seconds: float
    first_call: float

    @classmethod
    def of(cls, line: str, worlds: int, repeat: int, timed: Timed) -> "Row":
        """The row of what was timed."""
        return cls(line, worlds, repeat, timed.steps, timed.seconds, timed.first_call)

    @property
    def rate(self) -> float:
        """Robot-steps a second."""
        return self.steps / self.seconds


class Plan(NamedTuple):
    """How much is done.

    Attributes:
        worlds: Numbers of worlds that the pairs are timed with.
        reference: Number of worlds of the lines that have no counterpart.
        at_least: Seconds of each line in each repeat.
        seed: Of our worlds.
    """

    worlds: tuple[int, ...]
    reference: int
    at_least: float
    seed: int

    def repeat(self, number: int, kheperax: Kheperax, bodies: Bodies) -> Iterator[Row]:
        """Time every line once, the two of a pair one right after the other.

        So a machine that is slow for a while slows both sides of a ratio.
        """
        for worlds in self.worlds:
            for pair in PAIRS:
                setting = "noise" if pair.noisy else "none"
                theirs = kheperax.timed(setting, worlds, self.at_least, pair.calls)
                yield Row.of(pair.theirs, worlds, number, theirs)
                ours = bodies.timed(pair.noisy, worlds, self.at_least, pair.calls)
                yield Row.of(pair.ours, worlds, number, ours)
        own = kheperax.timed("default", self.reference, self.at_least, False)
        yield Row.of(AS_IT_COMES, self.reference, number, own)
        for arena, line in TASKS.items():
            task = whole_task(arena, self.reference, self.seed, self.at_least)
            yield Row.of(line, self.reference, number, task)


def of_line(rows: Sequence[Row], line: str, worlds: int) -> list[Row]:
    """The rows of a line with so many worlds, in the order of the repeats."""
    return sorted((r for r in rows if (r.line, r.worlds) == (line, worlds)), key=lambda r: r.repeat)


def worlds_of(rows: Sequence[Row], line: str) -> list[int]:
    """The numbers of worlds that a line was timed with."""
    return sorted({row.worlds for row in rows if row.line == line})


def best(rows: Sequence[Row], line: str) -> int:
    """The number of worlds with which a line is fastest in the median."""
    return max(worlds_of(rows, line), key=lambda worlds: rate(rows, line, worlds).value)


def rate(rows: Sequence[Row], line: str, worlds: int) -> Estimate:
    """Robot-steps a second: median, lowest and highest of the repeats."""
    return _spread([row.rate for row in of_line(rows, line, worlds)])


def ratio(rows: Sequence[Row], ours: tuple[str, int], theirs: tuple[str, int]) -> Estimate:
    """How many times as fast our line is, by repeat: median, lowest and highest.

    Args:
        rows: Of all repeats.
        ours: Line and number of worlds.
        theirs: Line and number of worlds.
    """
    both = zip(of_line(rows, *ours), of_line(rows, *theirs), strict=True)
    return _spread([a.rate / b.rate for a, b in both])


def _spread(values: Sequence[float]) -> Estimate:
    return Estimate(statistics.median(values), min(values), max(values))
