"""Errata of the thesis: errors of arithmetic in tables A.1 to A.7, computed from the printed numbers."""

import math
from collections.abc import Iterator, Sequence
from decimal import ROUND_DOWN, ROUND_HALF_UP, Decimal
from fractions import Fraction
from itertools import groupby
from typing import NamedTuple

from khepera_forage.thesis import appendix_a
from khepera_forage.thesis.appendix_a import PrintedRecall, PrintedTable


class Erratum(NamedTuple):
    """A printed value that does not follow from the values printed beside it.

    Attributes:
        table: `A.1` to `A.7`.
        place: The line of the table, counted from 1, or the average.
        kind: `share`, `percent`, `rounding` (rounded, where the tables cut fractions off), `score`,
            `penalty`, `series`, `average`, `food` or `text`.
        printed: The value in the thesis.
        expected: The value that would follow.
    """

    table: str
    place: str
    kind: str
    printed: str
    expected: str


def errata() -> list[Erratum]:
    """All errata, in the order of the tables."""
    found: list[Erratum] = []
    for table in appendix_a.tables():
        rows = appendix_a.rows_of(table)
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
    run = [rows[0]]
    for row in (*rows[1:], None):
        last = run[-1]
        if (
            row is not None
            and (row.file_id, row.total, row.correct) == (last.file_id, last.total, last.correct + 1)
            and row.total < limit
        ):
            run.append(row)
            continue
        if len(run) > 1:
            printed = f"{run[0].correct} to {last.correct}, each of {last.total} ({last.percent}%)"
            place = f"lines {run[0].line}-{last.line}, {last.file_id}"
            yield Erratum(last.table, place, "series", printed, "a separate count for each line")
        run = [row] if row is not None else []


def _of_averages(table: PrintedTable, rows: Sequence[PrintedRecall]) -> Iterator[Erratum]:
    """Averages that differ from the printed scores, or between text and table."""
    scores = {name: [r.score for r in group] for name, group in groupby(rows, key=lambda r: r.file_id)}
    printed = [s for s in appendix_a.sets() if s.table == table.table]
    for entry in printed:
        mean = Fraction(sum(scores[entry.file_id]), len(scores[entry.file_id]))
        if not _rounds_to(mean, entry.average):
            yield Erratum(table.table, entry.file_id, "average", str(entry.average), f"{float(mean):g}")
    total = Fraction(sum(row.score for row in rows), len(rows))
    if not _rounds_to(total, table.average):
        yield Erratum(table.table, "total average", "average", str(table.average), f"{float(total):g}")
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
            yield Erratum(
                table.table, "food collected", kind, "{}/{}".format(*found), "{}/{}".format(*counted)
            )


def _rounds_to(value: Fraction, printed: Decimal) -> bool:
    """Whether a value equals the printed one after rounding or truncation to its number of decimals."""
    exact = Decimal(value.numerator) / Decimal(value.denominator)
    return any(exact.quantize(printed, rounding=how) == printed for how in (ROUND_DOWN, ROUND_HALF_UP))
