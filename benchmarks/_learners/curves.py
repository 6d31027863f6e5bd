"""What comes of the rows: for each learner and arena, a point after every amount of learning."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from _learners.rows import Batch
from khepera_forage.thesis.statistics import (
    UNKNOWN,
    Estimate,
    bootstrap,
    bootstrap_quantile,
    contrast,
    ratio,
    replications,
    tally,
)

ENOUGH = 0.8
"""Share of the food that counts as success, where the steps are asked that it takes to get there."""


class Point(NamedTuple):
    """A learner after one amount of learning: means, with their intervals over replications.

    Attributes:
        amount: Asked for: training episodes, queries or steps.
        batches: Replications there are.
        steps: Of the environment, lived through.
        vectors: Learned from.
        score: Equation 5.1, in percent.
        delivered: Percent of the food.
        recall_steps: A recall.
        seconds: Wall time of learning.
    """

    amount: int
    batches: int
    steps: Estimate
    vectors: Estimate
    score: Estimate
    delivered: Estimate
    recall_steps: Estimate
    seconds: Estimate


@dataclass(frozen=True, slots=True)
class Curve:
    """One learner in one arena.

    Attributes:
        learner: Its name.
        arena: `corridor` or `rectangle`.
        points: In increasing order of the amount.
        enough: Steps after which a replication first delivered `ENOUGH` of the food; the median of them, infinite if
            more than half never did.
        enough_asked: The amount of learning asked for by then, the median again. Amounts are reached to within what an
            algorithm takes at a time, so that this, and not the steps, says who was first.
        gain: Percentage points of the food that it delivers more after all of the learning than after the first amount.
    """

    learner: str
    arena: str
    points: tuple[Point, ...]
    enough: Estimate
    enough_asked: float
    gain: Estimate

    @property
    def end(self) -> Point:
        """After all of the learning."""
        return self.points[-1]


class _First(NamedTuple):
    replication: int
    steps: float


def curves(rows: Sequence[Batch], rng: np.random.Generator) -> list[Curve]:
    """A curve for each learner and arena, in the order of the rows.

    Args:
        rows: In the order of `folder.in_order`.
        rng: Draws the resamples.
    """
    groups: dict[tuple[str, str], list[Batch]] = {}
    for row in rows:
        groups.setdefault((row.learner, row.arena), []).append(row)
    return [
        Curve(learner, arena, _points(own, rng), _enough(own, rng), _enough_asked(own), _gain(own, rng))
        for (learner, arena), own in groups.items()
    ]


def difference(rows: Sequence[Batch], others: Sequence[Batch], rng: np.random.Generator) -> Estimate:
    """How many percentage points of the food are delivered more in these rows than in others of the same replications.

    Args:
        rows: Of one arena.
        others: Of the same arena.
        rng: Draws the resamples.
    """
    numbers = replications(rows, others)
    sums = [tally(own, numbers, _percent, lambda row: row.foods) for own in (rows, others)]
    return bootstrap(np.hstack(sums), contrast(1, -1), rng)


def _points(rows: Sequence[Batch], rng: np.random.Generator) -> tuple[Point, ...]:
    points = []
    for amount in sorted({row.amount for row in rows}):
        own = [row for row in rows if row.amount == amount]
        numbers = replications(own)

        def mean(
            value: Callable[[Batch], float],
            weight: Callable[[Batch], float] = lambda _: 1.0,
            own: Sequence[Batch] = own,
            numbers: Sequence[int] = numbers,
        ) -> Estimate:
            return bootstrap(tally(own, numbers, value, weight), ratio, rng)

        points.append(
            Point(
                amount,
                len(own),
                mean(lambda row: row.steps),
                mean(lambda row: row.vectors),
                mean(lambda row: row.score * row.recalls, lambda row: row.recalls),
                mean(_percent, lambda row: row.foods),
                mean(lambda row: row.recall_steps, lambda row: row.recalls),
                mean(lambda row: row.seconds),
            )
        )
    return tuple(points)


def _enough(rows: Sequence[Batch], rng: np.random.Generator) -> Estimate:
    firsts = _firsts(rows, lambda row: row.steps)
    return bootstrap_quantile([_First(*item) for item in firsts.items()], lambda row: row.steps, 0.5, rng)


def _enough_asked(rows: Sequence[Batch]) -> float:
    amounts = sorted(_firsts(rows, lambda row: row.amount).values())
    return amounts[(len(amounts) - 1) // 2]


def _firsts(rows: Sequence[Batch], measure: Callable[[Batch], float]) -> dict[int, float]:
    """What a measure was in each replication when it first delivered enough; infinite where it never did."""
    firsts = {row.replication: math.inf for row in rows}
    for row in rows:
        if row.delivered >= ENOUGH * row.foods:
            firsts[row.replication] = min(firsts[row.replication], measure(row))
    return firsts


def _gain(rows: Sequence[Batch], rng: np.random.Generator) -> Estimate:
    amounts = sorted({row.amount for row in rows})
    if len(amounts) < 2:
        return UNKNOWN
    last, first = ([row for row in rows if row.amount == amount] for amount in (amounts[-1], amounts[0]))
    return difference(last, first, rng)


def _percent(row: Batch) -> float:
    return 100.0 * row.delivered
