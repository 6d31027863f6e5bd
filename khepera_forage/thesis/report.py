"""The report of a reproduction: tables as CSV files, figures as PNG files, and a Markdown page with all of them."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from khepera_forage.estimates import MIN_REPLICATIONS, RESAMPLES, Table, replications
from khepera_forage.figures import save
from khepera_forage.files import NamingFile
from khepera_forage.rollouts.rows import RecallRow, TrainingRow
from khepera_forage.rollouts.same_decisions import common_decisions
from khepera_forage.task.decisions import Decisions, decisions_text, differences
from khepera_forage.thesis import figures, tables
from khepera_forage.thesis.cells import CellResult, cell_results
from khepera_forage.thesis.claims import claims
from khepera_forage.thesis.claims.evidence import Evidence, gather
from khepera_forage.thesis.design import THESIS, Cell
from khepera_forage.thesis.orient_analysis import OrientRow, orient_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAGE = "thesis.md"
SUMMARY = "summary.txt"
V0_1_RECALLS = "recalls_v0.1.csv"
"""File of the recalls under the decisions of version 0.1, which the reproduction writes."""


def write_report(
    folder: Path,
    recalls: Sequence[RecallRow],
    trainings: Sequence[TrainingRow],
    teachers: Sequence[RecallRow],
    noise_rows: Sequence[RecallRow],
    rng: np.random.Generator,
    cells: Sequence[Cell] = THESIS,
    resamples: int = RESAMPLES,
    orient_rows: Sequence[OrientRow] = (),
    backend: str = "pymunk",
    v0_1_recalls: Sequence[RecallRow] = (),
) -> list[Path]:
    """Write the page, the summary and the tables, then the figures.

    Args:
        folder: Created if it does not exist.
        recalls: Recalls of the imitator and of a random policy.
        trainings: Attempts at training episodes, under any noise conditions.
        teachers: Forages of the teacher alone.
        noise_rows: Recalls of the imitator in some cells, under each noise condition; may be empty.
        rng: Draws the resamples of every interval.
        cells: The design of the recalls.
        resamples: Resamples for each interval.
        orient_rows: The orient analysis, under the laboratory's noise; may be empty.
        backend: The backend that simulated the rows.
        v0_1_recalls: Recalls of the imitator in the same cells under the decisions of version 0.1, to show beside the
            others; may be empty.

    Returns:
        The files written.

    Raises:
        ValueError: The recalls of the imitator have several noise conditions, or the rows several decisions, or
            `v0_1_recalls` have others than version 0.1.
        ImportError: matplotlib, which draws the figures, is not installed; the tables are written.
    """
    common_decisions(recalls, trainings, teachers, noise_rows, orient_rows)
    v0_1_decisions = common_decisions(v0_1_recalls)
    if v0_1_recalls and v0_1_decisions != Decisions.v0_1():
        raise ValueError(
            f"v0_1_recalls have other decisions: {differences(v0_1_decisions, Decisions.v0_1())}; "
            "allowed: the decisions of version 0.1"
        )
    for_cells, for_claims, for_tables, for_orient, for_v0_1 = rng.spawn(5)
    evidence = gather(recalls, trainings, teachers, for_tables, resamples)
    results = cell_results(recalls, for_cells, cells, resamples)
    v0_1_results = cell_results(v0_1_recalls, for_v0_1, cells, resamples) if v0_1_recalls else []
    noise = tables.noise_table(noise_rows, evidence)
    measured = claims(recalls, trainings, teachers, for_claims, resamples)
    shown = [
        tables.cell_table(results, v0_1_results),
        tables.joint_table(results, recalls),
        tables.claim_table(measured),
        tables.rule_table(measured),
        noise,
        tables.training_table(evidence),
        tables.teacher_table(evidence),
        tables.ties_table(evidence),
        tables.state_table(evidence),
        orient_table(orient_rows, for_orient),
        tables.errata_table(),
    ]
    written = [_write(folder / PAGE, _page(shown, evidence, backend, v0_1_recalls))]
    summary = tables.summary_table(results, v0_1_results)
    written.append(_write(folder / SUMMARY, summary.text()))
    written += [_write(folder / f"table_{table.stem}.csv", table.csv()) for table in shown]
    for stem, figure in _figures(results, v0_1_results, recalls, noise):
        written.append(folder / f"{stem}.png")
        save(figure, written[-1])
    return written


def _figures(
    results: Sequence[CellResult],
    v0_1_results: Sequence[CellResult],
    recalls: Sequence[RecallRow],
    noise: Table,
) -> Iterator[tuple[str, "Figure"]]:
    yield "figure_5_2", figures.fig_5_2(results, v0_1_results)
    yield "figure_5_3", figures.fig_5_3(results, v0_1_results)
    yield "figure_5_4", figures.fig_5_4(recalls)
    yield "figure_5_5", figures.fig_5_5(results, v0_1_results)
    yield "figure_5_6", figures.fig_5_6(results, v0_1_results)
    if noise.rows:
        yield "noise", figures.noise_figure(noise)


def _page(
    tables: Sequence[Table], evidence: Evidence, backend: str, v0_1_recalls: Sequence[RecallRow]
) -> str:
    """The Markdown page; each figure follows the table with its numbers."""
    pictures = {
        "cells": ("figure_5_2", "figure_5_3", "figure_5_5", "figure_5_6"),
        "rules": ("figure_5_4",),
        "noise": ("noise",),
    }
    noise = ", ".join(sorted({row.noise for row in evidence.recalls})) or "none"
    decisions = decisions_text(evidence.decisions).replace(";", ", ")
    comparison = ""
    files = "`recalls.csv`, `trainings.csv` and `orient.csv`"
    if v0_1_recalls:
        comparison = f"For comparison: {_size(v0_1_recalls)}, decisions: {decisions_text(Decisions.v0_1())}. "
        files = f"`recalls.csv`, `{V0_1_RECALLS}`, `trainings.csv` and `orient.csv`"
    parts = [
        "# The thesis's experiments, repeated\n\n"
        f"{_size(evidence.recalls)}, noise: {noise}, decisions: {decisions}, backend: {backend}. {comparison}"
        "A replication repeats the whole design with new training files. "
        f"Intervals are bootstrapped over replications; fewer than {MIN_REPLICATIONS} replications give none. "
        f"{files} hold one row for each episode or measurement, and "
        "`table_*.csv` hold the tables of this page.\n"
    ]
    for table in tables:
        if table.rows:
            parts.append(table.markdown())
            parts += [f"![{name}]({name}.png)\n" for name in pictures.get(table.stem, ())]
    return "\n".join(parts)


def _size(recalls: Sequence[RecallRow]) -> str:
    count = len(replications(recalls))
    return f"{count} replication{'s' * (count != 1)}, {len(recalls)} recall episodes of the imitator"


def _write(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    with NamingFile(path):
        path.write_text(text, encoding="utf-8")
    return path
