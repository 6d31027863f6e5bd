"""How far a step of the batched worlds is from the limit of the machine, on one core. Needs numba.

    python benchmarks/operations.py --help

The operations of a step under the teacher in the corridor are counted, by running the kernels in plain Python on
numbers that count. What the core does at most is measured by simple loops on numbers in its first cache. Both together
give the least time of a step for these operations; beside it stands the time that a step takes.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from time import perf_counter

import numba
from _operations.counters import ARITHMETIC, COMPARISON, DIVISION, KINDS, LOAD, STORE
from _operations.counting import PARTS, Counts, counted_apart
from _operations.peaks import ARITHMETIC as ARITHMETIC_LOOP
from _operations.peaks import COMPARISONS, DIVISIONS, MEMORY, PEAKS, Peak, rate, width
from arguments import add_count, count_of, parser_for

from khepera_forage.rollouts.compiled.recalls import run_teacher
from khepera_forage.thesis.tables import Column, Table

STEPS, QUICK_STEPS = 20_000, 100
"""Steps that are counted, about: whole episodes of some `_EPISODE` each."""
EPISODES, QUICK_EPISODES = 16_384, 256
"""Episodes by which a step is timed, in each repeat."""
REPEATS, QUICK_REPEATS = 9, 2
STEM = "operations"
_EPISODE = 96


def counts_table(counts: Counts) -> Table:
    """Operations of a step, by part and kind."""
    parts = [*PARTS, *sorted({part for part, _ in counts.by_part} - PARTS.keys())]
    values = [[counts.by_part.get((part, kind), 0) / counts.steps for kind in KINDS] for part in parts]
    together = [sum(column) for column in zip(*values, strict=True)]
    rows = [(part, *row) for part, row in zip([*parts, "together"], [*values, together], strict=True)]
    return Table(
        f"{STEM}_counts",
        "Operations of a step of one world",
        f"Over {counts.steps:,} steps. Of a choice only the side that is taken counts.",
        (Column("part"), *(Column(kind) for kind in KINDS)),
        rows,
    )


def peaks_table(peaks: dict[Peak, float]) -> Table:
    """What one core does at most."""
    return Table(
        f"{STEM}_peaks",
        "What one core does at most",
        "Operations a nanosecond, each on one float64; the best repeat.",
        (Column("operation"), Column("a nanosecond"), Column("bits of a register")),
        [(peak.name, best, width(peak)) for peak, best in peaks.items()],
    )


def limit_table(counts: Counts, peaks: dict[Peak, float], step: float) -> Table:
    """The least time of a step, and the time it takes.

    Args:
        counts: Of some steps.
        peaks: Operations a nanosecond.
        step: ns that a step takes.
    """
    done = {
        kind: sum(n for (_, k), n in counts.by_part.items() if k == kind) / counts.steps for kind in KINDS
    }
    arithmetic = done[ARITHMETIC] / peaks[ARITHMETIC_LOOP]
    compared = done[COMPARISON] / peaks[COMPARISONS]
    divided = done[DIVISION] / peaks[DIVISIONS]
    memory = (done[LOAD] + done[STORE]) / peaks[MEMORY]
    least = max(arithmetic + compared + divided, memory)
    return Table(
        f"{STEM}_limit",
        "The least time of a step, and the time it takes",
        "Loads and stores go on beside the rest: the larger of both sides counts. "
        "Roots are taken at the rate of divisions, which is the higher one.",
        (Column("what"), Column("ns a step"), Column("share of the step (%)", 0)),
        [
            (name, time, 100 * time / step)
            for name, time in (
                ("arithmetic", arithmetic),
                ("comparisons", compared),
                ("roots, divisions", divided),
                ("loads and stores, beside these", memory),
                ("least time", least),
                ("a step of run_teacher, as measured", step),
            )
        ],
    )


def measure(repeats: int, episodes: int, seed: int) -> tuple[dict[Peak, float], float]:
    """The best of some repeats, on one core: operations a nanosecond of each loop, and ns of a step."""
    most = numba.get_num_threads()
    numba.set_num_threads(1)
    run_teacher(episodes=1, seed=seed)  # compiles
    best, step = dict.fromkeys(PEAKS, 0.0), float("inf")
    for _ in range(repeats):
        best = {peak: max(known, rate(peak)) for peak, known in best.items()}
        start = perf_counter()
        steps = int(run_teacher(episodes=episodes, seed=seed).steps.sum())
        step = min(step, (perf_counter() - start) / steps * 1e9)
    numba.set_num_threads(most)
    return best, step


def write(folder: Path, tables: Sequence[Table]) -> str:
    """Write the tables.

    Returns:
        The page with all of them.
    """
    folder.mkdir(parents=True, exist_ok=True)
    text = "\n".join(table.markdown() for table in tables)
    (folder / f"{STEM}.md").write_text(text, encoding="utf-8")
    for table in tables:
        (folder / f"{table.stem}.csv").write_text(table.csv(), encoding="utf-8")
    return text


def run(arguments: argparse.Namespace) -> int:
    """Do what the arguments ask for."""
    quick = arguments.quick
    steps = count_of(arguments.steps, STEPS, quick, QUICK_STEPS)
    counts = counted_apart(-(-steps // _EPISODE), arguments.seed)
    episodes, repeats = (QUICK_EPISODES, QUICK_REPEATS) if quick else (EPISODES, REPEATS)
    peaks, step = measure(repeats, episodes, arguments.seed)
    tables = counts_table(counts), peaks_table(peaks), limit_table(counts, peaks, step)
    print(write(arguments.out, tables))
    print(f"The tables are in {arguments.out}")
    return 0


if __name__ == "__main__":
    parser = parser_for(__doc__, "results/operations")
    add_count(parser, "--steps", STEPS, QUICK_STEPS, "steps that are counted, about: whole episodes")
    sys.exit(run(parser.parse_args()))
