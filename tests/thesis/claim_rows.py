"""Rows that support a claim, contradict it or leave it undecided, and the claim measured on them."""

from collections.abc import Callable, Sequence
from itertools import product

import numpy as np

from khepera_forage.rollouts.rows import RecallRow, TrainingRow
from khepera_forage.thesis.claims import Claim, Verdict, claims
from tests.thesis.synthetic import failed, recall, training

REPLICATIONS = 8
NUMBER = {
    "improves corridor": 1,
    "improves rectangle": 2,
    "shrinks corridor": 3,
    "shrinks rectangle": 4,
    "generalises": 5,
    "comparable": 6,
    "areas corridor": 7,
    "areas rectangle": 8,
    "around corridor": 9,
    "around rectangle": 10,
    "orient without food corridor": 11,
    "orient without food rectangle": 12,
    "failures": 13,
    "rest": 14,
    "losses": 15,
    "frequent": 16,
    "limit corridor": 17,
    "limit rectangle": 18,
}
"""Number of each claim in the report."""
Level = Callable[[int], float]
"""A number for each replication."""
SUPPORTED, NOT, UNDECIDED = Verdict.SUPPORTED, Verdict.NOT_SUPPORTED, Verdict.UNDECIDED


def always(value: float) -> Level:
    return lambda replication: value


def alternating(low: float, high: float) -> Level:
    """`low` in even replications and `high` in odd ones."""
    return lambda replication: (low, high)[replication % 2]


def claim_from(
    name: str,
    recalls: Sequence[RecallRow] = (),
    trainings: Sequence[TrainingRow] = (),
    teachers: Sequence[RecallRow] = (),
) -> Claim:
    return claims(recalls, trainings, teachers, np.random.default_rng(3), 400)[NUMBER[name] - 1]


def recalls_with_scores(arena: str, levels: dict[int, Level]) -> list[RecallRow]:
    """One recall with this score for each replication and cell."""
    return [
        recall(arena=arena, replication=i, episodes=episodes, steps=100, correct=int(level(i)))
        for episodes, level in levels.items()
        for i in range(REPLICATIONS)
    ]


def recalls_with_success(distance: float, level: Level, each: int = 10, **changes: object) -> list[RecallRow]:
    """Recalls with food at this distance from home; this share of them deliver it."""
    return [
        (recall if number < each * level(i) else failed)(
            replication=i, recall=number, food_x=(-distance,), **changes
        )
        for i, number in product(range(REPLICATIONS), range(each))
    ]


def attempts_per_file(noise: str, level: Level) -> list[TrainingRow]:
    """Episodes that need this many attempts each, three for each replication."""
    return [
        training(
            replication=i,
            file=file,
            attempt=number,
            noise=noise,
            reason="" if number == level(i) else "separated",
        )
        for i, file in product(range(REPLICATIONS), range(1, 4))
        for number in range(1, int(level(i)) + 1)
    ]
