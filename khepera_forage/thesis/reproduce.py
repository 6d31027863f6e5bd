"""All experiments of the thesis, in many replications and on all cores, and the report on them."""

import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

import numpy as np
from joblib import Parallel, delayed
from tqdm import tqdm

from khepera_forage.envs.arguments import checked_decisions
from khepera_forage.envs.backends import BACKENDS, COMPILED, PYMUNK
from khepera_forage.extras import require
from khepera_forage.rollouts.row_files import RowWriter
from khepera_forage.rollouts.rows import TEACHER, RecallRow, TrainingRow
from khepera_forage.rollouts.same_decisions import refuse_other_decisions
from khepera_forage.task.decisions import Decisions
from khepera_forage.thesis.design import LABORATORY
from khepera_forage.thesis.jobs import Job, comparison_counts, compiled_jobs, job_counts, pymunk_jobs
from khepera_forage.thesis.orient_analysis import OrientRow
from khepera_forage.thesis.replication import Outcome
from khepera_forage.thesis.report import PAGE, V0_1_RECALLS, write_report

REPLICATIONS = {PYMUNK: 24, COMPILED: 1000}
"""Default number of replications: on two cores, one to two minutes with the compiled backend, compilation included, and
about three minutes with pymunk."""
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
    comparison: bool = True,
) -> Path:
    """Run all experiments, write their rows and the report.

    Rows of different decisions are never in one file.

    Args:
        seed: The same seed gives the same rows on a backend, for any number of processes or threads.
        replications: Repetitions of the whole design.
        out: Folder for rows, tables, figures and the report.
        n_jobs: Processes with pymunk; -1 uses all cores. The compiled backend always uses all cores, with threads.
        quick: Run a small version of all experiments, in under a minute.
        backend: `pymunk`, one world at a time, or `compiled`, thousands of worlds at once.
        decisions: Of all experiments; the defaults by default.
        comparison: Also repeat the thesis's cells under the decisions of version 0.1, in a fifth of the replications,
            and show them beside the others. Without effect if `decisions` are those of version 0.1.

    Returns:
        The path of the report, a Markdown page.

    Raises:
        ValueError: An unknown backend, or a folder with rows of other decisions.
        ImportError: matplotlib is not installed, or the backend is `compiled` and numba is not.
    """
    if backend not in BACKENDS:
        raise ValueError(f"backend is {backend!r}; allowed: {', '.join(BACKENDS)}")
    if backend == COMPILED:
        require("this reproduction", "fast", "plots", otherwise=f"; backend {PYMUNK} needs no numba")
    else:
        require("this reproduction", "plots")
    counts = job_counts(replications, backend, quick)
    decisions = checked_decisions(decisions)
    v0_1 = Decisions.v0_1()
    comparison = comparison and decisions != v0_1
    make_jobs = pymunk_jobs if backend == PYMUNK else compiled_jobs
    jobs = make_jobs(seed, counts, decisions)
    paths = [out / name for name in ("recalls.csv", "trainings.csv", "orient.csv")]
    for path in paths:
        refuse_other_decisions(path, decisions)
    if comparison:
        refuse_other_decisions(out / V0_1_RECALLS, v0_1)
    outcomes: list[Outcome] = []
    with (
        RowWriter(paths[0], RecallRow) as recalls,
        RowWriter(paths[1], TrainingRow) as trainings,
        RowWriter(paths[2], OrientRow) as orient_rows,
    ):
        for outcome in _outcomes(jobs, "thesis", backend, n_jobs):
            recalls.write(*outcome.recalls)
            trainings.write(*outcome.trainings)
            orient_rows.write(*outcome.orient_rows)
            outcomes.append(outcome)
    v0_1_recalls: list[RecallRow] = []
    if comparison:
        # Only the recalls are compared, so the other rows are not kept.
        v0_1_jobs = make_jobs(seed, comparison_counts(replications), v0_1)
        with RowWriter(out / V0_1_RECALLS, RecallRow) as recalls:
            for outcome in _outcomes(v0_1_jobs, "version 0.1", backend, n_jobs):
                recalls.write(*outcome.recalls)
                v0_1_recalls += outcome.recalls
    return _report(out, outcomes, v0_1_recalls, seed, backend)


def _outcomes(jobs: Sequence[Job], name: str, backend: str, n_jobs: int) -> Iterator[Outcome]:
    """The outcomes of jobs in their order, so that the files are the same on every machine; with a progress bar."""
    finished: Iterable[Outcome] = map(_run, jobs)
    if backend == PYMUNK:
        finished = Parallel(n_jobs=n_jobs, return_as="generator")(delayed(_run)(job) for job in jobs)
    hide_progress = not sys.stderr.isatty()
    yield from tqdm(finished, total=len(jobs), desc=name, unit="job", disable=hide_progress)


def _report(
    out: Path, outcomes: Sequence[Outcome], v0_1_recalls: Sequence[RecallRow], seed: int, backend: str
) -> Path:
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
        v0_1_recalls=v0_1_recalls,
    )
    return out / PAGE


def _run(job: Job) -> Outcome:
    return job.run()
