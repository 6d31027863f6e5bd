"""Recalls with the same seeds on both backends, in random arenas.

A seed has the same start, food places and food types on both backends. Noise is drawn independently.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from backend_agreement.arenas import RandomArena
from backend_agreement.samples import IMITATOR, TEACHER, Vectors
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.noise import Noise
from khepera_forage.policies import NearestNeighbourImitator, Policy, Teacher
from khepera_forage.policies.nearest_neighbour.memories import memories_of
from khepera_forage.rollouts.recall import recall
from khepera_forage.task.states import FoodType

PYMUNK, COMPILED = "pymunk", "compiled"
NO_NOISE = "teacher, no noise"
POLICIES = (NO_NOISE, TEACHER, IMITATOR)
TRAININGS = 3
"""Training episodes of the imitator, in the corridor."""
ODDS = {FoodType.PICKABLE: 0.5, FoodType.PUSHABLE: 0.25, FoodType.POISONOUS: 0.25}


@dataclass(frozen=True, slots=True)
class PairedRecall:
    """One recall on one backend.

    Attributes:
        policy: One of `POLICIES`.
        kind: Name of the arena's kind.
        arena: Number of the arena.
        foods: Number of food objects.
        seed: Of the episode.
        backend: `pymunk` or `compiled`.
        score: Equation 5.1, percent.
        steps: How many it took.
        not_poisonous: Food objects that are not poisonous.
        delivered: Those that were brought home.
        poison_home: Poisonous food brought home.
        complete: Whether no food was left that was not known to be poisonous.
    """

    policy: str
    kind: str
    arena: int
    foods: int
    seed: int
    backend: str
    score: float
    steps: int
    not_poisonous: int
    delivered: int
    poison_home: int
    complete: bool

    @property
    def replication(self) -> int:
        """Intervals resample arenas."""
        return self.arena


class Result(NamedTuple):
    """What came of a recall; the fields are those of `rollouts.rows.RecallRow`."""

    score: float
    steps: int
    delivered: int
    poison_home: int
    penalty: float


class ArenaRecalls(NamedTuple):
    """The recalls of a policy in one arena, on both backends.

    Attributes:
        policy: One of `POLICIES`.
        number: Of the arena.
        random: The arena, and the seeds.
        experience: Of the imitator.
    """

    policy: str
    number: int
    random: RandomArena
    experience: Vectors

    @property
    def key(self) -> str:
        """Policy, arena, and number of recalls."""
        return f"{self.policy}, arena {self.number}, {len(self.random.seeds)} recalls"

    def run(self) -> list[PairedRecall]:
        """Recall with every seed, first with pymunk."""
        kind, _, foods, seeds = self.random
        pymunk, not_poisonous = self._pymunk()
        return [
            PairedRecall(
                policy=self.policy,
                kind=kind.name,
                arena=self.number,
                foods=foods,
                seed=seed,
                backend=backend,
                score=result.score,
                steps=result.steps,
                not_poisonous=count,
                delivered=result.delivered,
                poison_home=result.poison_home,
                complete=result.penalty == 0,
            )
            for backend, results in ((PYMUNK, pymunk), (COMPILED, self._compiled()))
            for seed, count, result in zip(seeds, not_poisonous, results, strict=True)
        ]

    def _pymunk(self) -> tuple[list[Result], list[int]]:
        """Recalls with pymunk, and the food objects in each that are not poisonous."""
        env = BehavioursEnv(arena=self.random.arena, **self._arguments)
        policy: Policy = Teacher.of(env)
        if self.policy == IMITATOR:
            policy = NearestNeighbourImitator(env.diagonal).fit(*self.experience)
        results, not_poisonous = [], []
        for seed in self.random.seeds:
            row = recall(env, policy, seed, learner=self.policy)
            results.append(Result(*(getattr(row, name) for name in Result._fields)))
            foods = env.forager.tracker.foods
            not_poisonous.append(sum(food.type != FoodType.POISONOUS for food in foods))
        env.close()
        return results, not_poisonous

    def _compiled(self) -> list[Result]:
        from khepera_forage.rollouts.compiled import recalls

        imitates, seeds = self.policy == IMITATOR, self.random.seeds
        done = recalls.run_recalls(
            self.random.arena,
            memories_of([self.experience]) if imitates else None,
            np.full(len(seeds), 0 if imitates else recalls.TEACHER),
            np.array(seeds, np.int64),
            **self._arguments,
        )
        columns = (getattr(done, name).tolist() for name in Result._fields)
        return list(map(Result, *columns))

    @property
    def _arguments(self) -> dict[str, Any]:
        """What environments and compiled recalls take."""
        return {
            "foods": self.random.foods,
            "limit": self.random.limit,
            "noise": Noise.none() if self.policy == NO_NOISE else Noise.laboratory(),
            "food_types": ODDS,
        }


def trained_imitator(seed: int) -> Vectors:
    """The experience of the imitator, trained in the compiled corridor with pickable food, as in the thesis."""
    from khepera_forage.rollouts.compiled.training import train_learners

    key = int(np.random.SeedSequence(seed, spawn_key=(5,)).generate_state(1)[0])
    return train_learners(1, "corridor", key, episodes=TRAININGS).experience_of(0).arrays()


def units(arenas: Sequence[RandomArena], experience: Vectors) -> list[ArenaRecalls]:
    """All recalls in random arenas."""
    return [
        ArenaRecalls(policy, k, arena, experience) for policy in POLICIES for k, arena in enumerate(arenas)
    ]
