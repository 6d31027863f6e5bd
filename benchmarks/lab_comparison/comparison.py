"""Virtual laboratory and pymunk alone side by side, with intervals over replications."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from khepera_forage.estimates import Estimate, Measure, difference, mean, pick
from lab_comparison.episodes import (
    ARENAS,
    LEARNERS,
    PYMUNK,
    UNPLACED,
    VIRTUAL,
    WORLDS,
    Exclusion,
    LabRecall,
    LabTraining,
)

RESAMPLE_SEED = 20010
"""Of the bootstrap's draws, so that the same rows give the same intervals."""
RECALL_MEASURES = (
    Measure[LabRecall]("score (%)", lambda row: row.score),
    Measure[LabRecall]("food delivered (%)", lambda row: 100.0 * row.delivered, lambda row: row.foods),
    Measure[LabRecall]("steps", lambda row: row.steps),
)
TRAINING_MEASURES = (
    Measure[LabTraining]("attempts complete (%)", lambda row: 100.0 * row.complete),
    Measure[LabTraining]("attempts for one complete episode", lambda row: 1.0, lambda row: row.complete),
    Measure[LabTraining](
        "rounds of a complete episode", lambda row: row.complete * row.rounds, lambda row: row.complete
    ),
    Measure[LabTraining](
        "experience vectors of a complete episode",
        lambda row: row.complete * row.vectors,
        lambda row: row.complete,
    ),
    Measure[LabTraining]("separations an attempt", lambda row: row.separations),
)


class Comparison(NamedTuple):
    """A measure in both worlds.

    Attributes:
        policy: `teacher` or `imitator`; empty for measures of training.
        arena: `corridor` or `rectangle`.
        measure: Its name.
        episodes: Rows of pymunk and of the virtual laboratory: recalls, or attempts.
        pymunk: With 95 % interval over replications.
        virtual: The same.
        difference: Virtual minus pymunk, paired by replication because they share their seeds.
    """

    policy: str
    arena: str
    measure: str
    episodes: tuple[int, int]
    pymunk: Estimate
    virtual: Estimate
    difference: Estimate


def trainings(rows: Sequence[LabTraining]) -> list[Comparison]:
    """All measures of training."""
    return [_compared("", "corridor", measure, rows) for measure in TRAINING_MEASURES]


def recalls(rows: Sequence[LabRecall], exclusions: Sequence[Exclusion]) -> list[Comparison]:
    """All measures of all recalls; places at which a recall could not begin are left out in both worlds."""
    unplaced = {(row.arena, row.seed) for row in exclusions if row.reason == UNPLACED}
    kept = [row for row in rows if (row.arena, row.seed) not in unplaced]
    return [
        _compared(policy, arena, measure, pick(kept, arena=arena, learner=policy))
        for arena in ARENAS
        for policy in LEARNERS
        for measure in RECALL_MEASURES
    ]


def _compared(policy: str, arena: str, measure: Measure[Any], rows: Sequence[Any]) -> Comparison:
    own = {world: pick(rows, world=world) for world in WORLDS}

    def rng() -> np.random.Generator:
        return np.random.default_rng(RESAMPLE_SEED)

    return Comparison(
        policy,
        arena,
        measure.name,
        (len(own[PYMUNK]), len(own[VIRTUAL])),
        mean(own[PYMUNK], measure, rng()),
        mean(own[VIRTUAL], measure, rng()),
        difference(own[VIRTUAL], own[PYMUNK], measure, rng()),
    )
