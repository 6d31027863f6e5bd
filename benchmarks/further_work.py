"""What the thesis left to do: one small experiment a question, each with a figure, intervals and an answer.

    python benchmarks/further_work.py --help

The experiments stand in `benchmarks/_further_work/`, one file each. A page, a picture, the tables and all rows of each
are written to a folder of its own name.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from _further_work.experiment import Experiment, Report
from _further_work.page import claim_table, page
from _further_work.registry import EXPERIMENTS
from _further_work.rows import Done, Lesson, Recalled, Size, Unit
from arguments import add_count, count_of, parser_for
from joblib import Parallel, delayed
from tqdm import tqdm

from khepera_forage.rollouts.row_files import write_rows
from khepera_forage.thesis.figures import save

REPLICATIONS, QUICK_REPLICATIONS = 20, 2
QUICK = {"files": 3, "recalls": 1, "generations": 2, "attempts": 5}
"""The same work in small."""


def work(experiment: Experiment, units: Sequence[Unit], jobs: int) -> Done:
    """Do it; the rows come in its order, whatever the number of processes."""
    running = Parallel(n_jobs=jobs, return_as="generator")(delayed(experiment.run)(unit) for unit in units)
    progress = tqdm(
        running, total=len(units), desc=experiment.name, unit="unit", disable=not sys.stderr.isatty()
    )
    parts = list(progress)
    return Done(
        tuple(row for part in parts for row in part.lessons),
        tuple(row for part in parts for row in part.recalls),
    )


def write(folder: Path, experiment: Experiment, done: Done, report: Report, command: str) -> None:
    """Write page, picture, tables and rows of one experiment."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{experiment.name}.md").write_text(page(experiment, report, command), encoding="utf-8")
    for table in (claim_table(report.claims), *report.tables):
        (folder / f"table_{table.stem}.csv").write_text(table.csv(), encoding="utf-8")
    write_rows(folder / "lessons.csv", Lesson, done.lessons)
    if done.recalls:
        write_rows(folder / "recalls.csv", Recalled, done.recalls)
    save(report.figure, folder / f"{experiment.name}.png")


def run(arguments: argparse.Namespace) -> int:
    """Do what the arguments ask for."""
    replications = count_of(arguments.replications, REPLICATIONS, arguments.quick, QUICK_REPLICATIONS)
    size = Size(replications, **(QUICK if arguments.quick else {}))
    for name in arguments.only or EXPERIMENTS:
        experiment = EXPERIMENTS[name]
        done = work(experiment, experiment.units(arguments.seed, size), arguments.jobs)
        report = experiment.report(done, np.random.default_rng(arguments.seed))
        command = (
            f"python benchmarks/further_work.py --only {name} --replications {replications} --seed {arguments.seed}"
            f"{' --quick' if arguments.quick else ''}"
        )
        write(arguments.out / name, experiment, done, report, command)
        print(f"{experiment.title}: {experiment.question}")
        for claim in report.claims:
            print(f"  {claim.verdict}: {claim.name}: {claim.effect}")
    print(f"Pages, pictures, tables and rows are in {arguments.out}")
    return 0


if __name__ == "__main__":
    parser = parser_for(__doc__, "results/further_work")
    add_count(
        parser,
        "--replications",
        REPLICATIONS,
        QUICK_REPLICATIONS,
        "repetitions of each experiment, new training files included",
    )
    parser.add_argument(
        "--only",
        action="append",
        choices=list(EXPERIMENTS),
        help="one experiment; may be given several times (all)",
    )
    parser.add_argument("--jobs", type=int, default=-1, help="processes; -1 is one a core (-1)")
    sys.exit(run(parser.parse_args()))
