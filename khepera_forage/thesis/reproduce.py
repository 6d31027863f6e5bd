"""All experiments of the thesis, in many replications and on all cores, and the report on them."""

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from khepera_forage.envs.backends import COMPILED, PYMUNK
from khepera_forage.estimates import MIN_REPLICATIONS, RESAMPLES, Table, pick, replications
from khepera_forage.extras import require
from khepera_forage.rollouts.rows import RecallRow, TrainingRow, refuse_other_decisions
from khepera_forage.study import Arguments, Page, Picture, Rows, Tables, collect, done, in_processes, write, write_text
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions, decisions_text
from khepera_forage.thesis import figures, tables
from khepera_forage.thesis.claims import Evidence, claims, gather
from khepera_forage.thesis.design import LABORATORY
from khepera_forage.thesis.orient_analysis import OrientRow, orient_table
from khepera_forage.thesis.replication import JobCounts, UntrainedRow, comparison_counts, job_counts, jobs

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAGE = "thesis.md"
SUMMARY = "summary.txt"
V0_1_RECALLS = "recalls_v0.1.csv"
"""File of the recalls under the decisions of version 0.1, which the reproduction writes."""
REPLICATIONS = {PYMUNK: 24, COMPILED: 1000}
"""Default number of replications: on two idle cores, 80 s with the compiled backend, compilation included, and about
three minutes with pymunk."""
QUICK_REPLICATIONS = 2
TABLES = {RecallRow: "recalls", TrainingRow: "trainings", OrientRow: "orient", UntrainedRow: "untrained"}
"""The rows, and the names of their files."""


def reproduce(
    seed: int,
    replications: int,
    out: Path,
    *,
    n_jobs: int = -1,
    quick: bool = False,
    backend: str = PYMUNK,
    decisions: Decisions = DEFAULT_DECISIONS,
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
        quick: Run a small version of all experiments.
        backend: `pymunk`, one world at a time, or `compiled`, thousands of worlds at once.
        decisions: Of all experiments.
        comparison: Also repeat the thesis's cells under the decisions of version 0.1, in a fifth of the replications.
            Without effect if `decisions` are those of version 0.1.
        fresh: Do not continue a run that was killed in this folder.

    Returns:
        The path of the report, a Markdown page.

    Raises:
        ValueError: A folder with rows of other decisions.
        IncompleteTrainingError: No attempt at a training episode under the laboratory's noise was complete.
        ImportError: matplotlib is not installed, or the backend is `compiled` and numba is not.
    """
    if backend == COMPILED:
        require("this reproduction", "fast", "plots", otherwise=f"; backend {PYMUNK} needs no numba")
    else:
        require("this reproduction", "plots")
    v0_1 = Decisions.v0_1()
    comparison = comparison and decisions != v0_1
    for name in TABLES.values():
        refuse_other_decisions(out / f"{name}.csv", decisions)
    if comparison:
        refuse_other_decisions(out / V0_1_RECALLS, v0_1)
    given = Arguments(name="thesis", program="khepera-forage reproduce", seed=seed, out=out, jobs=n_jobs, fresh=fresh)
    given.settings = {"seed": str(seed), "quick": "yes" if quick else "no", "backend": backend}
    counts = job_counts(replications, backend, quick)
    rows = _rows(given, counts, decisions, backend, TABLES, "units")
    v0_1_rows = Rows(())
    if comparison:
        # Only the recalls are compared, so the other rows are not kept.
        tables = {RecallRow: V0_1_RECALLS.removesuffix(".csv")}
        v0_1_rows = _rows(given, comparison_counts(replications), v0_1, backend, tables, "units_v0.1")
    write_report(out, rows, np.random.default_rng(seed), backend=backend, v0_1_recalls=v0_1_rows.of(RecallRow))
    for path in out.glob("units*.jsonl.gz"):
        path.unlink()  # the next run starts from nothing
    return out / PAGE


def _rows(given: Arguments, counts: JobCounts, decisions: Decisions, backend: str, tables: Tables, file: str) -> Rows:
    """The rows of all jobs in their order; those of a run that was killed are taken from the folder."""
    units = jobs(given.seed, counts, decisions, backend)
    settings = {"decisions": decisions_text(decisions)}
    # Compiled jobs use all cores themselves.
    execute = in_processes(given.jobs) if backend == PYMUNK else partial(map, done)
    return collect(given, units, tables, execute, settings, file=f"{file}.jsonl.gz")


def write_report(
    folder: Path,
    rows: Rows,
    rng: np.random.Generator,
    *,
    resamples: int = RESAMPLES,
    backend: str = PYMUNK,
    v0_1_recalls: Sequence[RecallRow] = (),
) -> None:
    """Write the page, the summary, the tables and the figures.

    The rows are of all kinds, under any noise conditions; the laboratory's recalls are compared with the thesis.
    `v0_1_recalls` are those of the imitator in the same cells under the decisions of version 0.1.
    """
    everything, trainings, orient_rows = rows.of(RecallRow), rows.of(TrainingRow), rows.of(OrientRow)
    untrained, recalls = rows.of(UntrainedRow), pick(everything, noise=LABORATORY)
    compared = untrained or len(recalls) < len(everything)
    for_cells, for_claims, for_tables, for_orient, for_v0_1 = rng.spawn(5)
    evidence = gather(recalls, trainings, for_tables, resamples)
    results = tables.cell_results(recalls, for_cells, resamples)
    old = tables.cell_results(v0_1_recalls, for_v0_1, resamples) if v0_1_recalls else []
    noise = tables.noise_table(pick(everything, episodes=10) if compared else (), evidence, untrained)
    measured = claims(replace(evidence, rng=for_claims))
    parts: list[str | Table | Picture] = [
        _introduction(evidence, backend, v0_1_recalls),
        tables.cell_table(results, old),
        *(
            _picture(f"figure_5_{kind[0]}", figures.figure_by_episodes(*kind, results, old))
            for kind in figures.BY_EPISODES
        ),
        tables.joint_table(results, recalls),
        tables.claim_table(measured),
        tables.rule_table(measured),
        _picture("figure_5_4", figures.fig_5_4(recalls)),
        noise,
        *([_picture("noise", figures.noise_figure(noise))] if noise.rows else []),
        tables.training_table(evidence),
        tables.teacher_table(evidence),
        tables.ties_table(evidence),
        tables.state_table(evidence),
        orient_table(orient_rows, for_orient),
        tables.errata_table(),
    ]
    empty = [part for part in parts if isinstance(part, Table) and not part.rows]
    shown = [part for part in parts if part not in empty]
    write(folder, Path(PAGE).stem, Page("The thesis's experiments, repeated", shown, empty))
    write_text(folder / SUMMARY, tables.summary_table(results, old).text())


def _picture(name: str, figure: "Figure") -> Picture:
    return Picture(name, name, figure)


def _introduction(evidence: Evidence, backend: str, v0_1_recalls: Sequence[RecallRow]) -> str:
    noise = ", ".join(sorted({row.noise for row in evidence.recalls})) or "none"
    decisions = decisions_text(evidence.decisions).replace(";", ", ")
    comparison, files = "", "`recalls.csv`, `trainings.csv` and `orient.csv`"
    if v0_1_recalls:
        comparison = f"For comparison: {_size(v0_1_recalls)}, decisions: {decisions_text(Decisions.v0_1())}. "
        files = f"`recalls.csv`, `{V0_1_RECALLS}`, `trainings.csv` and `orient.csv`"
    return (
        f"{_size(evidence.recalls)}, noise: {noise}, decisions: {decisions}, backend: {backend}. {comparison}"
        "A replication repeats the whole design with new training files. "
        f"Intervals are bootstrapped over replications; fewer than {MIN_REPLICATIONS} replications give none. "
        f"{files} hold one row for each episode or measurement, and `table_*.csv` hold the tables of this page."
    )


def _size(recalls: Sequence[RecallRow]) -> str:
    count = len(replications(recalls))
    return f"{count} replication{'s' * (count != 1)}, {len(recalls)} recall episodes of the imitator"
