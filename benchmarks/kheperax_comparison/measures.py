"""What is timed, in which order, and the rates and ratios of the rows."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from khepera_forage.estimates import Estimate, extremes, pick
from kheperax_comparison.ours import OurBodies, whole_task
from kheperax_comparison.theirs import Kheperax, Timed

WARM_UP_SECONDS = 1e-6


class Pair(NamedTuple):
    """Two lines that do the most similar work.

    Attributes:
        name: Of the pair.
        theirs: Kheperax' line.
        ours: Our line.
        noisy: Whether the noise of both sides is on.
        calls: Whether Python gets the readings after every step.
    """

    name: str
    theirs: str
    ours: str
    noisy: bool
    calls: bool


NOISE = Pair("noise", "Kheperax, with its noise", "compiled bodies, with the laboratory's noise", True, False)
CLEAN = Pair("no noise", "Kheperax, no noise", "compiled bodies, no noise", False, False)
CALLS = Pair(
    "from Python",
    "Kheperax, with its noise, a call a step, readings as an array",
    "compiled bodies, with the laboratory's noise, a call a step, readings as an array",
    True,
    True,
)
PAIRS = (NOISE, CLEAN, CALLS)
DEFAULT = "Kheperax by default: its standard maze, three lasers, no noise"
TASKS = {
    "corridor": "`run_teacher`, corridor, one food object",
    "rectangle": "`run_teacher`, rectangle, four food objects",
}
"""The whole task, by arena."""


@dataclass(frozen=True, slots=True)
class TimedLine:
    """One line in one repeat.

    Attributes:
        line: Its name.
        worlds: Requested number of worlds.
        repeat: From 0.
        steps: Of all robots together.
        seconds: Of these steps.
        first_call: Seconds of the first call with these worlds, including compilation.
    """

    line: str
    worlds: int
    repeat: int
    steps: int
    seconds: float
    first_call: float

    @property
    def rate(self) -> float:
        """Robot-steps a second."""
        return self.steps / self.seconds


class Plan(NamedTuple):
    """How much is done.

    Attributes:
        worlds: Numbers of worlds for the pairs.
        reference: Number of worlds for the lines without a counterpart.
        at_least: Seconds of each line in each repeat.
        seed: Of our worlds.
    """

    worlds: tuple[int, ...]
    reference: int
    at_least: float
    seed: int


class Repeat(NamedTuple):
    """Every line once, the two of a pair one right after the other, so that a slow machine slows both sides of a ratio.

    Attributes:
        number: From 0; -1 warms up and leaves no rows.
        plan: How much.
        kheperax: Their side.
        bodies: Our side.
    """

    number: int
    plan: Plan
    kheperax: Kheperax
    bodies: OurBodies

    @property
    def key(self) -> str:
        """The number."""
        return str(self.number)

    def run(self) -> list[TimedLine]:
        """Time all lines."""
        rows = [
            TimedLine(line, worlds, self.number, timed.steps, timed.seconds, timed.first_call)
            for line, worlds, timed in self._timed()
        ]
        return rows if self.number >= 0 else []

    def _timed(self) -> Iterator[tuple[str, int, Timed]]:
        worlds_of_pairs, reference, at_least, seed = self.plan
        if self.number < 0:
            at_least = WARM_UP_SECONDS
        for worlds in worlds_of_pairs:
            for pair in PAIRS:
                setting = "noise" if pair.noisy else "none"
                yield pair.theirs, worlds, self.kheperax.timed(setting, worlds, at_least, pair.calls)
                yield pair.ours, worlds, self.bodies.timed(pair.noisy, worlds, at_least, pair.calls)
        yield DEFAULT, reference, self.kheperax.timed("default", reference, at_least, False)
        for arena, line in TASKS.items():
            yield line, reference, whole_task(arena, reference, seed, at_least)


Place = tuple[str, int]
"""A line and a number of worlds."""


def of_line(rows: Sequence[TimedLine], place: Place) -> list[TimedLine]:
    """The rows of a line with so many worlds, in the order of the repeats."""
    line, worlds = place
    return sorted(pick(rows, line=line, worlds=worlds), key=lambda row: row.repeat)


def worlds_of(rows: Sequence[TimedLine], line: str) -> list[int]:
    """The numbers of worlds of a line."""
    return sorted({row.worlds for row in pick(rows, line=line)})


def best(rows: Sequence[TimedLine], line: str) -> Place:
    """A line with the number of worlds for which its median rate is highest."""
    return line, max(worlds_of(rows, line), key=lambda worlds: rate(rows, (line, worlds)).value)


def rate(rows: Sequence[TimedLine], place: Place) -> Estimate:
    """Robot-steps a second: median, lowest and highest of the repeats."""
    return extremes([row.rate for row in of_line(rows, place)])


def ratio(rows: Sequence[TimedLine], ours: Place, theirs: Place) -> Estimate:
    """How many times as fast our line is, repeat by repeat: median, lowest and highest."""
    both = zip(of_line(rows, ours), of_line(rows, theirs), strict=True)
    return extremes([a.rate / b.rate for a, b in both])
