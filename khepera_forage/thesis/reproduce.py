"""All experiments of the thesis, in many replications and on all cores, and the report on them."""

import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
from joblib import Parallel, delayed
from tqdm import tqdm

from khepera_forage.envs.arguments import checked_decisions
from khepera_forage.envs.backends import BACKENDS, COMPILED, PYMUNK
from khepera_forage.rollouts.row_files import RowWriter
from khepera_forage.rollouts.rows import TEACHER, RecallRow, TrainingRow
from khepera_forage.rollouts.same_decisions import refuse_other_decisions
from khepera_forage.task.decisions import Decisions
from khepera_forage.thesis.design import LABORATORY
from khepera_forage.thesis.jobs import Job, compiled_jobs, job_counts, pymunk_jobs
from khepera_forage.thesis.orient_analysis import OrientRow
from khepera_forage.thesis.replication import Outcome
from khepera_forage.thesis.report import PAGE, write_report

REPLICATIONS = {PYMUNK: 24, COMPILED: 1000}
"""Default number of replications: about two minutes on two cores with either backend."""
QUICK_REPLICATIONS = 2


def reproduce(
    seed: int,
    replications: int,
    out: Path,
    *,
    n_jobs: int = -1,
    quick: bool = False,
    backend: str = PYMUNK,
    decisions: Decisions | None = None,
) -> Path:
    """Run all experiments, write their rows and the report.

    Args:
        seed: The same seed gives the same rows on a backend, for any number of processes or threads.
        replications: Repetitions of the whole design.
        out: Folder for rows, tables, figures and the report.
        n_jobs: Processes with pymunk; -1 uses all cores. The compiled backend always uses all cores, with threads.
        quick: Run a small version of all experiments, in under a minute.
        backend: `pymunk`, one world at a time, or `compiled`, thousands of worlds at once.
        decisions: Of all experiments; the defaults by default.

    Returns:
        The path of the report, a Markdown page.

    Raises:
        ValueError: An unknown backend, or a folder with rows of other decisions.
        ImportError: The backend is `compiled`, and numba is not installed.
    """
    if backend not in BACKENDS:
        raise ValueError(f"backend is {backend!r}; allowed: {', '.join(BACKENDS)}")
    counts = job_counts(replications, backend, quick)
    decisions = checked_decisions(decisions)
    jobs = (pymunk_jobs if backend == PYMUNK else compiled_jobs)(seed, counts, decisions)
    paths = [out / name for name in ("recalls.csv", "trainings.csv", "orient.csv")]
    for path in paths:
        refuse_other_decisions(path, decisions)
    outcomes: list[Outcome] = []
    with (
        RowWriter(paths[0], RecallRow) as recalls,
        RowWriter(paths[1], TrainingRow) as trainings,
        RowWriter(paths[2], OrientRow) as orient_rows,
    ):
        # Both iterables keep the order of the jobs, so that the files are the same on every machine.
        finished: Iterable[Outcome] = map(_run, jobs)
        if backend == PYMUNK:
            finished = Parallel(n_jobs=n_jobs, return_as="generator")(delayed(_run)(job) for job in jobs)
        hide_progress = not sys.stderr.isatty()
        for outcome in tqdm(finished, total=len(jobs), desc="thesis", unit="job", disable=hide_progress):
            recalls.write(*outcome.recalls)
            trainings.write(*outcome.trainings)
            orient_rows.write(*outcome.orient_rows)
            outcomes.append(outcome)
    return _report(out, outcomes, seed, backend)


def _report(out: Path, outcomes: Sequence[Outcome], seed: int, backend: str) -> Path:
    """Write the report on the rows of all jobs."""
    recalls = [row for outcome in outcomes for row in outcome.recalls]
    write_report(
        out,
        recalls=[row for row in recalls if row.noise == LABORATORY and row.learner != TEACHER],
        trainings=[row for outcome in outcomes for row in outcome.trainings],
        teachers=[row for row in recalls if row.learner == TEACHER],
        noise_rows=[row for row in recalls if row.episodes == 10],
        orient_rows=[row for outcome in outcomes for row in outcome.orient_rows],
        rng=np.random.default_rng(seed),
        backend=backend,
    )
    return out / PAGE


def _run(job: Job) -> Outcome:
    return job.run()
