"""Speed beside that of a commit: the same cases in both checkouts, alternately, each in a fresh process."""

import os
import statistics
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import NamedTuple

from khepera_forage.estimates import Column, Table, Value, extremes
from khepera_forage.study import Page
from timing.beside_cases import EPISODES, WORLDS
from timing.checkouts import Checkout
from timing.measures import LOWER_IS_BETTER, digits

_SCRIPT = Path(__file__).with_name("beside_cases.py")
FIRST_CALL_PAIRS = 3
"""Pairs of a case that compiles: the compilation takes long enough to be measured."""


class Case(NamedTuple):
    """Something to measure in both checkouts.

    Attributes:
        name: In `beside_cases.CASES`.
        label: In the table; `{size}` stands for the size.
        unit: Of its values.
        target: Of the ratio of this checkout to the commit: at least, or at most if less is better.
        size: Steps, rounds, calls, replications, worlds, episodes or learners.
        quick: The size with `--quick`.
        first_call: Whether each process starts without any compiled kernel.
        one_core: Whether the case has one thread, so that both processes of a pair can run on the same core.
    """

    name: str
    label: str
    unit: str
    target: float
    size: int
    quick: int
    first_call: bool = False
    one_core: bool = False


# Targets are relative to a0e33ed, the last commit whose kernels worked on blocks of worlds. Its first calls took 0.4 to
# 0.45 of the time that numba takes as documented.
CASES = (
    Case(
        "pymunk",
        "Corridor-v0 on pymunk under the teacher, resets included",
        "steps/s",
        0.6,
        30_000,
        400,
        one_core=True,
    ),
    Case("make_vec", f"Corridor-v0 of make_vec, {WORLDS:,} worlds", "steps/s", 0.35, 200, 5),
    Case("kernel", f"teacher in the kernel, {EPISODES:,} recalls on two threads", "steps/s", 0.3, 15, 1),
    Case(
        "one_world",
        "one compiled Corridor-v0, resets included",
        "steps/s",
        0.6,
        200_000,
        1_000,
        one_core=True,
    ),
    Case("design", "{size} replications of the thesis's design, without the report", "s", 4.0, 1000, 2),
    Case("first_make_vec", f"first call of make_vec, {WORLDS:,} worlds", "s", 1.9, WORLDS, WORLDS, True),
    Case("first_run_teacher", "first call of run_teacher, 128 recalls", "s", 1.9, 128, 128, True),
    Case("first_train_learners", "first call of train_learners, 128 learners", "s", 1.9, 128, 128, True),
)


class CaseError(RuntimeError):
    """A case failed in one of the checkouts."""


@dataclass(frozen=True, slots=True)
class Timed:
    """A value of a case in one checkout.

    Attributes:
        case: Its name.
        pair: From 0; a pair has one value of each checkout.
        checkout: Name of the checkout.
        value: In the unit of the case.
    """

    case: str
    pair: int
    checkout: str
    value: float


class Pair(NamedTuple):
    """A case once in each checkout, one after the other.

    Attributes:
        case: What is measured.
        number: From 0; -1 compiles the kernels and leaves no rows.
        checkouts: The commit, then this checkout.
        size: Of the case.
        seed: Of the case.
    """

    case: Case
    number: int
    checkouts: tuple[Checkout, Checkout]
    size: int
    seed: int

    @property
    def key(self) -> str:
        """Case and number."""
        return f"{self.case.name} {self.number}"

    def run(self) -> list[Timed]:
        """Measure both."""
        values = [Timed(self.case.name, self.number, each.name, self._value(each)) for each in self.checkouts]
        return values if self.number >= 0 else []

    @property
    def core(self) -> int | None:
        """The core on which both processes run, if one is enough; pairs take turns, as one core may be slower."""
        if not self.case.one_core or not hasattr(os, "sched_getaffinity"):
            return None
        cores = sorted(os.sched_getaffinity(0))
        return cores[self.number % len(cores)]

    def _value(self, checkout: Checkout) -> float:
        if not self.case.first_call or self.number < 0:
            return value_of(
                self.case.name, self.size, self.seed, checkout.root, checkout.cache, core=self.core
            )
        with TemporaryDirectory(dir=checkout.root.parent) as empty:
            return value_of(self.case.name, self.size, self.seed, checkout.root, Path(empty))


def value_of(
    case: str, size: int, seed: int, root: Path, cache: Path | None = None, *, core: int | None = None
) -> float:
    """The value of a case, measured in a fresh process.

    Args:
        case: In `beside_cases.CASES`.
        size: Of the case.
        seed: Of the case.
        root: Folder that contains the package.
        cache: Folder for the machine code of its kernels; by default numba's.
        core: Number of the core on which the process runs; by default any.

    Raises:
        CaseError: The case failed, or measured another package.
    """
    environment = {**os.environ, "PYTHONPATH": str(root)}
    if cache is not None:
        environment["NUMBA_CACHE_DIR"] = str(cache)
    command = [sys.executable, "-P", str(_SCRIPT), case, str(size), str(seed)]
    command += [] if core is None else [str(core)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    if done.returncode:
        last = (done.stderr.strip().splitlines() or [f"status {done.returncode}"])[-1]
        raise CaseError(f"case {case} failed in {root}: {last}; --only measures other cases")
    value, package = done.stdout.splitlines()
    if Path(package) != root:
        raise CaseError(f"case {case} measured the package in {package}; allowed: the one in {root}")
    return float(value)


def pairs(
    cases: Sequence[Case], checkouts: tuple[Checkout, Checkout], repeats: int, quick: bool, seed: int
) -> list[Pair]:
    """All pairs; a machine that is slow for a while slows one pair of several cases, not all pairs of one case.

    Every pair has a seed of its own, because the starts and food places of a seed may differ between the checkouts.
    """

    def pair(case: Case, number: int) -> Pair:
        small = quick or number < 0
        return Pair(case, number, checkouts, case.quick if small else case.size, seed + max(number, 0))

    return [
        pair(case, number)
        for number in range(-1, repeats)
        for case in cases
        if not case.first_call or number < FIRST_CALL_PAIRS
    ]


def page(rows: Sequence[Timed], theirs: Checkout, ours: Checkout, repeats: int, quick: bool) -> Page:
    """The table of all cases that have rows."""
    head = (
        f"Speed of this checkout ({ours.version}) beside commit {theirs.version}, with the same Python and the same "
        f"libraries. Each case runs alternately in both checkouts: {repeats} pairs, and "
        f"{min(repeats, FIRST_CALL_PAIRS)} of first calls. Each measurement has a process of its own, and each pair a "
        "seed of its own. A case with one thread runs on the same core in both checkouts, and pairs take turns between "
        "the cores. Kernels are compiled before the first pair; a first call finds none, and its seconds count "
        "from the import."
    )
    note = (
        "Medians of each checkout, and the ratio of this checkout to the commit: the median over pairs [lowest, "
        "highest]."
    )
    columns = tuple(map(Column, ("case", "unit", theirs.name, ours.name)))
    columns += (Column("ratio", 2, estimate=True), Column("target"), Column("met"))
    lines: list[tuple[Value, ...]] = []
    for case in CASES:
        own = [row for row in rows if row.case == case.name]
        if own:
            size = case.quick if quick else case.size
            lines.append((case.label.format(size=f"{size:,}"), *_line(case, own, theirs, ours)))
    title = f"Throughput beside commit {theirs.version}"
    return Page(title, [head, Table("beside", "Ratios", note, columns, lines)])


def _line(case: Case, rows: Sequence[Timed], theirs: Checkout, ours: Checkout) -> tuple[Value, ...]:
    """The case's line in the table, but for its label."""
    before, now = ([row.value for row in rows if row.checkout == each.name] for each in (theirs, ours))
    ratio = extremes([b / a for a, b in zip(before, now, strict=True)])
    at_most = case.unit in LOWER_IS_BETTER
    met = ratio.value <= case.target if at_most else ratio.value >= case.target
    medians = [statistics.median(values) for values in (before, now)]
    return (
        case.unit,
        *(f"{value:,.{digits(value)}f}" for value in medians),
        ratio,
        f"at {'most' if at_most else 'least'} {case.target:.2f}",
        "yes" if met else "no",
    )
