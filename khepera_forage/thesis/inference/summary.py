"""Summary statistics of an experiment of the thesis's size, cell by cell: of our recalls, and of the thesis's lines."""

import math
from collections.abc import Sequence
from itertools import groupby
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.thesis import appendix_a
from khepera_forage.thesis.appendix_a import PrintedRecall, PrintedTable
from khepera_forage.thesis.design import ARENAS, THESIS, Cell

Floats = NDArray[np.float64]


class CellSummary(NamedTuple):
    """One table of appendix A in numbers; of ours, each is an array with one element an experiment.

    Attributes:
        score: Mean score, percent.
        food: Share of the food that was brought home.
        right_failed: Mean share of correct steps in recalls that left food, percent. Not a number without any.
        right_successful: The same for recalls that left none.
        steps_successful: Median steps of recalls that left none. Not a number without any.
        spread: Standard deviation of the mean scores with each set of training files. Not a number with one set.
    """

    score: Floats
    food: Floats
    right_failed: Floats
    right_successful: Floats
    steps_successful: Floats
    spread: Floats


STATISTICS = CellSummary._fields
NAMES = tuple(f"{cell.arena} {cell.episodes} {statistic}" for cell in THESIS for statistic in STATISTICS)
"""Names of the statistics of all cells, in their order."""
SLOPES = tuple(f"{arena} slope of {statistic}" for arena in ARENAS for statistic in ("score", "food"))
"""From the fewest training episodes of an arena to the most."""
FITTED = tuple(name for name in (*NAMES, *SLOPES) if name.startswith("corridor"))
"""Tables A.1 to A.4. The others are the test set."""


class CellRecalls(NamedTuple):
    """Recalls of a cell in some experiments; each array has the shape (experiments, sets of files, recalls).

    Attributes:
        correct: Correct steps.
        steps: Steps.
        delivered: Food objects brought home.
        penalty: For food that was left, percentage points.
    """

    correct: Floats
    steps: Floats
    delivered: Floats
    penalty: Floats

    @property
    def right(self) -> Floats:
        """Share of correct steps, percent."""
        return 100.0 * self.correct / self.steps

    @property
    def score(self) -> Floats:
        """Scores as the thesis computes them: the percentage cut off, less the penalty (5.4)."""
        return np.asarray(np.floor(self.right) - self.penalty)


def of_recalls(cell: Cell, recalls: CellRecalls) -> CellSummary:
    """The summary of our recalls of a cell.

    Args:
        cell: The cell.
        recalls: Of one or several experiments.
    """
    failed = recalls.penalty > 0
    scores = recalls.score
    return CellSummary(
        scores.mean(axis=(1, 2)),
        recalls.delivered.mean(axis=(1, 2)) / cell.foods,
        _mean_where(failed, recalls.right),
        _mean_where(~failed, recalls.right),
        _median_where(~failed, recalls.steps),
        scores.mean(axis=2).std(axis=1, ddof=1) if scores.shape[1] > 1 else np.full(len(scores), np.nan),
    )


def of_thesis(cell: Cell) -> CellSummary:
    """The summary of one table of the thesis; each field has one element.

    Food is counted in all lines. The other statistics leave out lines that contradict themselves or were filled down
    (`errata`).
    """
    table, rows = appendix_a.table_of(cell.arena, cell.episodes), usable_lines(cell)
    right = np.array([100.0 * row.correct / row.total for row in rows])
    failed = np.array([row.points > 0 for row in rows])
    steps = np.array([float(row.total) for row in rows])
    sets = [list(group) for _, group in groupby(rows, key=lambda row: row.file_id)]
    means = [np.mean([_score(row) for row in group]) for group in sets]
    return CellSummary(
        np.array([np.mean([_score(row) for row in rows])]),
        np.array([table.collected / table.available]),
        _mean_where(failed[None], right[None]),
        _mean_where(~failed[None], right[None]),
        _median_where(~failed[None], steps[None]),
        np.array([np.std(means, ddof=1) if len(means) > 1 else np.nan]),
    )


def usable_lines(cell: Cell) -> list[PrintedRecall]:
    """The lines of a table that do not contradict themselves and were not filled down."""
    rows = appendix_a.rows_of(appendix_a.table_of(cell.arena, cell.episodes))
    return [rows[place] for place in usable_places(cell)]


def usable_places(cell: Cell) -> list[int]:
    """Places of these lines in their table, from 0."""
    table = appendix_a.table_of(cell.arena, cell.episodes)
    rows = appendix_a.rows_of(table)
    possible = [place for place, row in enumerate(rows) if _is_possible(row, table)]
    pairs = zip([None, *possible], possible, strict=False)
    return [place for before, place in pairs if before is None or not _counts_on(rows[before], rows[place])]


def with_slopes(cells: Sequence[CellSummary]) -> Floats:
    """All statistics of experiments: shape (experiments, len(NAMES) + len(SLOPES)).

    Args:
        cells: One summary for each cell of `THESIS`, in order.
    """
    columns = [value for summary in cells for value in summary]
    for arena in ARENAS:
        own = [summary for cell, summary in zip(THESIS, cells, strict=True) if cell.arena == arena]
        columns += [own[-1].score - own[0].score, own[-1].food - own[0].food]
    return np.stack(columns, axis=1)


def thesis_statistics() -> Floats:
    """Those of the thesis itself, in the order of `NAMES` and `SLOPES`."""
    statistics: Floats = with_slopes([of_thesis(cell) for cell in THESIS])[0]
    return statistics


def _score(row: PrintedRecall) -> int:
    """The score of a line, computed again from its steps."""
    return math.floor(100 * row.correct / row.total) - row.points


def _is_possible(row: PrintedRecall, table: PrintedTable) -> bool:
    """Whether the steps of a line are possible and agree with its penalty."""
    whole = 0 < row.total <= table.limit and row.correct <= row.total
    return whole and (row.points > 0) == (row.total >= table.limit)


def _counts_on(before: PrintedRecall, row: PrintedRecall) -> bool:
    """Whether a line only counts the line before up by one, as filling down in a spreadsheet does."""
    return (row.file_id, row.total, row.correct) == (before.file_id, before.total, before.correct + 1)


def _mean_where(which: NDArray[np.bool_], values: Floats) -> Floats:
    """Mean of some values of each experiment; not a number without any."""
    which, values = which.reshape(len(which), -1), values.reshape(len(values), -1)
    count = which.sum(axis=1)
    return np.where(count > 0, (values * which).sum(axis=1) / np.maximum(count, 1), np.nan)


def _median_where(which: NDArray[np.bool_], values: Floats) -> Floats:
    """Median of some values of each experiment; not a number without any."""
    pairs = zip(which.reshape(len(which), -1), values.reshape(len(values), -1), strict=True)
    return np.array([np.median(row[chosen]) if chosen.any() else np.nan for chosen, row in pairs])
