"""Speed of environments, policies and compiled worlds, compared with goals and with bare pymunk.

    python benchmarks/throughput.py --help

Goals on one core: 15,000 steps a second of Corridor-v1 under the teacher, 4,000 rounds a second of the paired
corridors, 40,000 decisions a second of an imitator with 1,000 experience vectors, half a second for the import, 1 GB
for the main job. With `--compiled`: 4 million steps a second in the kernel, 2 million and 100 times pymunk through
`gym.make_vec`, 60,000 of one world, and half the corridor's rate in 10,000 arenas; there is then a second picture, of
the cost of a step against worlds and food.

`--beside COMMIT` measures something else: the speed of this checkout beside that of a commit, such as a0e33ed (the
last with blocks of worlds), with a target for each ratio. It needs git, and numba for all cases but `--only pymunk`.
About 25 minutes on two cores; with --quick ten minutes, nearly all of them compilation.
"""

import argparse
import sys
from pathlib import Path

from timing import (
    bare_pymunk,
    beside,
    compiled,
    compiling,
    environments,
    fresh_processes,
    imitator,
    parts,
    pools,
    scaling,
)
from timing.checkouts import checkouts
from timing.measures import Job, Measured, Repeat, lines_of, repeats
from timing.page import page

from khepera_forage.study import Arguments, Count, collect, finish, parse, write

COUNTS = (
    Count("steps", 10_000, 150, "steps, rounds or decisions of each measure in a repeat"),
    Count("repeats", 7, 2, "repeats, of which the median counts"),
)
ROOT = Path(__file__).resolve().parents[1]
EPISODES, QUICK_EPISODES = 16_384, 1_024
"""Compiled episodes of a measure in each repeat."""
COMPILED_STEPS, QUICK_COMPILED_STEPS = 100_000, 2_000
"""Steps of each measure against the number of worlds, and of food."""


def python_jobs(steps: int, seed: int) -> list[Job]:
    """Everything on pymunk.

    Args:
        steps: Steps, rounds or decisions of a measure in each repeat.
        seed: Of all episodes and trainings.
    """
    return [
        *environments.jobs(steps, seed),
        bare_pymunk.job(steps),
        imitator.job(steps, seed),
        fresh_processes.import_job,
        parts.job(steps, seed),
    ]


def compiled_jobs(quick: bool, seed: int) -> list[Job]:
    """Everything compiled that is repeated."""
    episodes = QUICK_EPISODES if quick else EPISODES
    return [
        compiled.worlds_job(episodes, seed),
        compiled.imitators_job(episodes, seed),
        compiled.training_job(episodes, seed),
        scaling.job(QUICK_COMPILED_STEPS if quick else COMPILED_STEPS, seed),
        pools.recalls_job(pools.QUICK_ARENAS if quick else pools.ARENAS, seed),
        pools.pool_job(pools.QUICK_ARENAS if quick else pools.ARENAS, 20 if quick else 200, seed),
    ]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of this script alone."""
    parser.add_argument("--compiled", action="store_true", help="also the compiled backend (needs numba)")
    parser.add_argument("--memory", action="store_true", help="also the peak memory of the main job in small")
    text = "measure only the speed of this checkout beside that of a commit; page and rows are beside.md and beside.csv"
    parser.add_argument("--beside", metavar="COMMIT", help=text)
    names = [case.name for case in beside.CASES]
    text = "a case of --beside; may be given several times (all)"
    parser.add_argument("--only", action="append", choices=names, help=text)


def compare(given: Arguments) -> int:
    """Measure this checkout beside a commit, and write and print the ratios."""
    cases = [case for case in beside.CASES if not given.only or case.name in given.only]
    try:
        with checkouts(given.beside, ROOT) as (theirs, ours):
            units = beside.pairs(cases, (theirs, ours), given.repeats, given.quick, given.seed)
            rows = collect(given, units, {beside.Timed: "beside"}).of(beside.Timed)
    except (ValueError, beside.CaseError) as error:
        given.refuse(str(error))
    result = beside.page(rows, theirs, ours, given.repeats, given.quick)
    write(given.out, "beside", result)
    print("\n".join(table.markdown() for table in result.tables))
    print(f"Page, table and rows are in {given.out}: beside.md, table_beside.csv, beside.csv")
    return 0


def main() -> int:
    """Run the benchmark."""
    given = parse("throughput", __doc__, *COUNTS, jobs=None, add=add_arguments)
    if given.beside is not None:
        if given.compiled or given.memory:
            sys.exit(
                "throughput.py: --beside measures nothing else; allowed: without --compiled and --memory"
            )
        return compare(given)
    if given.only:
        given.refuse("--only selects cases of --beside; allowed: with --beside COMMIT")
    seed, quick = given.seed, given.quick
    units = repeats("python", python_jobs(given.steps, seed), given.repeats)
    if given.compiled:
        units += repeats("compiled", compiled_jobs(quick, seed), given.repeats)
        replications = compiled.QUICK_REPLICATIONS if quick else compiled.REPLICATIONS
        units.append(Repeat("design", 0, [compiled.design_job(replications, seed)]))
        units.append(Repeat("compiling", 0, [compiling.job]))
    if given.memory:
        units.append(Repeat("memory", 0, [fresh_processes.memory_job(seed)]))
    rows = collect(given, units, {Measured: "measurements"})
    return finish(given, page(lines_of(rows.of(Measured))))


if __name__ == "__main__":
    sys.exit(main())
