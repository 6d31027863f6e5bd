"""Tables as Markdown or text, with intervals in brackets, and as CSV, with one number in each field."""

import csv
import io
import math
from collections.abc import Sequence
from dataclasses import dataclass

from khepera_forage.experiments.statistics import Estimate

Value = str | int | float | Estimate


@dataclass(frozen=True, slots=True)
class Column:
    """One column.

    Attributes:
        name: Heading with the unit.
        digits: Digits after the decimal point in Markdown; CSV always has six significant digits.
        estimate: Whether the values are estimates, each with an interval.
        page: Whether the column appears in Markdown; all columns appear in CSV.
    """

    name: str
    digits: int = 1
    estimate: bool = False
    page: bool = True


@dataclass(frozen=True, slots=True)
class Table:
    """A table with a heading and an explanation.

    Attributes:
        stem: Name of the table in file names.
        title: Heading.
        note: Explanation of the contents and their computation.
        columns: One for each value of a row.
        rows: Values; nan for a missing number.
    """

    stem: str
    title: str
    note: str
    columns: tuple[Column, ...]
    rows: Sequence[tuple[Value, ...]]

    def __post_init__(self) -> None:
        for row in self.rows:
            if len(row) != len(self.columns):
                raise ValueError(f"{self.stem}: a row has {len(row)} values; allowed: {len(self.columns)}")

    def markdown(self) -> str:
        """Heading, note and table in Markdown."""
        numeric, (heading, *rows) = self._page_lines()
        lines = [heading, ["---:" if right else "---" for right in numeric], *rows]
        body = "\n".join(f"| {' | '.join(cell.replace('|', '/') for cell in line)} |" for line in lines)
        return f"## {self.title}\n\n{self.note}\n\n{body}\n"

    def text(self) -> str:
        """Heading, note and table with aligned columns, for a terminal."""
        numeric, lines = self._page_lines()
        layout = [
            f"{'>' if right else '<'}{max(map(len, cells))}"
            for right, cells in zip(numeric, zip(*lines, strict=True), strict=True)
        ]
        body = "\n".join("  ".join(map(format, line, layout)).rstrip() for line in lines)
        return f"{self.title}\n\n{self.note}\n\n{body}\n"

    def _page_lines(self) -> tuple[list[bool], list[list[str]]]:
        """Which columns of the page are numbers, and its lines with the names of the columns first."""
        shown = [(i, column) for i, column in enumerate(self.columns) if column.page]
        numeric = [any(not isinstance(row[i], str) for row in self.rows) for i, _ in shown]
        lines = [[column.name for _, column in shown]]
        return numeric, lines + [[_shown(row[i], column) for i, column in shown] for row in self.rows]

    def csv(self) -> str:
        """The table as CSV; an estimate has three columns: value, low and high."""
        out = io.StringIO()
        writer = csv.writer(out, lineterminator="\n")
        names = [c.name for c in self.columns]
        writer.writerow(
            part
            for name, c in zip(names, self.columns, strict=True)
            for part in ((name, f"{name}: low", f"{name}: high") if c.estimate else (name,))
        )
        for row in self.rows:
            writer.writerow(part for value in row for part in _parts(value))
        return out.getvalue()


def interval(estimate: Estimate, digits: int = 1) -> str:
    """An estimate with its interval in brackets, if it has one."""
    value, low, high = (_number(v, digits) for v in estimate)
    return value if math.isnan(estimate.low) else f"{value} [{low}, {high}]"


def _shown(value: Value, column: Column) -> str:
    if isinstance(value, Estimate):
        return interval(value, column.digits)
    if isinstance(value, float):
        return _number(value, column.digits)
    return str(value)


def _number(value: float, digits: int) -> str:
    if math.isnan(value):
        return "-"
    return f"{value:.{digits}f}" if math.isfinite(value) else "∞"


def _parts(value: Value) -> tuple[str | int, ...]:
    if isinstance(value, Estimate):
        return tuple(part for v in value for part in _parts(v))
    if isinstance(value, float):
        return ("" if math.isnan(value) else f"{value:.6g}",)
    return (value,)
