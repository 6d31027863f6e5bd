"""Summary statistics of an experiment of the thesis's size, cell by cell: of our recalls, and of the thesis's lines."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.estimates import Floats, pick
from khepera_forage.rollouts.row_files import parse_rows
from khepera_forage.rollouts.rows import IMITATOR, RecallRow
from khepera_forage.thesis import appendix_a
from khepera_forage.thesis.appendix_a import PrintedRecall
from khepera_forage.thesis.design import FOODS, LABORATORY, THESIS, Cell
from khepera_forage.toml_table import naming, text_of


class CellSummary(NamedTuple):
    """One table of appendix A in numbers, one element an experiment; not a number where there is nothing to measure.

    Attributes:
        food: Share of the food that was brought home.
        right_failed: Mean share of correct steps in recalls that left food, percent.
        right_successful: The same for recalls that left none.
        steps_successful: Median steps of recalls that left none.
        spread: Standard deviation of the mean scores with each set of training files.
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
SLOPES = tuple(f"{arena} slope of {statistic}" for arena in FOODS for statistic in ("score", "food"))
"""From the fewest training episodes of an arena to the most."""
ALL = (*NAMES, *SLOPES)
"""All statistics, in their order."""
FITTED = tuple(name for name in ALL if name.startswith("corridor"))
"""Tables A.1 to A.4. The others are the test set."""


class CellRecalls(NamedTuple):
    """Recalls of a cell in some experiments; each array has the shape (experiments, sets of files, recalls).

    Attributes:
        delivered: Food objects brought home.
        penalty: For food that was left, percentage points.
    """

    correct: Floats
    steps: Floats
    delivered: Floats
    penalty: Floats

    def usable(self, limit: int) -> NDArray[np.bool_]:
        """Whether a line neither contradicts itself nor only counts up the line printed before it (see `errata`).

        A line contradicts itself if its steps are impossible under the limit, or do not agree with its penalty. Of
        lines that count up one by one in the same number of steps, as a spreadsheet fills down, the first is usable.
        """
        possible = (self.steps > 0) & (self.steps <= limit) & (self.correct <= self.steps)
        possible &= (self.penalty > 0) == (self.steps >= limit)
        same = np.diff(self.steps, axis=2) == 0
        counted = same & (np.diff(self.correct, axis=2) == 1) & (self.steps[:, :, 1:] < limit)
        possible[:, :, 1:] &= ~counted
        return np.asarray(possible)


def of_recalls(cell: Cell, recalls: CellRecalls) -> CellSummary:
    """The summary of recalls of a cell: food of all lines, everything else of the usable ones.

    Scores are computed as the thesis does: the percentage is cut off, and the penalty subtracted (5.4).
    """
    usable, failed = recalls.usable(cell.limit), recalls.penalty > 0
    right = 100.0 * recalls.correct / np.maximum(recalls.steps, 1.0)
    scores = np.floor(right) - recalls.penalty
    means = np.ma.filled(np.ma.masked_array(scores, ~usable).mean(axis=2), np.nan)
    steps = np.ma.median(_where(usable & ~failed, recalls.steps), axis=1)  # type: ignore[no-untyped-call]
    several = means.shape[1] > 1
    return CellSummary(
        _mean_where(usable, scores),
        recalls.delivered.mean(axis=(1, 2)) / cell.foods,
        _mean_where(usable & failed, right),
        _mean_where(usable & ~failed, right),
        np.ma.filled(steps, np.nan),
        means.std(axis=1, ddof=1) if several else np.full(len(means), np.nan),
    )


def _where(which: NDArray[np.bool_], values: Floats) -> Any:
    """Some values of each experiment, as a masked array."""
    return np.ma.masked_array(values, ~which).reshape(len(values), -1)


def _mean_where(which: NDArray[np.bool_], values: Floats) -> Floats:
    """Mean of some values of each experiment; not a number without any."""
    return np.asarray(np.ma.filled(_where(which, values).mean(axis=1), np.nan))


def printed_recalls(cell: Cell, lines: Sequence[PrintedRecall]) -> CellRecalls:
    """The printed lines of a cell, in the order of the table, as one experiment."""
    values = [(row.correct, row.total, row.delivered(cell.foods), row.points) for row in lines]
    shape = (1, len(cell.subsets), cell.recalls)
    return CellRecalls(*(np.array(column, dtype=np.float64).reshape(shape) for column in zip(*values, strict=True)))


def printed_lines(cell: Cell) -> tuple[PrintedRecall, ...]:
    """All lines of a table of the thesis."""
    return appendix_a.rows_of(appendix_a.table_of(cell.arena, cell.episodes))


def usable_lines(cell: Cell) -> list[PrintedRecall]:
    """The usable lines of a table of the thesis."""
    lines = printed_lines(cell)
    usable = printed_recalls(cell, lines).usable(cell.limit).ravel()
    return [line for line, use in zip(lines, usable, strict=True) if use]


def with_slopes(cells: Sequence[CellSummary]) -> Floats:
    """All statistics of experiments, shape (experiments, len(ALL)), of one summary for each cell of `THESIS`."""
    columns = [value for summary in cells for value in summary]
    for arena in FOODS:
        own = [summary for cell, summary in zip(THESIS, cells, strict=True) if cell.arena == arena]
        columns += [own[-1].score - own[0].score, own[-1].food - own[0].food]
    return np.stack(columns, axis=1)


def thesis_statistics() -> Floats:
    """All statistics of the thesis itself."""
    cells = [of_recalls(cell, printed_recalls(cell, printed_lines(cell))) for cell in THESIS]
    return np.asarray(with_slopes(cells)[0])


def fitted_columns() -> NDArray[np.intp]:
    """Places of the statistics that are fitted: those of tables A.1 to A.4 that the thesis has."""
    known = np.isfinite(thesis_statistics())
    return np.array([k for k, name in enumerate(ALL) if name in FITTED and known[k]], dtype=np.intp)


def tables_statistics(path: Path) -> Floats:
    """The fitted statistics of tables in a file.

    The file has the columns of `appendix_a.csv`, or it is `recalls.csv` of `khepera-forage reproduce`, of which the
    first replication under the laboratory's noise counts. The rectangle's tables are not needed.

    Raises:
        ValueError: Another form, or a table of the corridor without the thesis's number of recalls.
    """
    with naming(path):
        text = text_of(path)
    rows: list[Any] = []
    if text.startswith("table,"):
        rows = parse_rows(text, str(path), PrintedRecall)
        numbers = [(row.correct, row.total, row.delivered(1), row.points) for row in rows]
    else:
        rows = pick(parse_rows(text, str(path), RecallRow), learner=IMITATOR, noise=LABORATORY)
        rows = pick(rows, replication=rows[0].replication) if rows else []
        numbers = [(row.correct, row.steps, row.delivered, row.penalty) for row in rows]
    places = [(row.arena, row.episodes, row.file_id) for row in rows]
    cells = []
    for cell in THESIS:
        found = [
            [own for own, at in zip(numbers, places, strict=True) if at == (cell.arena, cell.episodes, subset.name)]
            for subset in cell.subsets
        ]
        if cell.arena == "corridor" and {len(own) for own in found} != {cell.recalls}:
            names = ", ".join(subset.name for subset in cell.subsets)
            raise ValueError(
                f"{path} has {[len(own) for own in found]} recalls after {cell.episodes} training episodes in the "
                f"corridor; allowed: {cell.recalls} each with {names}"
            )
        whole = np.array(found, dtype=np.float64) if cell.arena == "corridor" else np.ones((1, 1, 4))
        cells.append(of_recalls(cell, CellRecalls(*whole.transpose(2, 0, 1)[:, None])))
    return np.asarray(with_slopes(cells)[0][fitted_columns()])
