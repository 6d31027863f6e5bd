"""Means with their intervals over replications, differences of means, and tables of them."""

from collections.abc import Callable, Iterable, Sequence
from typing import Generic, NamedTuple, TypeVar

import numpy as np

from _further_work.rows import Lesson, Recalled
from khepera_forage.thesis.statistics import (
    UNKNOWN,
    Estimate,
    bootstrap,
    contrast,
    replications,
    tally,
)
from khepera_forage.thesis.tables import Column, Table, Value

RowT = TypeVar("RowT", Lesson, Recalled)


class Measure(NamedTuple, Generic[RowT]):
    """Something that has a mean.

    Attributes:
        name: With its unit.
        value: Of a row.
        weight: Of a row; the mean is the sum of the values by the sum of the weights.
        digits: Shown after the decimal point.
    """

    name: str
    value: Callable[[RowT], float]
    weight: Callable[[RowT], float] = lambda _: 1.0
    digits: int = 1


SCORE = Measure[Recalled]("score (%)", lambda row: row.score)
AGREEMENT = Measure[Recalled]("steps as the teacher (%)", lambda row: 100 * row.correct / row.steps)
DELIVERED = Measure[Recalled](
    "food delivered (%)", lambda row: 100 * row.delivered, lambda row: float(row.foods)
)
SETTLED = Measure[Recalled](
    "food settled (%)", lambda row: 100 * (row.delivered + row.avoided), lambda row: float(row.foods)
)
POISON_HOME = Measure[Recalled](
    "poison brought home (%)", lambda row: 100 * row.poison_home, lambda row: float(row.foods)
)
STEPS = Measure[Recalled]("steps", lambda row: float(row.steps), digits=0)
VECTORS = Measure[Recalled]("experience vectors", lambda row: float(row.vectors), digits=0)
DISTINCT = Measure[Recalled]("different experience vectors", lambda row: float(row.distinct), digits=0)
ATTEMPTS = Measure[Lesson]("attempts an episode", lambda row: float(row.attempts), digits=2)
ROUNDS = Measure[Lesson]("rounds of a complete episode", lambda row: float(row.rounds))
WAITED = Measure[Lesson]("rounds spent waiting", lambda row: float(row.rounds - row.vectors))
SEPARATIONS = Measure[Lesson]("separations a learner", lambda row: row.separations / row.amount, digits=2)
TRUE = Measure[Lesson](
    "vectors with the teacher's behaviour (%)", lambda row: 100.0 * row.true, lambda row: row.vectors
)


def combined(
    groups: Sequence[tuple[float, Sequence[RowT]]], measure: Measure[RowT], rng: np.random.Generator
) -> Estimate:
    """A weighted sum of means, with its interval; unknown if a group has no rows.

    Args:
        groups: Weight and rows of each.
        measure: What the mean is of.
        rng: Draws the resamples.
    """
    if not all(rows for _, rows in groups):
        return UNKNOWN
    numbers = replications(*(rows for _, rows in groups))
    sums = np.hstack([tally(rows, numbers, measure.value, measure.weight) for _, rows in groups])
    return bootstrap(sums, contrast(*(weight for weight, _ in groups)), rng)


def mean(rows: Sequence[RowT], measure: Measure[RowT], rng: np.random.Generator) -> Estimate:
    """A mean with its interval."""
    return combined([(1.0, rows)], measure, rng)


def difference(
    rows: Sequence[RowT], others: Sequence[RowT], measure: Measure[RowT], rng: np.random.Generator
) -> Estimate:
    """How much greater the mean is in `rows` than in `others`."""
    return combined([(1.0, rows), (-1.0, others)], measure, rng)


def pick(
    rows: Iterable[RowT], condition: str | None = None, amount: int | None = None, arena: str | None = None
) -> list[RowT]:
    """The rows of a condition, an amount, an arena; all where nothing is said."""
    return [
        row
        for row in rows
        if condition in (None, row.condition)
        and amount in (None, row.amount)
        and arena in (None, _arena_of(row))
    ]


def _arena_of(row: Lesson | Recalled) -> str:
    return row.arena if isinstance(row, Recalled) else ""


def conditions_of(rows: Iterable[RowT]) -> list[str]:
    """The conditions that occur, in order."""
    return list(dict.fromkeys(row.condition for row in rows))


def amounts_of(rows: Iterable[RowT], least: int = 1) -> list[int]:
    """The amounts that occur, from `least`."""
    return sorted({row.amount for row in rows if row.amount >= least})


def means_table(
    stem: str,
    title: str,
    note: str,
    amount: str,
    rows: Sequence[RowT],
    measures: Sequence[Measure[RowT]],
    rng: np.random.Generator,
) -> Table:
    """The means of every condition, arena and amount.

    Args:
        stem: Name in file names.
        title: Heading.
        note: What is in it.
        amount: Heading of the amounts.
        rows: All rows.
        measures: One a column.
        rng: Draws the resamples.
    """
    keys = {(row.condition, _arena_of(row), row.amount) for row in rows}
    arenas: bool = any(arena for _, arena, _ in keys)
    columns = [Column("condition"), *([Column("arena")] if arenas else []), Column(amount), Column("rows")]
    columns += [Column(m.name, m.digits, estimate=True) for m in measures]
    lines: list[tuple[Value, ...]] = []
    order = conditions_of(rows)
    for condition, arena, count in sorted(keys, key=lambda cell: (order.index(cell[0]), cell[1], cell[2])):
        cell: list[RowT] = pick(rows, condition, count, arena)
        where: tuple[Value, ...] = (condition, arena) if arenas else (condition,)
        lines.append((*where, count, len(cell), *(mean(cell, measure, rng) for measure in measures)))
    return Table(stem, title, note, tuple(columns), lines)
