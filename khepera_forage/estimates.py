"""Values with intervals: means and differences over replications, shares, quantiles, ranks; and tables of them.

Recalls of one replication share their training files and are not independent; replications are. The bootstrap
therefore resamples whole replications. Statistics are functions of sums over the rows of a replication, so that a
resample is one matrix product: `sums_by_replication` computes the sums, `bootstrap` resamples them.

Tables are Markdown or text, with intervals in brackets, and CSV, with one number in each field.
"""

import csv
import io
import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from textwrap import fill
from typing import Any, Generic, Literal, NamedTuple, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

RESAMPLES = 2000
COVERAGE = 0.95
MIN_REPLICATIONS = 5
"""Fewest replications for an interval: the range of four values contains the true median with a probability of only
88 %, the range of five values with 94 %."""


class Estimate(NamedTuple):
    """A value and its 95 % interval; nan where the data are not enough."""

    value: float
    low: float = math.nan
    high: float = math.nan

    def times(self, factor: float) -> "Estimate":
        """The same in another unit."""
        return Estimate(*(factor * number for number in self))


UNKNOWN = Estimate(math.nan)


class Replicated(Protocol):
    """A row that belongs to a replication."""

    @property
    def replication(self) -> int: ...  # noqa: D102


RowT = TypeVar("RowT", bound=Replicated)
T = TypeVar("T")


def replications(*groups: Iterable[Replicated]) -> list[int]:
    """The numbers of the replications in these rows, sorted."""
    return sorted({row.replication for rows in groups for row in rows})


def sums_by_replication(rows: Iterable[RowT], numbers: Sequence[int], *measures: Callable[[RowT], float]) -> Floats:
    """Sums over the rows of each replication: a line for each of the replications, and a column for each measure."""
    rows = list(rows)
    line = {number: i for i, number in enumerate(numbers)}
    lines = np.array([line[row.replication] for row in rows], dtype=np.intp)
    sums = [np.bincount(lines, [measure(row) for row in rows], len(numbers)) for measure in measures]
    return np.stack(sums, axis=1)


def contrast(*weights: float) -> Callable[[Floats], Floats]:
    """A weighted sum of ratios, each of two columns: `contrast(1, -1)` is the difference of two means.

    It is nan where a denominator is 0.
    """

    def statistic(sums: Floats) -> Floats:
        numerator, denominator = sums[..., 0::2], sums[..., 1::2]
        means = np.full(numerator.shape, np.nan)
        np.divide(numerator, denominator, out=means, where=denominator != 0)
        return np.asarray(means @ np.array(weights), dtype=np.float64)

    return statistic


ratio = contrast(1.0)
"""First column divided by the second, as a mean or a share."""


def bootstrap(
    sums: Floats,
    statistic: Callable[[Floats], Floats],
    rng: np.random.Generator,
    resamples: int = RESAMPLES,
    method: Literal["linear", "inverted_cdf"] = "linear",
) -> Estimate:
    """A statistic of all replications, with its percentile interval over resampled replications.

    Fewer than `MIN_REPLICATIONS` replications give a value without an interval. Resamples in which the statistic is
    undefined are ignored; if they are more than half, there is no interval either.

    Args:
        sums: From `sums_by_replication`.
        statistic: Takes sums (..., columns) and returns (...).
        rng: Draws the resamples.
        resamples: Their number.
        method: Of the percentiles, as in `numpy.quantile`.
    """
    count = len(sums)
    if not count:
        return UNKNOWN
    value = float(statistic(sums.sum(axis=0)))
    if count < MIN_REPLICATIONS or math.isnan(value):
        return Estimate(value)
    # How often each replication is drawn in each resample.
    drawn = rng.integers(count, size=(resamples, count)) + count * np.arange(resamples)[:, None]
    counts = np.bincount(drawn.ravel(), minlength=resamples * count).reshape(resamples, count)
    draws = statistic(counts.astype(np.float64) @ sums)
    defined = draws[~np.isnan(draws)]
    if 2 * len(defined) < len(draws):
        return Estimate(value)
    low, high = np.quantile(defined, [(1 - COVERAGE) / 2, (1 + COVERAGE) / 2], method=method)
    return Estimate(value, float(low), float(high))


def bootstrap_quantile(
    rows: Sequence[RowT],
    measure: Callable[[RowT], float],
    quantile: float,
    rng: np.random.Generator,
    resamples: int = RESAMPLES,
) -> Estimate:
    """A quantile of a measure over all rows, with its interval over resampled replications.

    The quantile is the smallest value that at least this share of the rows does not exceed. It may be infinite.
    """
    numbers = replications(rows)
    values = np.array([measure(row) for row in rows])
    order = np.argsort(values)
    owner = np.searchsorted(numbers, [rows[i].replication for i in order])

    def statistic(counts: Floats) -> Floats:
        shares = np.cumsum(counts[..., owner], axis=-1)
        reached = shares >= quantile * shares[..., -1:] - 1e-9
        return np.asarray(values[order][np.argmax(reached, axis=-1)], dtype=np.float64)

    return bootstrap(np.eye(len(numbers)), statistic, rng, resamples, "inverted_cdf")


def percentile_rank(value: float, experiments: Sequence[float]) -> tuple[float, float]:
    """The percentile of a value among comparable experiments, of which equal ones count half, and its tail.

    The tail is the two-sided probability that one more experiment is at least as extreme: twice the smaller tail, which
    includes the value itself, at most 1. Both are nan for fewer than two experiments.
    """
    count = len(experiments)
    if count < 2:
        return math.nan, math.nan
    sample = np.asarray(experiments, dtype=np.float64)
    equal = int(np.isclose(sample, value, rtol=0.0, atol=1e-9).sum())
    below = int((sample < value - 1e-9).sum())
    tail = 2.0 * (min(below, count - below - equal) + equal + 1) / (count + 1)
    return 100.0 * (below + equal / 2) / count, min(1.0, tail)


def wilson(successes: int, trials: int) -> Estimate:
    """A share with Wilson's 95 % score interval, for independent trials."""
    from scipy.stats import binomtest

    if trials == 0:
        return UNKNOWN
    test = binomtest(successes, trials)
    return Estimate(test.statistic, *map(float, test.proportion_ci(COVERAGE, "wilson")))


def holm(values: Sequence[float]) -> list[float]:
    """Each p-value corrected for the number of tests by Holm's rule: any is below 0.05 by chance in 5 % of all runs."""
    adjusted, highest = [0.0] * len(values), 0.0
    for rank, place in enumerate(sorted(range(len(values)), key=lambda k: values[k])):
        highest = max(highest, min(1.0, (len(values) - rank) * values[place]))
        adjusted[place] = highest
    return adjusted


Value = str | int | float | Estimate


@dataclass(frozen=True, slots=True)
class Column:
    """One column.

    Attributes:
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

    def text(self, width: int = 80) -> str:
        """Heading, note and table with aligned columns, for a terminal.

        Args:
            width: Of the terminal: words are cut at half of it, and the last columns that do not fit are left out.
        """
        numeric, lines = self._page_lines()
        most = width // 2
        lines = [
            [c if right or len(c) <= most else f"{c[: most - 1]}…" for c, right in zip(line, numeric, strict=True)]
            for line in lines
        ]
        widths = [max(map(len, cells)) for cells in zip(*lines, strict=True)]
        shown = len(widths)
        while shown > 1 and sum(widths[:shown]) + 2 * (shown - 1) > width:
            shown -= 1
        layout = [f"{'>' if r else '<'}{w}" for r, w in zip(numeric[:shown], widths, strict=False)]
        body = "\n".join("  ".join(map(format, line, layout)).rstrip() for line in lines)
        if len(layout) < len(widths):
            body += f"\n({len(widths) - len(layout)} more columns are in table_{self.stem}.csv)"
        return f"{self.title}\n\n{fill(self.note, width)}\n\n{body}\n"

    def _page_lines(self) -> tuple[list[bool], list[list[str]]]:
        """Which columns of the page are numbers, and its lines with the names of the columns first."""
        shown = [(i, column) for i, column in enumerate(self.columns) if column.page]
        numeric = [any(not isinstance(row[i], str) for row in self.rows) for i, _ in shown]
        lines = [[column.name for _, column in shown]]
        return numeric, lines + [[_shown(row[i], c.digits) for i, c in shown] for row in self.rows]

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


def table_of(
    stem: str,
    title: str,
    note: str,
    rows: Sequence[Mapping[str, Value]],
    digits: Mapping[str, int] | None = None,
    hidden: Collection[str] = (),
) -> Table:
    """A `Table` of rows that have the same columns, in the same order: values by the name of their column.

    Columns have one digit after the decimal point unless `digits` says otherwise; `hidden` ones appear in CSV alone.
    """
    columns = [
        Column(name, (digits or {}).get(name, 1), isinstance(value, Estimate), name not in hidden)
        for name, value in (rows[0] if rows else {}).items()
    ]
    return Table(stem, title, note, tuple(columns), [tuple(row.values()) for row in rows])


def _shown(value: Value, digits: int) -> str:
    """A value on a page; an estimate with its interval in brackets, if it has one."""
    if isinstance(value, Estimate):
        middle, low, high = (_number(v, digits) for v in value)
        return middle if math.isnan(value.low) else f"{middle} [{low}, {high}]"
    return _number(value, digits) if isinstance(value, float) else str(value)


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


class Sample(NamedTuple, Generic[T]):
    """Rows, and the ratio of two sums over them: by default a mean."""

    rows: Sequence[T]
    value: Callable[[T], float]
    weight: Callable[[T], float] = lambda _: 1.0

    @property
    def ratio(self) -> float:
        """The sum of the values divided by that of the weights; nan if that is 0."""
        weight = sum(map(self.weight, self.rows))
        return sum(map(self.value, self.rows)) / weight if weight else math.nan


class Measure(NamedTuple, Generic[T]):
    """A ratio of sums over rows: a mean, or a share."""

    name: str
    value: Callable[[T], float]
    weight: Callable[[T], float] = lambda _: 1.0
    digits: int = 1


def combined(
    terms: Sequence[tuple[float, Sample[Any]]], rng: np.random.Generator, resamples: int = RESAMPLES
) -> Estimate:
    """A weighted sum of means, with its interval over replications; unknown if one of them has no rows."""
    if not all(sample.rows for _, sample in terms):
        return UNKNOWN
    numbers = replications(*(sample.rows for _, sample in terms))
    sums = [sums_by_replication(sample.rows, numbers, sample.value, sample.weight) for _, sample in terms]
    return bootstrap(np.hstack(sums), contrast(*(weight for weight, _ in terms)), rng, resamples)


def mean(rows: Sequence[RowT], measure: Measure[RowT], rng: np.random.Generator) -> Estimate:
    """A measure with its interval."""
    return combined([(1.0, Sample(rows, *measure[1:3]))], rng)


def difference(
    rows: Sequence[RowT], others: Sequence[RowT], measure: Measure[RowT], rng: np.random.Generator
) -> Estimate:
    """How much greater a measure is in `rows` than in `others`."""
    return combined([(1.0, Sample(rows, *measure[1:3])), (-1.0, Sample(others, *measure[1:3]))], rng)


def pick(rows: Iterable[T], **fields: object) -> list[T]:
    """The rows whose fields have these values."""
    return [row for row in rows if all(getattr(row, name) == value for name, value in fields.items())]


def percent(part: int, whole: int) -> Estimate:
    """A share in percent with Wilson's 95 % interval; unknown of nothing."""
    return wilson(part, whole).times(100)


def quantiles(values: Sequence[float], low: float = 5, high: float = 95) -> Estimate:
    """Median and two percentiles; unknown without values."""
    return Estimate(*np.percentile(values, (50, low, high)).tolist()) if len(values) else UNKNOWN


def extremes(values: Sequence[float]) -> Estimate:
    """Median, lowest and highest value."""
    return quantiles(values, 0, 100)
