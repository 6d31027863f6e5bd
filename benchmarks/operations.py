"""The distance of a compiled step from the limit of the machine, on one core. Needs numba.

    python benchmarks/operations.py --help

The operations of a step under the teacher in the corridor are counted, by running the kernels in plain Python on
numbers that count. The highest rate of each operation on a core is measured by simple loops on numbers in its first
cache. Both together give the shortest possible time of a step with these operations, which is compared with the
measured time.
"""

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from time import perf_counter
from typing import TYPE_CHECKING, NamedTuple

import numba
from operation_counts.counters import ARITHMETIC, COMPARISON, DIVISION, KINDS, LOAD, STORE
from operation_counts.counting import PARTS, count_apart
from operation_counts.peaks import ARITHMETIC as ARITHMETIC_LOOP
from operation_counts.peaks import COMPARISONS, DIVISIONS, MEMORY, PEAKS, rate, width

from khepera_forage.experiments.arguments import Count, parse
from khepera_forage.experiments.figures import OURS, THESIS, grid, new_figure
from khepera_forage.experiments.measures import pick
from khepera_forage.experiments.page import Page, Picture, finish
from khepera_forage.experiments.processes import Unit, collect
from khepera_forage.experiments.tables import Column, Table
from khepera_forage.rollouts.compiled.recalls import run_teacher

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STEPS = Count("steps", 20_000, 100, "steps that are counted, about: whole episodes")
EPISODES, QUICK_EPISODES = 16_384, 256
"""Episodes for the time of a step, in each repeat."""
REPEATS, QUICK_REPEATS = 9, 2
_STEPS_AN_EPISODE = 96
STEP = "a step of run_teacher"


@dataclass(frozen=True, slots=True)
class Counted:
    """Operations of one kind in one part of a round.

    Attributes:
        part: Of the round.
        kind: One of `KINDS`.
        number: In all steps.
        steps: How many there were.
    """

    part: str
    kind: str
    number: int
    steps: int


@dataclass(frozen=True, slots=True)
class Timed:
    """One repeat of a loop, or of the step.

    Attributes:
        name: Of a peak, or `STEP`.
        repeat: From 0.
        ns: Nanoseconds of one operation, or of the step.
    """

    name: str
    repeat: int
    ns: float


class Counting(NamedTuple):
    """Counts the operations of some episodes."""

    episodes: int
    seed: int

    @property
    def key(self) -> str:
        """There is one unit of this kind."""
        return "operations"

    def run(self) -> list[Counted]:
        """Count in another process."""
        counts = count_apart(self.episodes, self.seed)
        return [Counted(*where, number, counts.steps) for where, number in counts.by_part.items()]


class Timing(NamedTuple):
    """One repeat of all loops and of the step, on one core."""

    repeat: int
    episodes: int
    seed: int

    @property
    def key(self) -> str:
        """Number of the repeat."""
        return f"repeat {self.repeat}"

    def run(self) -> list[Timed]:
        """Measure all loops, then the step."""
        threads = numba.get_num_threads()
        numba.set_num_threads(1)
        run_teacher(episodes=1, seed=self.seed)  # compiles
        rows = [Timed(peak.name, self.repeat, 1 / rate(peak)) for peak in PEAKS]
        start = perf_counter()
        steps = int(run_teacher(episodes=self.episodes, seed=self.seed).steps.sum())
        rows.append(Timed(STEP, self.repeat, (perf_counter() - start) / steps * 1e9))
        numba.set_num_threads(threads)
        return rows


def counts_table(rows: Sequence[Counted]) -> Table:
    """Operations of a step, by part and kind."""
    numbers = {(row.part, row.kind): row.number / row.steps for row in rows}
    parts = [*PARTS, *sorted({part for part, _ in numbers} - PARTS.keys())]
    values = [[numbers.get((part, kind), 0) for kind in KINDS] for part in parts]
    sums = [sum(column) for column in zip(*values, strict=True)]
    return Table(
        "counts",
        "Operations of a step of one world",
        f"Over {rows[0].steps:,} steps. Of a choice, only the side that is taken counts.",
        (Column("part"), *(Column(kind) for kind in KINDS)),
        [(part, *row) for part, row in zip([*parts, "sum"], [*values, sums], strict=True)],
    )


def peaks_table(rows: Sequence[Timed]) -> Table:
    """The highest rates of operations on one core."""
    return Table(
        "peaks",
        "Highest rates of one core",
        "Operations a nanosecond, each on one float64; the best repeat.",
        (Column("operation"), Column("a nanosecond"), Column("bits of a register")),
        [(peak.name, 1 / best(rows, peak.name), width(peak)) for peak in PEAKS],
    )


def best(rows: Sequence[Timed], name: str) -> float:
    """The shortest time of all repeats, in ns."""
    return min(row.ns for row in pick(rows, name=name))


def limits(counts: Sequence[Counted], times: Sequence[Timed]) -> dict[str, float]:
    """Nanoseconds of a step by kind of operation, their sum, and the measured time."""
    done = {kind: sum(row.number / row.steps for row in pick(counts, kind=kind)) for kind in KINDS}
    arithmetic = done[ARITHMETIC] * best(times, ARITHMETIC_LOOP.name)
    comparisons = done[COMPARISON] * best(times, COMPARISONS.name)
    divisions = done[DIVISION] * best(times, DIVISIONS.name)
    memory = (done[LOAD] + done[STORE]) * best(times, MEMORY.name)
    return {
        "arithmetic": arithmetic,
        "comparisons": comparisons,
        "roots, divisions": divisions,
        "loads and stores, in parallel": memory,
        "shortest time": max(arithmetic + comparisons + divisions, memory),
        "measured: a step of run_teacher": best(times, STEP),
    }


def limit_table(found: dict[str, float]) -> Table:
    """The shortest possible time of a step, and the measured time."""
    *_, measured = found.values()
    return Table(
        "limit",
        "Shortest possible and measured time of a step",
        "Loads and stores run in parallel with the rest, so the larger of the two sums is the limit. Roots count at "
        "the rate of divisions, which is higher.",
        (Column("operations"), Column("ns a step"), Column("share of the step (%)", 0)),
        [(name, time, 100 * time / measured) for name, time in found.items()],
    )


def picture(found: dict[str, float]) -> "Figure":
    """The times of a step as bars."""
    figure = new_figure(6.4, 2.8)
    axes = figure.subplots()
    names = list(found)[::-1]
    colours = [THESIS if name.startswith("measured") else OURS for name in names]
    axes.barh(range(len(names)), [found[name] for name in names], color=colours)
    axes.set_yticks(range(len(names)), names, fontsize=8)
    axes.set_xlabel("ns a step of one world, one core")
    grid(axes, "x")
    return figure


def main() -> int:
    """Run the benchmark."""
    given = parse("operations", __doc__, STEPS, jobs=None)
    episodes, repeats = (QUICK_EPISODES, QUICK_REPEATS) if given.quick else (EPISODES, REPEATS)
    counting = Counting(-(-given.steps // _STEPS_AN_EPISODE), given.seed)
    units: list[Unit] = [counting, *(Timing(number, episodes, given.seed) for number in range(repeats))]
    rows = collect(given, units, {Counted: "operations", Timed: "times"})
    counts, times = rows.of(Counted), rows.of(Timed)
    found = limits(counts, times)
    shown = Picture("operations", "shortest possible and measured time of a step", picture(found))
    tables = counts_table(counts), peaks_table(times), limit_table(found)
    return finish(given, Page("The limit of the machine", [*tables, shown]))


if __name__ == "__main__":
    sys.exit(main())
