"""Values with intervals for tables: means and differences over replications, shares, quantiles."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Generic, NamedTuple, TypeVar

import numpy as np

from khepera_forage.experiments.statistics import (
    UNKNOWN,
    Estimate,
    bootstrap,
    contrast,
    replications,
    sums_by_replication,
    wilson,
)
from khepera_forage.experiments.tables import Column, Table, Value

RowT = TypeVar("RowT")


class Measure(NamedTuple, Generic[RowT]):
    """A ratio of sums over rows: a mean, or a share.

    Attributes:
        name: With its unit.
        value: Of a row.
        weight: Of a row; the measure is the sum of the values divided by the sum of the weights.
        digits: Shown after the decimal point.
    """

    name: str
    value: Callable[[RowT], float]
    weight: Callable[[RowT], float] = lambda _: 1.0
    digits: int = 1


def combined(
    groups: Sequence[tuple[float, Sequence[Any]]], measure: Measure[Any], rng: np.random.Generator
) -> Estimate:
    """A weighted sum of a measure over groups of rows, with its interval over replications.

    Args:
        groups: Weight and rows of each; the result is unknown if a group has no rows.
        measure: What is summed.
        rng: Draws the resamples.
    """
    if not all(rows for _, rows in groups):
        return UNKNOWN
    numbers = replications(*(rows for _, rows in groups))
    sums = np.hstack(
        [sums_by_replication(rows, numbers, measure.value, measure.weight) for _, rows in groups]
    )
    return bootstrap(sums, contrast(*(weight for weight, _ in groups)), rng)


def mean(rows: Sequence[RowT], measure: Measure[RowT], rng: np.random.Generator) -> Estimate:
    """A measure with its interval."""
    return combined([(1.0, rows)], measure, rng)


def difference(
    rows: Sequence[RowT], others: Sequence[RowT], measure: Measure[RowT], rng: np.random.Generator
) -> Estimate:
    """How much greater a measure is in `rows` than in `others`."""
    return combined([(1.0, rows), (-1.0, others)], measure, rng)


def pick(rows: Iterable[RowT], **fields: object) -> list[RowT]:
    """The rows whose fields have these values."""
    return [row for row in rows if all(getattr(row, name) == value for name, value in fields.items())]


def means_table(
    stem: str,
    title: str,
    note: str,
    by: Mapping[str, str],
    rows: Sequence[RowT],
    measures: Sequence[Measure[RowT]],
    rng: np.random.Generator,
) -> Table:
    """Several measures for every combination of fields that occurs.

    Args:
        stem: Name in file names.
        title: Heading.
        note: What the table shows.
        by: Fields, and the headings of their columns. Numbers are sorted, text keeps the order of the rows.
        rows: All rows.
        measures: One a column.
        rng: Draws the resamples.
    """
    places = {name: _order(getattr(row, name) for row in rows) for name in by}
    groups: dict[tuple[Any, ...], list[RowT]] = {}
    for row in rows:
        groups.setdefault(tuple(getattr(row, name) for name in by), []).append(row)
    lines: list[tuple[Value, ...]] = [
        (*key, len(own), *(mean(own, measure, rng) for measure in measures))
        for key, own in sorted(
            groups.items(), key=lambda item: [places[n][v] for n, v in zip(by, item[0], strict=True)]
        )
    ]
    columns = [*map(Column, by.values()), Column("rows")]
    columns += [Column(measure.name, measure.digits, estimate=True) for measure in measures]
    return Table(stem, title, note, tuple(columns), lines)


def percent(part: int, whole: int) -> Estimate:
    """A share in percent with Wilson's 95 % interval; unknown of nothing."""
    return Estimate(*(100 * value for value in wilson(part, whole)))


def quantiles(values: Sequence[float], low: float = 5, high: float = 95) -> Estimate:
    """Median and two percentiles; unknown without values."""
    if not len(values):
        return UNKNOWN
    lower, median, upper = np.percentile(values, (low, 50, high)).tolist()
    return Estimate(median, lower, upper)


def extremes(values: Sequence[float]) -> Estimate:
    """Median, lowest and highest value."""
    return quantiles(values, 0, 100)


def plain(value: float) -> Estimate:
    """A value without an interval."""
    return Estimate(value, math.nan, math.nan)


def _order(values: Iterable[Any]) -> dict[Any, int]:
    """The place of every value that occurs."""
    distinct = list(dict.fromkeys(values))
    if not any(isinstance(value, str) for value in distinct):
        distinct.sort()
    return {value: place for place, value in enumerate(distinct)}
