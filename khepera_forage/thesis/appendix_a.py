"""The thesis's results: tables A.1 to A.7 as printed, the same figures in chapter 5, and their errors of arithmetic.

The penalty is normalised: no penalty is a dash (A.5 prints nothing), and other penalties have no percent sign (A.7
prints one). All other values are verbatim.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from decimal import ROUND_DOWN, ROUND_HALF_UP, Decimal
from fractions import Fraction
from importlib import resources
from itertools import groupby
from typing import NamedTuple

from khepera_forage.rollouts.row_files import RowT, parse_rows

NO_PENALTY = "-"


@dataclass(frozen=True, slots=True)
class PrintedRecall:
    """One line of tables A.1 to A.7: a recall episode.

    Attributes:
        table: `A.1` to `A.7`.
        line: Number of the line in the table, from 1; not printed in the thesis.
        file_id: The experience files used, as the thesis names them.
        percent: Correct steps in percent, truncated to an integer.
        penalty: `-20`, `-5` or `-`.
    """

    table: str
    line: int
    arena: str
    episodes: int
    file_id: str
    correct: int
    total: int
    percent: int
    penalty: str
    score: int

    def __post_init__(self) -> None:
        if self.penalty not in (NO_PENALTY, "-5", "-20"):
            raise ValueError(f"penalty is {self.penalty!r}; allowed: -, -5 or -20")

    @property
    def points(self) -> int:
        """The penalty as a number: 0, 5 or 20 percentage points."""
        return 0 if self.penalty == NO_PENALTY else -int(self.penalty)

    def delivered(self, foods: int) -> int:
        """Food carried home, derived from the penalty: none at -20, all but one at -5, all without a penalty."""
        return {0: foods, 5: foods - 1, 20: 0}[self.points]


@dataclass(frozen=True, slots=True)
class PrintedSet:
    """The printed average of the recalls with one set of training files (A.4 and A.7 print none)."""

    table: str
    file_id: str
    average: Decimal


@dataclass(frozen=True, slots=True)
class PrintedTable:
    """The summary of one table, as printed below it and in the text of chapter 5.

    Attributes:
        table: `A.1` to `A.7`.
        average: "Total Average", in percent.
        collected: "Food Collected".
        available: Food objects in all recalls of the table.
        text_average: Mean score in the text; None if only the table has it.
    """

    table: str
    arena: str
    episodes: int
    foods: int
    limit: int
    average: Decimal
    collected: int
    available: int
    text_average: Decimal | None
    text_collected: int
    text_available: int


def _load(name: str, row_type: type[RowT]) -> tuple[RowT, ...]:
    text = resources.files(__package__).joinpath(name).read_text(encoding="utf-8")
    return tuple(parse_rows(text, name, row_type))


RECALLS = _load("appendix_a.csv", PrintedRecall)
"""Every recall episode of the thesis, in the order of the tables."""
SETS = _load("appendix_a_sets.csv", PrintedSet)
"""Every printed average over one set of training files."""
TABLES = _load("appendix_a_tables.csv", PrintedTable)
"""The summary of each table."""


def table_of(arena: str, episodes: int) -> PrintedTable:
    """The table of one cell of the design.

    Raises:
        KeyError: The thesis has no table for this cell.
    """
    cells = {(table.arena, table.episodes): table for table in TABLES}
    if (arena, episodes) not in cells:
        raise KeyError(f"no table for {arena!r} after {episodes!r} episodes; allowed: {list(cells)}")
    return cells[arena, episodes]


def rows_of(table: PrintedTable) -> tuple[PrintedRecall, ...]:
    """The recall episodes of one table."""
    return tuple(row for row in RECALLS if row.table == table.table)


def mean_score(table: PrintedTable) -> float:
    """Mean of the scores that the lines of a table print, in percent."""
    scores = [row.score for row in rows_of(table)]
    return sum(scores) / len(scores)


class Erratum(NamedTuple):
    """A printed value that does not follow from the values printed beside it.

    Attributes:
        table: `A.1` to `A.7`.
        place: The line of the table, counted from 1, or the average.
        kind: `share`, `percent`, `rounding` (rounded, where the tables cut fractions off), `score`,
            `penalty`, `series`, `average`, `food` or `text`.
    """

    table: str
    place: str
    kind: str
    printed: str
    expected: str


def errata() -> list[Erratum]:
    """All errata, in the order of the tables."""
    found: list[Erratum] = []
    for table in TABLES:
        rows = rows_of(table)
        for row in rows:
            place = f"line {row.line}, {row.file_id}"
            found += [Erratum(table.table, place, *erratum) for erratum in _of_row(row, table.limit)]
        found += _of_series(rows, table.limit)
        found += _of_averages(table, rows)
        found += _of_food(table, rows)
    return found


def _of_row(row: PrintedRecall, limit: int) -> Iterator[tuple[str, str, str]]:
    """Errata within one line: kind, printed and expected value."""
    possible = 0 < row.total <= limit and row.correct <= row.total
    share = f"{row.correct}/{row.total}"
    if not possible:
        yield "share", share, f"no more correct behaviours than steps, at most {limit} steps"
    percent = row.percent
    if possible:
        exact = Fraction(100 * row.correct, row.total)
        percent = math.floor(exact)
        if percent != row.percent:
            kind = "rounding" if row.percent == math.floor(exact + Fraction(1, 2)) else "percent"
            yield kind, f"{share} ({row.percent}%)", f"{percent}%"
    score = row.percent - row.points
    if row.score != score:
        expected = f"{score}"
        if percent != row.percent:
            agrees = "as printed" if row.score == percent - row.points else f"{percent - row.points}"
            expected += f"; with the percentage recomputed, {agrees}"
        yield "score", f"{row.percent}% {row.penalty}: {row.score}", expected
    if row.points and row.total < limit:
        yield "penalty", f"{row.penalty} after {row.total} steps", f"{limit} steps, or no penalty"
    if not row.points and row.total >= limit:
        yield "penalty", f"none after {row.total} steps", "a penalty, or food delivered in the very last step"


def _of_series(rows: Sequence[PrintedRecall], limit: int) -> Iterator[Erratum]:
    """Consecutive lines with the same total that count up by one, as a spreadsheet's fill-down produces them."""
    for (file_id, total, _), group in groupby(rows, lambda r: (r.file_id, r.total, r.correct - r.line)):
        run = list(group)
        first, last = run[0], run[-1]
        if first is not last and total < limit:
            printed = f"{first.correct} to {last.correct}, each of {total} ({last.percent}%)"
            place = f"lines {first.line}-{last.line}, {file_id}"
            yield Erratum(last.table, place, "series", printed, "a separate count for each line")


def _of_averages(table: PrintedTable, rows: Sequence[PrintedRecall]) -> Iterator[Erratum]:
    """Averages that differ from the printed scores, or between text and table."""
    scores = {name: [r.score for r in group] for name, group in groupby(rows, key=lambda r: r.file_id)}
    averages = {s.file_id: (s.average, scores[s.file_id]) for s in SETS if s.table == table.table}
    averages["total average"] = table.average, [row.score for row in rows]
    for place, (average, own) in averages.items():
        mean = Fraction(sum(own), len(own))
        if not _rounds_to(mean, average):
            yield Erratum(table.table, place, "average", str(average), f"{float(mean):g}")

    if table.text_average is not None and table.text_average != table.average:
        in_text, in_table = f"{table.text_average} in chapter 5", f"{table.average}, as in the table"
        yield Erratum(table.table, "total average", "text", in_text, in_table)


def _of_food(table: PrintedTable, rows: Sequence[PrintedRecall]) -> Iterator[Erratum]:
    """Food counts, in table and text, that differ from the penalties of the lines."""
    counted = (sum(row.delivered(table.foods) for row in rows), table.foods * len(rows))
    for kind, found in (
        ("food", (table.collected, table.available)),
        ("text", (table.text_collected, table.text_available)),
    ):
        if found != counted:
            yield Erratum(table.table, "food collected", kind, "{}/{}".format(*found), "{}/{}".format(*counted))


def _rounds_to(value: Fraction, printed: Decimal) -> bool:
    """Whether a value equals the printed one after rounding or truncation to its number of decimals."""
    exact = Decimal(value.numerator) / Decimal(value.denominator)
    return any(exact.quantize(printed, rounding=how) == printed for how in (ROUND_DOWN, ROUND_HALF_UP))
