"""The main job: the whole design in replications, over all cores, and the report on it."""

import argparse
import sys
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from joblib import Parallel, delayed
from tqdm import tqdm

from khepera_forage.rollouts.row_files import RowWriter
from khepera_forage.rollouts.rows import TEACHER, RecallRow, TrainingRow
from khepera_forage.thesis.design import LABORATORY
from khepera_forage.thesis.orient_analysis import VoteRow
from khepera_forage.thesis.plan import BATCH, PYMUNK, Work, amounts, batch_plan, plan
from khepera_forage.thesis.replication import Outcome
from khepera_forage.thesis.report import PAGE, write_report

REPLICATIONS = {PYMUNK: 24, BATCH: 1000}
"""By default; some two minutes on two cores either way."""
QUICK_REPLICATIONS = 2


def reproduce(
    seed: int, replications: int, out: Path, jobs: int = -1, quick: bool = False, physics: str = PYMUNK
) -> Path:
    """Run everything and write the report.

    Args:
        seed: The same seed gives the same rows, whatever the number of processes or threads.
        replications: Of the whole design.
        out: Folder for rows, tables and figures.
        jobs: Processes with pymunk; -1 is one a core.
        quick: The same work in small, in under a minute.
        physics: `pymunk`, one world at a time, or `batch`, thousands of worlds at once.

    Returns:
        The report, a Markdown page.

    Raises:
        ValueError: Another kind of physics.
        ImportError: numba is not installed, for `batch`.
    """
    if physics not in REPLICATIONS:
        raise ValueError(f"physics is {physics!r}; allowed: {', '.join(REPLICATIONS)}")
    how_much = amounts(replications, physics, quick)
    work = plan(seed, how_much) if physics == PYMUNK else batch_plan(seed, how_much)
    outcomes: list[Outcome] = []
    with (
        RowWriter(out / "recalls.csv", RecallRow) as recalls,
        RowWriter(out / "trainings.csv", TrainingRow) as trainings,
        RowWriter(out / "votes.csv", VoteRow) as votes,
    ):
        # Results come in the order of the work, so that the files are the same on any machine. Batches are worked on
        # by all cores already.
        running = (
            Parallel(n_jobs=jobs, return_as="generator")(delayed(_run)(piece) for piece in work)
            if physics == PYMUNK
            else map(_run, work)
        )
        for outcome in tqdm(
            running, total=len(work), desc="thesis", unit="piece", disable=not sys.stderr.isatty()
        ):
            recalls.write(*outcome.recalls)
            trainings.write(*outcome.trainings)
            votes.write(*outcome.votes)
            outcomes.append(outcome)
    return report(out, outcomes, seed, physics)


def report(out: Path, outcomes: Sequence[Outcome], seed: int, physics: str = PYMUNK) -> Path:
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
        physics=physics,
    )
    return out / PAGE


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of `khepera-forage reproduce` and `benchmarks/thesis.py`."""
    parser.add_argument(
        "--physics",
        choices=list(REPLICATIONS),
        default=None,
        help="batch: thousands of worlds at once, needs numba; pymunk: one by one (batch if numba is there)",
    )
    parser.add_argument(
        "--replications",
        type=int,
        default=None,
        help=f"of the whole design ({REPLICATIONS[BATCH]} with batch, {REPLICATIONS[PYMUNK]} with pymunk)",
    )
    parser.add_argument("--seed", type=int, default=0, help="the same seed gives the same rows (0)")
    parser.add_argument("--out", type=Path, default=Path("results/thesis"), help="folder (results/thesis)")
    parser.add_argument("--jobs", type=int, default=-1, help="processes with pymunk; -1 is one a core (-1)")
    parser.add_argument("--quick", action="store_true", help="the same work in small, in under a minute")


def run(arguments: argparse.Namespace) -> int:
    """Do what the arguments ask for.

    Raises:
        ValueError: Fewer than one replication.
        ImportError: `--physics batch` without numba.
    """
    physics = arguments.physics or (BATCH if find_spec("numba") is not None else PYMUNK)
    replications = arguments.replications
    if replications is None:
        replications = QUICK_REPLICATIONS if arguments.quick else REPLICATIONS[physics]
    if replications < 1:
        raise ValueError(f"--replications is {replications}; allowed: at least 1")
    page = reproduce(arguments.seed, replications, arguments.out, arguments.jobs, arguments.quick, physics)
    print(page.read_text(encoding="utf-8"))
    print(f"Tables, figures and rows are in {arguments.out}")
    return 0


def _run(piece: Work) -> Outcome:
    return piece.run()
