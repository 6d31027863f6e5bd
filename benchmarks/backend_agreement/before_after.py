"""Results of `make reproduce` beside those of version 0.1, which had every stateful rule of the task twice."""

import csv
import math
from pathlib import Path
from typing import NamedTuple

from khepera_forage.envs.backends import COMPILED
from khepera_forage.estimates import Column, Estimate, Table
from khepera_forage.task.decisions import Decisions
from khepera_forage.thesis.reproduce import reproduce

BEFORE = Path(__file__).with_name("version_0_1_cells.csv")
"""`table_cells.csv` of `khepera-forage reproduce` at commit b91f85b: 1,000 replications, seed 0."""
MEASURES = {"ours: score (%)": "score (%)", "ours: food": "food"}
"""Columns of the table, and their names here."""


class Cell(NamedTuple):
    """One quantity of one table of appendix A, over all our replications.

    Attributes:
        arena: `corridor` or `rectangle`.
        episodes: Training episodes.
        measure: A value of `MEASURES`.
        value: Mean, with its interval over replications.
    """

    arena: str
    episodes: int
    measure: str
    value: Estimate


def cells_of(path: Path) -> list[Cell]:
    """The cells of a `table_cells.csv`."""
    with path.open(encoding="utf-8", newline="") as file:
        return [
            Cell(row["arena"], int(row["episodes"]), name, _estimate(row, column))
            for row in csv.DictReader(file)
            for column, name in MEASURES.items()
        ]


def reproduced(seed: int, replications: int, out: Path, quick: bool) -> list[Cell]:
    """The cells of a new run under the decisions of version 0.1, whose report is written to a folder."""
    page = reproduce(seed, replications, out, backend=COMPILED, quick=quick, decisions=Decisions.v0_1())
    return cells_of(page.with_name("table_cells.csv"))


def before_after_table(before: list[Cell], after: list[Cell], replications: int) -> Table:
    """Both side by side."""
    rows = []
    for old, new in zip(before, after, strict=True):
        assert old[:3] == new[:3]
        rows.append(
            (*old, new.value, _difference(old.value, new.value), _within(new, old), _within(old, new))
        )
    apart = sum(not row[5].low <= 0.0 <= row[5].high for row in rows)
    note = (
        "`khepera-forage reproduce --backend compiled` at version 0.1 (commit b91f85b, 1,000 replications, seed 0) and "
        f"now ({replications:,} replications). Food: objects carried home in an experiment of the thesis's size. "
        "Brackets: 95 % intervals over replications. Random numbers have changed, so both values vary: with no change "
        "in behaviour and equally many replications, a value lies within the other's interval with a probability of "
        "83 %, and the interval of the difference contains 0 with 95 %. "
        f"Differences whose interval does not contain 0: {apart} of {len(rows)}."
    )
    columns = (
        *map(Column, ("arena", "episodes", "measure")),
        *(Column(name, 2, estimate=True) for name in ("version 0.1", "now", "difference")),
        *map(Column, ("now within that of 0.1", "0.1 within that of now")),
    )
    return Table("before_after", "Results of `make reproduce` before and after", note, columns, rows)


def _difference(old: Estimate, new: Estimate) -> Estimate:
    """New minus old; the two are independent."""
    value = new.value - old.value
    low = math.hypot(new.value - new.low, old.high - old.value)
    high = math.hypot(new.high - new.value, old.value - old.low)
    return Estimate(value, value - low, value + high)


def _within(cell: Cell, other: Cell) -> str:
    return "yes" if other.value.low <= cell.value.value <= other.value.high else "no"


def _estimate(row: dict[str, str], column: str) -> Estimate:
    return Estimate(*(float(row[name]) for name in (column, f"{column}: low", f"{column}: high")))
