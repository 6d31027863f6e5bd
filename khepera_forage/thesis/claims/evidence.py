"""The rows that claims are measured on, and measures that several claims share."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from khepera_forage.estimates import (
    RESAMPLES,
    Estimate,
    Replicated,
    bootstrap,
    contrast,
    ratio,
    replications,
    sums_by_replication,
)
from khepera_forage.rollouts.rows import IMITATOR, RANDOM, RecallRow, TrainingRow, common_decisions
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions

_R = TypeVar("_R", bound=Replicated)

Measure = Callable[[_R], float]
"""A number of a row."""
NEAR_TRAINING = 6.0
"""Pixels on either side of the training distance that count as the same distance: nearly the width of a food object."""


@dataclass(frozen=True)
class Evidence:
    """The rows of a reproduction, and a generator for the resamples.

    Attributes:
        recalls: Recalls of the imitator, under one noise condition.
        chance: Recalls of a policy that draws every behaviour uniformly; may be empty.
        trainings: Attempts at training episodes, under any noise conditions.
        teachers: Forages of the teacher alone, with a time limit well above the thesis's.
        rng: Draws the resamples.
        resamples: Resamples for each interval.
        decisions: Of all rows.
    """

    recalls: Sequence[RecallRow]
    chance: Sequence[RecallRow]
    trainings: Sequence[TrainingRow]
    teachers: Sequence[RecallRow]
    rng: np.random.Generator
    resamples: int = RESAMPLES
    decisions: Decisions = DEFAULT_DECISIONS

    def cell_scores(self, weights: Mapping[tuple[str, int], float]) -> Estimate:
        """A weighted sum of the mean scores of cells (arena, episodes), in percentage points."""
        columns = [measure for cell in weights for measure in _score_in(*cell)]
        sums = sums_by_replication(self.recalls, replications(self.recalls), *columns)
        return bootstrap(sums, contrast(*weights.values()), self.rng, self.resamples)

    def mean(self, sample: "Sample[_R]") -> Estimate:
        """The mean or share of a sample, with its interval."""
        sums = sums_by_replication(sample.rows, replications(sample.rows), sample.top, sample.bottom)
        return bootstrap(sums, ratio, self.rng, self.resamples)

    def difference(self, sample: "Sample[_R]", other: "Sample[_R]") -> Estimate:
        """The difference of two means, with resamples of the same replications for both."""
        numbers = replications(sample.rows, other.rows)
        sums = np.hstack([sums_by_replication(s.rows, numbers, s.top, s.bottom) for s in (sample, other)])
        return bootstrap(sums, contrast(1.0, -1.0), self.rng, self.resamples)


@dataclass(frozen=True, slots=True)
class Sample(Generic[_R]):
    """The sum of one measure divided by the sum of another; by default a mean over the rows."""

    rows: Sequence[_R]
    top: Measure[_R]
    bottom: Measure[_R] = lambda row: 1.0

    @property
    def value(self) -> float:
        """The value over all rows; nan without rows."""
        bottom = sum(map(self.bottom, self.rows))
        return sum(map(self.top, self.rows)) / bottom if bottom else math.nan


def gather(
    recalls: Iterable[RecallRow],
    trainings: Iterable[TrainingRow],
    teachers: Iterable[RecallRow],
    rng: np.random.Generator,
    resamples: int = RESAMPLES,
) -> Evidence:
    """Separate the recalls of the imitator from those of a random policy.

    Raises:
        ValueError: The recalls of the imitator have several noise conditions, or the rows several decisions.
    """
    rows, attempts, forages = list(recalls), list(trainings), list(teachers)
    decisions = common_decisions(rows, attempts, forages)
    imitator = [row for row in rows if row.learner == IMITATOR]
    conditions = sorted({row.noise for row in imitator})
    if len(conditions) > 1:
        raise ValueError(f"recalls have noise conditions {conditions}; allowed: one condition at a time")
    chance = [row for row in rows if row.learner == RANDOM]
    return Evidence(imitator, chance, attempts, forages, rng, resamples, decisions)


def of_arena(rows: Iterable[RecallRow], arena: str) -> list[RecallRow]:
    """The rows of one arena."""
    return [row for row in rows if row.arena == arena]


def food_share(
    rows: Sequence[RecallRow], inside: Callable[[float], bool] = lambda distance: True
) -> Sample[RecallRow]:
    """The share of food delivered, of the food whose distance from home in pixels is `inside`."""

    def delivered(row: RecallRow) -> float:
        places = zip(row.food_home_distances, row.food_delivered, strict=True)
        return sum(done and inside(distance) for distance, done in places)

    return Sample(rows, delivered, lambda row: sum(map(inside, row.food_home_distances)))


def _score_in(arena: str, episodes: int) -> tuple[Measure[RecallRow], Measure[RecallRow]]:
    """Two measures of a row: its score, and 1; both are 0 for a row of another cell."""

    def inside(row: RecallRow) -> bool:
        return (row.arena, row.episodes) == (arena, episodes)

    return lambda row: row.score if inside(row) else 0.0, inside
