"""Virtual laboratory and pymunk alone, side by side, with intervals over replications."""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np

from _virtual_lab.episodes import ARENAS, LEARNERS, PYMUNK, VIRTUAL, WORLDS, Outcome
from khepera_forage.rollouts.rows import RecallRow, TrainingRow
from khepera_forage.thesis.statistics import (
    Estimate,
    bootstrap,
    contrast,
    ratio,
    replications,
    sums_by_replication,
)

RESAMPLE_SEED = 20010
"""Of the bootstrap's own draws: the same rows give the same intervals."""
Row = RecallRow | TrainingRow


class Measure(NamedTuple):
    """A ratio of sums over rows.

    Attributes:
        name: With its unit.
        of: What is summed.
        by: What it is divided by.
    """

    name: str
    of: Callable[[Any], float]
    by: Callable[[Any], float]


def _one(_: Row) -> float:
    return 1.0


RECALL_MEASURES = (
    Measure("score (%)", lambda row: row.score, _one),
    Measure("food delivered (%)", lambda row: 100.0 * row.delivered, lambda row: row.foods),
    Measure("steps", lambda row: row.steps, _one),
)
TRAINING_MEASURES = (
    Measure("attempts complete (%)", lambda row: 100.0 * row.complete, _one),
    Measure("attempts for one complete episode", _one, lambda row: row.complete),
    Measure("rounds of a complete episode", lambda row: row.complete * row.rounds, lambda row: row.complete),
    Measure(
        "experience vectors of a complete episode",
        lambda row: row.complete * row.vectors,
        lambda row: row.complete,
    ),
    Measure("separations an attempt", lambda row: row.separations, _one),
)


class Compared(NamedTuple):
    """A measure in both worlds.

    Attributes:
        who: `teacher` or `imitator`; `training` for measures of training.
        arena: `corridor` or `rectangle`.
        measure: Its name.
        episodes: Rows in each world: recalls, or attempts in pymunk.
        pymunk: With 95 % interval over replications.
        virtual: The same.
        difference: Virtual minus pymunk, replication by replication: they share their seeds.
    """

    who: str
    arena: str
    measure: str
    episodes: tuple[int, int]
    pymunk: Estimate
    virtual: Estimate
    difference: Estimate


def trainings(outcomes: Sequence[Outcome]) -> list[Compared]:
    """All measures of training."""
    rows = {world: [row for o in outcomes if o.world == world for row in o.trainings] for world in WORLDS}
    return [_compared("training", "corridor", measure, rows) for measure in TRAINING_MEASURES]


def recalls(outcomes: Sequence[Outcome]) -> list[Compared]:
    """All measures of all recalls; places at which one world could not begin are left out in both."""
    unplaced = frozenset[tuple[str, int]]().union(*(outcome.unplaced for outcome in outcomes))
    results = []
    for arena in ARENAS:
        for who in LEARNERS:
            rows = {
                world: [
                    row
                    for outcome in outcomes
                    if outcome.world == world
                    for row in outcome.recalls
                    if (row.arena, row.learner) == (arena, who) and (arena, row.seed) not in unplaced
                ]
                for world in WORLDS
            }
            results += [_compared(who, arena, measure, rows) for measure in RECALL_MEASURES]
    return results


def _compared(who: str, arena: str, measure: Measure, rows: dict[str, list[Any]]) -> Compared:
    numbers = replications(*rows.values())
    sums = {world: sums_by_replication(own, numbers, measure.of, measure.by) for world, own in rows.items()}
    both = np.hstack([sums[VIRTUAL], sums[PYMUNK]])

    def rng() -> np.random.Generator:
        return np.random.default_rng(RESAMPLE_SEED)

    return Compared(
        who,
        arena,
        measure.name,
        (len(rows[PYMUNK]), len(rows[VIRTUAL])),
        bootstrap(sums[PYMUNK], ratio, rng()),
        bootstrap(sums[VIRTUAL], ratio, rng()),
        bootstrap(both, contrast(1.0, -1.0), rng()),
    )
