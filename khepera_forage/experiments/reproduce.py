"""The main job: the whole design in replications, over all cores, and the report on it."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from joblib import Parallel, delayed
from tqdm import tqdm

from khepera_forage.experiments.design import LABORATORY, NO_NOISE, THESIS, Cell, noise_conditions
from khepera_forage.experiments.next_to_food import VoteRow
from khepera_forage.experiments.replication import Attempts, Baseline, Outcome, Replication, Work
from khepera_forage.experiments.report import PAGE, write_report
from khepera_forage.experiments.row_files import RowWriter
from khepera_forage.experiments.rows import RANDOM, TEACHER, RecallRow, TrainingRow
from khepera_forage.experiments.statistics import FEWEST

REPLICATIONS = 24
"""By default; about two minutes on two cores."""
QUICK_REPLICATIONS = 2
NOISE_CELLS: tuple[Cell, ...] = tuple(cell for cell in THESIS if cell.episodes == 10)
"""What is repeated under each single source of noise: ten training episodes, recalls in both arenas."""


def plan(seed: int, replications: int, quick: bool = False) -> list[Work]:
    """All pieces of work, the slowest kind first.

    Args:
        seed: Of the reproduction.
        replications: Of the whole design; noise conditions get a third of it, and enough for intervals.
        quick: Only enough to exercise every part.
    """
    forages = 5 if quick else 25
    blocks = 2 if quick else 20
    few = 1 if quick else max(FEWEST, replications // 3)
    conditions = [name for name in noise_conditions() if name != LABORATORY]
    if quick:
        conditions = [NO_NOISE]
    work: list[Work] = [Replication(seed, i) for i in range(replications)]
    work += [Replication(seed, i, noise, NOISE_CELLS) for noise in conditions for i in range(few)]
    # Without losses only the attempts count, and there are to be as many of them as with losses.
    work += [Attempts(seed, i) for i in range(0 if quick else few, replications)]
    for arena in ("corridor", "rectangle"):
        work += [Baseline(seed, i, TEACHER, arena, forages) for i in range(blocks)]
        work += [Baseline(seed, i, RANDOM, arena, forages // 5) for i in range(blocks)]
    return work


def reproduce(seed: int, replications: int, out: Path, jobs: int = -1, quick: bool = False) -> Path:
    """Run everything and write the report.

    Args:
        seed: The same seed gives the same rows, whatever the number of processes.
        replications: Of the whole design.
        out: Folder for rows, tables and figures.
        jobs: Processes; -1 is one a core.
        quick: The same work in small, in under a minute.

    Returns:
        The report, a Markdown page.
    """
    work = plan(seed, replications, quick)
    outcomes: list[Outcome] = []
    with (
        RowWriter(out / "recalls.csv", RecallRow) as recalls,
        RowWriter(out / "trainings.csv", TrainingRow) as trainings,
        RowWriter(out / "votes.csv", VoteRow) as votes,
    ):
        # Results come in the order of the work, so that the files are the same on any machine.
        running = Parallel(n_jobs=jobs, return_as="generator")(delayed(_run)(piece) for piece in work)
        for outcome in tqdm(
            running, total=len(work), desc="thesis", unit="piece", disable=not sys.stderr.isatty()
        ):
            recalls.write(*outcome.recalls)
            trainings.write(*outcome.trainings)
            votes.write(*outcome.votes)
            outcomes.append(outcome)
    return report(out, outcomes, seed)


def report(out: Path, outcomes: Sequence[Outcome], seed: int) -> Path:
    """Tables and figures of finished work."""
    rows = [row for outcome in outcomes for row in outcome.recalls]
    write_report(
        out,
        recalls=[r for r in rows if r.noise == LABORATORY and r.learner != TEACHER],
        trainings=[row for outcome in outcomes for row in outcome.trainings],
        teachers=[r for r in rows if r.learner == TEACHER],
        noise_rows=[r for r in rows if r.episodes == 10],
        vote_rows=[row for outcome in outcomes for row in outcome.votes],
        rng=np.random.default_rng(seed),
    )
    return out / PAGE


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of `khepera-forage reproduce` and `benchmarks/thesis.py`."""
    parser.add_argument(
        "--replications", type=int, default=None, help=f"of the whole design ({REPLICATIONS})"
    )
    parser.add_argument("--seed", type=int, default=0, help="the same seed gives the same rows (0)")
    parser.add_argument("--out", type=Path, default=Path("results/thesis"), help="folder (results/thesis)")
    parser.add_argument("--jobs", type=int, default=-1, help="processes; -1 is one a core (-1)")
    parser.add_argument("--quick", action="store_true", help="the same work in small, in under a minute")


def run(arguments: argparse.Namespace) -> int:
    """Do what the arguments ask for.

    Raises:
        ValueError: Fewer than one replication.
    """
    replications = arguments.replications
    if replications is None:
        replications = QUICK_REPLICATIONS if arguments.quick else REPLICATIONS
    if replications < 1:
        raise ValueError(f"--replications is {replications}; allowed: at least 1")
    page = reproduce(arguments.seed, replications, arguments.out, arguments.jobs, arguments.quick)
    print(page.read_text(encoding="utf-8"))
    print(f"Tables, figures and rows are in {arguments.out}")
    return 0


def _run(piece: Work) -> Outcome:
    return piece.run()
