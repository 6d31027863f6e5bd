"""What is kept of every batch of recalls, and how much of everything there is."""

import math
from dataclasses import dataclass
from typing import NamedTuple

from khepera_forage.policies.learners import Needs

ARENAS = ("corridor", "rectangle")
"""Where everyone is tested."""
HALF_DECADES = (1_000, 3_000, 10_000, 30_000, 100_000, 300_000)


@dataclass(frozen=True, slots=True)
class Batch:
    """Recalls of one learner, after one amount of learning, in one arena.

    Attributes:
        learner: Its name among the learners; `teacher` and `random` learn nothing.
        replication: Number of the repetition, with seeds of its own, its own training files included.
        amount: Training episodes, queries, or steps of the environment asked for; 0 for who learns nothing.
        arena: `corridor` or `rectangle`.
        steps: Steps of the environment that the learner has lived through: rounds of all its attempts at training,
            queries, or steps of its trials.
        vectors: Experience vectors, or answers of the teacher, that it learned from; 0 for trial and error.
        recalls: Recall episodes in this batch.
        score: Their mean (equation 5.1), in percent.
        delivered: Food objects carried home in them.
        foods: Food objects there were.
        recall_steps: Steps they took, all together.
        seconds: Wall time of learning so far, the simulation of what it lived through included.

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

    @property
    def key(self) -> tuple[str, int]:
        """Learner and replication: the unit that it is of."""
        return self.learner, self.replication


class Size(NamedTuple):
    """How much is done.

    Attributes:
        recalls: Recall episodes in each arena, after each amount of learning.
        episodes: Training episodes after which imitators are looked at.
        queries: Answers of the teacher after which those who ask are looked at.
        steps: Steps of the environment after which trial and error is looked at.
    """

    recalls: int
    episodes: tuple[int, ...]
    queries: tuple[int, ...]
    steps: tuple[int, ...]

    def amounts(self, needs: Needs | None) -> tuple[int, ...]:
        """After how much a learner is looked at, by what it learns from; None learns nothing."""
        if needs is None:
            return (0,)
        return {Needs.VECTORS: self.episodes, Needs.QUERIES: self.queries, Needs.STEPS: self.steps}[needs]


def steps_up_to(most: int) -> tuple[int, ...]:
    """Half decades of steps below the most, and the most."""
    return (*(amount for amount in HALF_DECADES if amount < most), most)


def _require(fine: bool, name: str, value: object, allowed: str) -> None:
    if not fine:
        raise ValueError(f"{name} is {value!r}; allowed: {allowed}")
