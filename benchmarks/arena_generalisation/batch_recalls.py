"""Recalls of any classifiers in compiled worlds: all arenas advance together, so that classifiers decide in bulk."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arena_generalisation.decision_table import DecisionTable
from arena_generalisation.recall_arenas import RecallArena
from khepera_forage.envs.compiled.batch import CompiledBatch
from khepera_forage.task.states import FoodType, StateVector


@dataclass(slots=True)
class ArenaBatch:
    """Recalls in one arena, each in a world of its own.

    Attributes:
        batch: The worlds.
        deciders: Number of the decider in each.
        over: Whether the recall in each has ended.
        score: Of each that has ended, percent.
        steps: Of each that has ended.
        delivered: Food brought home in each that is not poisonous.
        poison_home: Poisonous food brought home in each.
        not_poisonous: Food objects in each that are not poisonous.
        behaviours: Those that are executed.
        rounds: Since the recalls began.
    """

    batch: CompiledBatch
    deciders: NDArray[np.int64]
    over: NDArray[np.bool_] = field(init=False)
    score: NDArray[np.float64] = field(init=False)
    steps: NDArray[np.int64] = field(init=False)
    delivered: NDArray[np.int64] = field(init=False)
    poison_home: NDArray[np.int64] = field(init=False)
    not_poisonous: NDArray[np.int64] = field(init=False)
    behaviours: NDArray[np.int64] = field(init=False)
    rounds: int = field(init=False, default=0)

    def __post_init__(self) -> None:
        worlds = self.batch.num_worlds
        self.over = np.zeros(worlds, np.bool_)
        self.score = np.zeros(worlds)
        numbers = (np.zeros(worlds, np.int64) for _ in range(4))
        self.steps, self.delivered, self.poison_home, self.behaviours = numbers
        self.batch.restart(np.arange(worlds))
        self.not_poisonous = (self.batch.worlds.objects["type"] != FoodType.POISONOUS).sum(axis=1)

    @property
    def vectors(self) -> NDArray[np.int64]:
        """The state vectors; no distance is longer than the arena's diagonal, as in `BehavioursEnv`."""
        return np.stack([self.batch.shown[name] for name in StateVector._fields], axis=1)

    def deciding(self, holds: NDArray[np.int64]) -> NDArray[np.bool_]:
        """The worlds in which a behaviour is decided now: the last one has held for its rounds, or there is none.

        Args:
            holds: Rounds that a behaviour of each decider holds.
        """
        due: NDArray[np.bool_] = self.rounds % holds[self.deciders] == 0
        return ~self.over & due

    def step(self, deciding: NDArray[np.bool_], behaviours: NDArray[np.int64]) -> None:
        """One round.

        Args:
            deciding: Worlds that have decided; the behaviours of the others hold.
            behaviours: One for each of them.
        """
        self.behaviours[deciding] = behaviours
        self.rounds += 1
        shown = self.batch.step(self.behaviours, np.zeros(len(self.over), np.bool_))
        ended = ~self.over & (shown["terminated"] | shown["truncated"])
        for name in ("score", "steps", "delivered", "poison_home"):
            getattr(self, name)[ended] = shown[name][ended]
        self.over |= ended


def arena_batch(arena: RecallArena, deciders: Sequence[int], seeds: Sequence[int]) -> ArenaBatch:
    """Recalls in one arena, up to their first observations.

    Args:
        arena: Where.
        deciders: Each of them has a recall with each seed.
        seeds: Of the recalls.
    """
    worlds = len(deciders) * len(seeds)
    batch = CompiledBatch(worlds, arena.arena, **arena.arguments)
    batch.seed(list(seeds) * len(deciders), np.arange(worlds))
    return ArenaBatch(batch, np.repeat(np.array(deciders, np.int64), len(seeds)))


def recall_all(batches: Sequence[ArenaBatch], table: DecisionTable, rng: np.random.Generator) -> None:
    """Run all recalls to their ends.

    Args:
        batches: In all arenas.
        table: Of the deciders.
        rng: Draws behaviours.
    """
    active = list(batches)
    while active:
        deciding = [batch.deciding(table.holds) for batch in active]
        deciders = [batch.deciders[mask] for batch, mask in zip(active, deciding, strict=True)]
        vectors = [batch.vectors[mask] for batch, mask in zip(active, deciding, strict=True)]
        behaviours = table.decide(np.concatenate(deciders), np.concatenate(vectors), rng)
        ends = np.cumsum([len(part) for part in deciders])[:-1]
        for batch, mask, own in zip(active, deciding, np.split(behaviours, ends), strict=True):
            batch.step(mask, own)
        active = [batch for batch in active if not batch.over.all()]
