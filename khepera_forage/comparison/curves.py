"""Learning curves: for each learner and arena, a point after every amount of learning."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from khepera_forage.comparison.rows import RecallBatch
from khepera_forage.experiments.measures import Measure, difference, mean, pick
from khepera_forage.experiments.statistics import UNKNOWN, Estimate, bootstrap_quantile

SUCCESS = 0.8
"""Share of the food that counts as success."""
DELIVERED = Measure[RecallBatch](
    "food delivered (%)", lambda row: 100.0 * row.delivered, lambda row: row.foods
)
MEASURES = (
    Measure[RecallBatch]("steps", lambda row: row.steps),
    Measure[RecallBatch]("vectors", lambda row: row.vectors),
    Measure[RecallBatch]("score (%)", lambda row: row.score * row.recalls, lambda row: row.recalls),
    DELIVERED,
    Measure[RecallBatch]("steps a recall", lambda row: row.recall_steps, lambda row: row.recalls),
    Measure[RecallBatch]("seconds", lambda row: row.seconds),
)
"""In the order of the fields of `Point`."""


class Point(NamedTuple):
    """A learner after one amount of learning: means, with their intervals over replications.

    Attributes:
        amount: Requested training episodes, queries or steps.
        batches: Replications.
        steps: Environment steps of the learning.
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
        steps_to_success: Steps after which a replication first delivered the share `SUCCESS` of the food; the median
            over replications, infinite if more than half never did.
        amount_to_success: The requested amount by then, the median again. Algorithms overshoot the requested amount
            differently, so this number, and not the steps, ranks learners.
        gain: Percentage points of the food delivered after all of the learning, minus those after the first amount.
    """

    learner: str
    arena: str
    points: tuple[Point, ...]
    steps_to_success: Estimate
    amount_to_success: float
    gain: Estimate

    @property
    def end(self) -> Point:
        """After all of the learning."""
        return self.points[-1]


class _First(NamedTuple):
    replication: int
    steps: float


def curves(rows: Sequence[RecallBatch], rng: np.random.Generator) -> list[Curve]:
    """A curve for each learner and arena, in the order of the rows.

    Args:
        rows: In the order of `in_order`.
        rng: Draws the resamples.
    """
    groups: dict[tuple[str, str], list[RecallBatch]] = {}
    for row in rows:
        groups.setdefault((row.learner, row.arena), []).append(row)
    return [_curve(own, rng) for own in groups.values()]


def _curve(rows: Sequence[RecallBatch], rng: np.random.Generator) -> Curve:
    parts = {amount: pick(rows, amount=amount) for amount in sorted({row.amount for row in rows})}
    points = tuple(
        Point(amount, len(own), *(mean(own, measure, rng) for measure in MEASURES))
        for amount, own in parts.items()
    )
    first, *_, last = (*parts.values(), *parts.values())
    steps = [_First(*item) for item in _firsts(rows, lambda row: row.steps).items()]
    to_success = bootstrap_quantile(steps, lambda row: row.steps, 0.5, rng)
    amounts = sorted(_firsts(rows, lambda row: row.amount).values())
    gain = difference(last, first, DELIVERED, rng) if len(parts) > 1 else UNKNOWN
    return Curve(rows[0].learner, rows[0].arena, points, to_success, amounts[(len(amounts) - 1) // 2], gain)


def _firsts(rows: Sequence[RecallBatch], measure: Callable[[RecallBatch], float]) -> dict[int, float]:
    """A measure at the first success of each replication; infinite without success."""
    firsts = {row.replication: math.inf for row in rows}
    for row in rows:
        if row.delivered >= SUCCESS * row.foods:
            firsts[row.replication] = min(firsts[row.replication], measure(row))
    return firsts
