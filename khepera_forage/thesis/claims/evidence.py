"""The rows that claims are measured on, and the measures they share."""

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from khepera_forage.rollouts.rows import IMITATOR, RANDOM, RecallRow, TrainingRow
from khepera_forage.sim.arena import CORRIDOR
from khepera_forage.thesis.statistics import (
    RESAMPLES,
    Estimate,
    Measure,
    Replicated,
    bootstrap,
    contrast,
    ratio,
    replications,
    tally,
)
from khepera_forage.vision.scene import MM_PER_PIXEL

_R = TypeVar("_R", bound=Replicated)

TRAINING_DISTANCE = math.dist(CORRIDOR.foods[0], CORRIDOR.home) / MM_PER_PIXEL
"""Pixels between food and home in training, always in the corridor (figure 5.1)."""
NEAR_TRAINING = 6.0
"""Pixels on either side within which food counts as lying where it lay in training: nearly its own width."""


@dataclass(frozen=True)
class Evidence:
    """All rows of a reproduction under one noise condition, and a generator for the resamples.

    Attributes:
        recalls: The imitator's.
        chance: Those of a policy that draws every behaviour uniformly; may be empty.
        trainings: Attempts at training episodes, under any noise conditions.
        teachers: Forages of the teacher alone, best run with a limit well above the thesis'.
        rng: Draws the resamples.
        resamples: How many.
    """

    recalls: Sequence[RecallRow]
    chance: Sequence[RecallRow]
    trainings: Sequence[TrainingRow]
    teachers: Sequence[RecallRow]
    rng: np.random.Generator
    resamples: int = RESAMPLES

    def cell_scores(self, weights: Mapping[tuple[str, int], float]) -> Estimate:
        """A weighted sum of the mean scores of cells (arena, episodes), in percentage points."""
        columns = [measure for cell in weights for measure in _score_in(*cell)]
        sums = tally(self.recalls, replications(self.recalls), *columns)
        return bootstrap(sums, contrast(*weights.values()), self.rng, self.resamples)

    def mean(self, sample: "Sample[_R]") -> Estimate:
        """A mean or a share."""
        sums = tally(sample.rows, replications(sample.rows), sample.top, sample.bottom)
        return bootstrap(sums, ratio, self.rng, self.resamples)

    def difference(self, sample: "Sample[_R]", other: "Sample[_R]") -> Estimate:
        """One mean less another, replications kept together."""
        numbers = replications(sample.rows, other.rows)
        sums = np.hstack([tally(s.rows, numbers, s.top, s.bottom) for s in (sample, other)])
        return bootstrap(sums, contrast(1.0, -1.0), self.rng, self.resamples)


@dataclass(frozen=True, slots=True)
class Sample(Generic[_R]):
    """The sum of one measure over that of another; by default a mean over the rows."""

    rows: Sequence[_R]
    top: Measure[_R]
    bottom: Measure[_R] = lambda row: 1.0

    @property
    def value(self) -> float:
        """Over all rows; nan where there are none."""
        bottom = sum(map(self.bottom, self.rows))
        return sum(map(self.top, self.rows)) / bottom if bottom else math.nan


def gather(
    recalls: Iterable[RecallRow],
    trainings: Iterable[TrainingRow],
    teachers: Iterable[RecallRow],
    rng: np.random.Generator,
    resamples: int = RESAMPLES,
) -> Evidence:
    """Sort the rows of a reproduction by what they are evidence of.

    Raises:
        ValueError: The imitator's rows are of several noise conditions.
    """
    rows = list(recalls)
    imitator = [row for row in rows if row.learner == IMITATOR]
    conditions = sorted({row.noise for row in imitator})
    if len(conditions) > 1:
        raise ValueError(f"recalls of noise conditions {conditions}; allowed: one condition at a time")
    chance = [row for row in rows if row.learner == RANDOM]
    return Evidence(imitator, chance, list(trainings), list(teachers), rng, resamples)


def of_arena(rows: Iterable[RecallRow], arena: str) -> list[RecallRow]:
    """The rows of one arena."""
    return [row for row in rows if row.arena == arena]


def food_share(
    rows: Sequence[RecallRow], inside: Callable[[float], bool] = lambda distance: True
) -> Sample[RecallRow]:
    """Success: the share of food delivered, of the food whose distance from home in pixels is such."""

    def delivered(row: RecallRow) -> float:
        places = zip(row.food_home_distances, row.food_delivered, strict=True)
        return sum(done and inside(distance) for distance, done in places)

    return Sample(rows, delivered, lambda row: sum(map(inside, row.food_home_distances)))


def _score_in(arena: str, episodes: int) -> tuple[Measure[RecallRow], Measure[RecallRow]]:
    """The score of a row of this cell, and whether it is one."""

    def inside(row: RecallRow) -> bool:
        return (row.arena, row.episodes) == (arena, episodes)

    return lambda row: row.score if inside(row) else 0.0, inside
