"""Rows of the comparison, and the amounts of learning after which learners are tested."""

import math
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from khepera_forage.policies.learners import Needs

ARENAS = ("corridor", "rectangle")
"""Where all learners are tested; they learn in the first."""
HALF_DECADES = (1_000, 3_000, 10_000, 30_000, 100_000, 300_000)


@dataclass(frozen=True, slots=True)
class RecallBatch:
    """Recalls of one learner, after one amount of learning, in one arena.

    Attributes:
        learner: Its name among the learners; `teacher` and `random` learn nothing.
        replication: Number of the repetition, with seeds and training files of its own.
        amount: Training episodes, queries, or environment steps, as requested; 0 without learning.
        arena: `corridor` or `rectangle`.
        steps: Environment steps of the learning: rounds of all training attempts, queries, or steps of the trials.
        vectors: Experience vectors or answers of the teacher that the learner used; 0 for reinforcement learning.
        recalls: Recall episodes in this batch.
        score: Their mean (equation 5.1), in percent.
        delivered: Food objects carried home in all of them.
        foods: Food objects in all of them.
        recall_steps: Steps of all of them.
        seconds: Wall time of the learning so far, including the simulation.

    Raises:
        ValueError: Fields that contradict each other.
    """

    learner: str
    replication: int
    amount: int
    arena: str
    steps: int
    vectors: int
    recalls: int
    score: float
    delivered: int
    foods: int
    recall_steps: int
    seconds: float

    def __post_init__(self) -> None:
        _require(self.arena in ARENAS, "arena", self.arena, " or ".join(ARENAS))
        for name in ("replication", "amount", "steps", "vectors", "seconds"):
            _require(getattr(self, name) >= 0, name, getattr(self, name), "0 or more")
        _require(self.recalls >= 1, "recalls", self.recalls, "1 or more")
        _require(math.isfinite(self.score) and self.score <= 100, "score", self.score, "up to 100")
        _require(0 <= self.delivered <= self.foods, "delivered", self.delivered, f"0..{self.foods} foods")
        _require(self.recall_steps >= self.recalls, "recall_steps", self.recall_steps, "1 a recall or more")


class Size(NamedTuple):
    """How much is done.

    Attributes:
        recalls: Recall episodes in each arena, after each amount of learning.
        episodes: Training episodes after which imitators are tested.
        queries: Answers of the teacher after which learners that query it are tested.
        steps: Environment steps after which reinforcement learners are tested.
    """

    recalls: int
    episodes: tuple[int, ...]
    queries: tuple[int, ...]
    steps: tuple[int, ...]

    def amounts(self, needs: Needs | None) -> tuple[int, ...]:
        """The amounts of learning after which a learner is tested; None learns nothing."""
        if needs is None:
            return (0,)
        return {Needs.VECTORS: self.episodes, Needs.QUERIES: self.queries, Needs.STEPS: self.steps}[needs]


def steps_up_to(most: int) -> tuple[int, ...]:
    """Half decades of steps below the most, and the most."""
    return (*(amount for amount in HALF_DECADES if amount < most), most)


def in_order(rows: Collection[RecallBatch], names: Sequence[str]) -> list[RecallBatch]:
    """Rows by learner, replication, amount and arena."""
    place = {name: i for i, name in enumerate(names)}
    return sorted(rows, key=lambda row: (place[row.learner], row.replication, row.amount, row.arena))


def _require(fine: bool, name: str, value: object, allowed: str) -> None:
    if not fine:
        raise ValueError(f"{name} is {value!r}; allowed: {allowed}")
