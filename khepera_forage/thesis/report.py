"""Writes everything that a reproduction concludes: tables as CSV, figures as PNG, and a page of Markdown."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from khepera_forage.rollouts.rows import RecallRow, TrainingRow
from khepera_forage.thesis import figures, measured_tables, thesis_tables
from khepera_forage.thesis.cells import CellResult, cell_results
from khepera_forage.thesis.claims import claims
from khepera_forage.thesis.claims.evidence import Evidence, gather
from khepera_forage.thesis.design import THESIS, Cell
from khepera_forage.thesis.figure_places import fig_5_4
from khepera_forage.thesis.orient_analysis import VoteRow, vote_table
from khepera_forage.thesis.statistics import FEWEST, RESAMPLES, replications
from khepera_forage.thesis.tables import Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

PAGE = "thesis.md"


def write_report(
    folder: Path,
    recalls: Sequence[RecallRow],
    trainings: Sequence[TrainingRow],
    teachers: Sequence[RecallRow],
    noise_rows: Sequence[RecallRow],
    rng: np.random.Generator,
    cells: Sequence[Cell] = THESIS,
    resamples: int = RESAMPLES,
    vote_rows: Sequence[VoteRow] = (),
    physics: str = "pymunk",
) -> list[Path]:
    """Write tables, then figures, and the page that holds them together.

    Args:
        folder: Where to; it is made.
        recalls: The imitator's and a random policy's.
        trainings: Attempts at training episodes, under any noise conditions.
        teachers: Forages of the teacher alone.
        noise_rows: The imitator's in one cell, under each noise condition; may be empty.
        rng: Draws the resamples of every interval.
        cells: The design that was run.
        resamples: How many an interval.
        vote_rows: What votes next to food, under the laboratory's noise; may be empty.
        physics: What simulated the rows.

    Returns:
        The files written.

    Raises:
        ValueError: The imitator's recalls are of several noise conditions.
        ImportError: The tables are written, but there is no matplotlib for the figures.
    """
    for_cells, for_claims, for_tables, for_votes = rng.spawn(4)
    evidence = gather(recalls, trainings, teachers, for_tables, resamples)
    results = cell_results(recalls, for_cells, cells, resamples)
    noise = measured_tables.noise_table(noise_rows, evidence)
    judged = claims(recalls, trainings, teachers, for_claims, resamples)
    tables = [
        thesis_tables.cell_table(results),
        thesis_tables.claim_table(judged),
        thesis_tables.rule_table(judged),
        noise,
        measured_tables.training_table(evidence),
        measured_tables.teacher_table(evidence),
        measured_tables.ties_table(evidence),
        measured_tables.state_table(evidence),
        vote_table(vote_rows, for_votes),
        thesis_tables.slip_table(),
    ]
    written = [_write(folder / PAGE, _page(tables, evidence, physics))]
    written += [_write(folder / f"table_{table.stem}.csv", table.csv()) for table in tables]
    for stem, figure in _figures(results, recalls, noise):
        written.append(folder / f"{stem}.png")
        figures.save(figure, written[-1])
    return written


def _figures(
    results: Sequence[CellResult], recalls: Sequence[RecallRow], noise: Table
) -> Iterator[tuple[str, "Figure"]]:
    yield "figure_5_2", figures.fig_5_2(results)
    yield "figure_5_3", figures.fig_5_3(results)
    yield "figure_5_4", fig_5_4(recalls)
    yield "figure_5_5", figures.fig_5_5(results)
    yield "figure_5_6", figures.fig_5_6(results)
    if noise.rows:
        yield "noise", figures.noise_figure(noise)


def _page(tables: Sequence[Table], evidence: Evidence, physics: str) -> str:
    """The page: figures stand behind the table they belong to."""
    pictures = {
        "cells": ("figure_5_2", "figure_5_3", "figure_5_5", "figure_5_6"),
        "rules": ("figure_5_4",),
        "noise": ("noise",),
    }
    count = len(replications(evidence.recalls))
    noise = ", ".join(sorted({row.noise for row in evidence.recalls})) or "none"
    parts = [
        "# The thesis' experiments, repeated\n\n"
        f"{count} replication{'s' * (count != 1)}, {len(evidence.recalls)} recall episodes of the imitator, "
        f"noise: {noise}, physics: {physics}. A replication is the whole design, its training files included; an "
        f"interval resamples replications, and there is none for fewer than {FEWEST}. Every episode stands "
        "as a row in the CSV files beside this page, and every table as `table_*.csv`.\n"
    ]
    for table in tables:
        if table.rows:
            parts.append(table.markdown())
            parts += [f"![{name}]({name}.png)\n" for name in pictures.get(table.stem, ())]
    return "\n".join(parts)


def _write(path: Path, text: str) -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return path
