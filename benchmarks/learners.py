"""All learners side by side: how well each forages, and how much experience that took.

    python benchmarks/learners.py --help

Imitators, learners that query the teacher, and reinforcement learning, each tested after growing amounts of learning.
A run that was killed is continued by the same command. `--tune` compares settings instead, with other seeds.
"""

import argparse
import sys
from collections.abc import Mapping, Sequence

import numpy as np
from harness.arguments import Arguments, Count, parse
from harness.page import Page, write
from harness.processes import collect
from harness.rows import UNITS, finished_units
from learner_comparison import tuning
from learner_comparison.clusters import BACKENDS, unavailable
from learner_comparison.curves import curves
from learner_comparison.learning import Compared
from learner_comparison.page import page
from learner_comparison.rows import RecallBatch, Size, in_order, steps_up_to
from learner_comparison.units import all_learners, missing_extra, plan, planned_or_finished, settings_of

from khepera_forage.policies.learner_registry import installed_learners, learner_at
from khepera_forage.rollouts.row_files import read_rows

TUNING = "tuning"
"""The folder in `--out` that `--tune` writes to."""
COUNTS = (
    Count("seeds", 10, 2, "repetitions of everything, each with training files of its own", adds_units=True),
    Count("recalls", 10, 1, "recalls in each arena after each amount of learning"),
    Count("steps", 1_000_000, 1_000, "most environment steps of reinforcement learning"),
)
EPISODES, QUICK_EPISODES = (1, 2, 3, 5, 10), (1, 2)
QUERIES, QUICK_QUERIES = (100, 200, 300, 500, 1_000), (100, 200)


def rows_of(
    learners: Mapping[str, Compared],
    known: Mapping[str, Compared],
    replications: range,
    size: Size,
    given: Arguments,
) -> list[RecallBatch]:
    """All rows of the folder, after the missing ones have been made.

    Args:
        learners: To be done now.
        known: All that may have rows in the folder.
        replications: Of each.
        size: Of the run.
        given: Folder, processes and settings.
    """
    units = plan(learners, replications, size, given.seed)
    try:
        if not given.fresh:
            units = planned_or_finished(units, finished_units(given.out), known)
    except ValueError as error:
        sys.exit(f"learners.py: {given.out / UNITS}: {error}")
    settings = {f"learner {name}": settings_of(learner) for name, learner in learners.items()}
    with BACKENDS[given.backend](given.jobs, given.address) as workers:
        rows = collect(given, units, {RecallBatch: "rows"}, workers.execute, settings)
    return in_order(rows.of(RecallBatch), list(known))


def compare(size: Size, given: Arguments) -> Page:
    """All learners of the registry."""
    known = all_learners() | own_learners(given)
    chosen = [*(given.only or ()), *own_learners(given)] or known
    wanted = {name: learner for name, learner in known.items() if name in chosen}
    missing = {name: reason for name, learner in wanted.items() if (reason := missing_extra(learner))}
    if not given.only:
        missing |= installed_learners().broken
    for name, reason in missing.items():
        print(f"{name} is left out: {reason}")
    learners = {name: learner for name, learner in wanted.items() if name not in missing}
    if not learners:
        sys.exit("learners.py: no learner is left")
    rows = rows_of(learners, known, range(given.seeds), size, given)
    found = curves(rows, np.random.default_rng(given.seed))
    return page(found, known, missing, tuning_result(given))


def own_learners(given: Arguments) -> dict[str, Compared]:
    """The learners of `--learner`, by name.

    Raises:
        SystemExit: There is no such learner, or its name is that of another.
    """
    found: dict[str, Compared] = {}
    for place in given.learner or ():
        try:
            name, learner = learner_at(place)
        except ValueError as error:
            sys.exit(f"learners.py: --{error}")
        if name in all_learners() or name in found:
            sys.exit(
                f"learners.py: --learner is {place!r}, a name that another learner has; allowed: a new name"
            )
        found[name] = learner
    return found


def tune(size: Size, given: Arguments) -> Page:
    """Settings beside those of the registry."""
    known = tuning.candidates()
    wanted = given.only or list(known)
    learners = {name: learner for name, learner in known.items() if name.split(".")[0] in wanted}
    if not learners:
        sys.exit(
            f"learners.py: --only is {', '.join(wanted)}; allowed with --tune: {', '.join(tuning.CANDIDATES)}"
        )
    size = size._replace(episodes=size.episodes[-1:], queries=size.queries[-1:])
    first = tuning.FIRST_REPLICATION
    rows = rows_of(learners, known, range(first, first + given.seeds), size, given)
    return tuning.page(rows, known, np.random.default_rng(given.seed))


def tuning_result(given: Arguments) -> str:
    """The result of an earlier run with `--tune` in the same folder; empty without one."""
    folder = given.out / TUNING
    if not (folder / "tuning.md").exists():
        return ""
    known = tuning.candidates()
    kept = [row for row in read_rows(folder / "rows.csv", RecallBatch) if row.learner in known]
    gains = tuning.differences(in_order(kept, list(known)), np.random.default_rng(given.seed))
    return tuning.result(gains, known)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of this script alone."""
    text = "one learner; may be given several times (all)"
    parser.add_argument("--only", action="append", choices=list(all_learners()), help=text)
    text = "a learner of your own, package.module:name of what makes a classifier; beside those of --only, if any"
    parser.add_argument("--learner", action="append", metavar="PLACE", help=text)
    parser.add_argument("--tune", action="store_true", help="compare settings of each learner instead")
    text = "where the work is done: loky is this machine (loky)"
    parser.add_argument("--backend", choices=list(BACKENDS), default="loky", help=text)
    parser.add_argument(
        "--address", help="of a Ray or Dask cluster (by default a temporary one on this machine)"
    )


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the benchmark."""
    given = parse("learners", __doc__, *COUNTS, add=add_arguments, given=arguments)
    if reason := unavailable(given.backend, given.address):
        sys.exit(f"learners.py: {reason}")
    size = Size(
        recalls=given.recalls,
        episodes=QUICK_EPISODES if given.quick else EPISODES,
        queries=QUICK_QUERIES if given.quick else QUERIES,
        steps=steps_up_to(given.steps),
    )
    options = [f"--only {name}" for name in given.only or ()]
    if given.tune and given.learner:
        sys.exit("learners.py: --learner has no effect with --tune; allowed: without")
    if given.tune:
        given.out /= TUNING
        written = tune(size, given)
        write(given.out, TUNING, written, given.command("--tune", *options))
    else:
        written = compare(size, given)
        own = [f"--learner {place}" for place in given.learner or ()]
        write(given.out, "learners", written, given.command(*own))
    print("\n".join(table.markdown() for table in written.tables))
    print(f"Page, picture, tables and rows are in {given.out}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
