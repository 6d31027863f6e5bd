"""All experiments of the thesis, in many replications and on all cores, and the report on them."""

from functools import partial
from pathlib import Path

import numpy as np

from khepera_forage import __version__
from khepera_forage.envs.arguments import checked_decisions
from khepera_forage.envs.backends import BACKENDS, COMPILED, PYMUNK
from khepera_forage.extras import require
from khepera_forage.rollouts.rows import TEACHER, RecallRow, TrainingRow
from khepera_forage.rollouts.same_decisions import refuse_other_decisions
from khepera_forage.study import Arguments, Rows, Tables, collect, done, in_processes
from khepera_forage.task.decisions import Decisions, decisions_text
from khepera_forage.thesis.design import LABORATORY
from khepera_forage.thesis.jobs import JobCounts, comparison_counts, compiled_jobs, job_counts, pymunk_jobs
from khepera_forage.thesis.orient_analysis import OrientRow
from khepera_forage.thesis.report import PAGE, V0_1_RECALLS, write_report

REPLICATIONS = {PYMUNK: 24, COMPILED: 1000}
"""Default number of replications: on two cores, one to two minutes with the compiled backend, compilation included, and
about three minutes with pymunk."""
QUICK_REPLICATIONS = 2
TABLES = {RecallRow: "recalls", TrainingRow: "trainings", OrientRow: "orient"}
"""The rows, and the names of their files."""


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
    fresh: bool = False,
) -> Path:
    """Run all experiments, write their rows and the report.

    Rows of different decisions are never in one file. A run that was killed continues in the same folder.

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
        fresh: Do not continue a run that was killed in this folder.

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
    decisions = checked_decisions(decisions)
    v0_1 = Decisions.v0_1()
    comparison = comparison and decisions != v0_1
    for name in TABLES.values():
        refuse_other_decisions(out / f"{name}.csv", decisions)
    if comparison:
        refuse_other_decisions(out / V0_1_RECALLS, v0_1)
    given = Arguments(name="thesis", program="khepera-forage reproduce", out=out, jobs=n_jobs, fresh=fresh)
    given.settings = {"seed": str(seed), "quick": "yes" if quick else "no", "backend": backend}
    counts = job_counts(replications, backend, quick)
    rows = _rows(given, counts, decisions, backend, TABLES, "units")
    v0_1_rows = Rows(())
    if comparison:
        # Only the recalls are compared, so the other rows are not kept.
        tables = {RecallRow: V0_1_RECALLS.removesuffix(".csv")}
        v0_1_rows = _rows(given, comparison_counts(replications), v0_1, backend, tables, "units_v0.1")
    recalls = rows.of(RecallRow)
    write_report(
        out,
        recalls=[row for row in recalls if row.noise == LABORATORY and row.learner != TEACHER],
        trainings=rows.of(TrainingRow),
        teachers=[row for row in recalls if row.learner == TEACHER],
        noise_rows=[row for row in recalls if row.episodes == 10],
        orient_rows=rows.of(OrientRow),
        rng=np.random.default_rng(seed),
        backend=backend,
        v0_1_recalls=v0_1_rows.of(RecallRow),
    )
    for path in out.glob("units*.jsonl.gz"):
        path.unlink()  # the next run begins anew
    return out / PAGE


def _rows(
    given: Arguments, counts: JobCounts, decisions: Decisions, backend: str, tables: Tables, file: str
) -> Rows:
    """The rows of all jobs in their order; those of a run that was killed are taken from the folder."""
    make_jobs = pymunk_jobs if backend == PYMUNK else compiled_jobs
    units = make_jobs(int(given.settings["seed"]), counts, decisions)
    settings = {"decisions": decisions_text(decisions), "version": __version__}
    # Compiled jobs use all cores themselves.
    execute = in_processes(given.jobs) if backend == PYMUNK else partial(map, done)
    return collect(given, units, tables, execute, settings, file=f"{file}.jsonl.gz")
