"""Recalls of the teacher in one arena, with the same seeds on both backends."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from khepera_forage.envs.arguments import set_up_of
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.noise import Noise
from khepera_forage.policies import Teacher
from khepera_forage.rollouts.recall import recall
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.sim.arenas.named import FAMILY, named_arena
from khepera_forage.sim.arenas.procedural import ProceduralArenas
from khepera_forage.task.decisions import DEFAULT_DECISIONS
from khepera_forage.task.states import FoodType

PYMUNK, COMPILED = "pymunk", "compiled"
ONE_THIRD_EACH = "a third each"
FOODS: dict[str, Any] = {
    "PICKABLE": FoodType.PICKABLE,
    "PUSHABLE": FoodType.PUSHABLE,
    ONE_THIRD_EACH: {FoodType.PICKABLE: 1.0, FoodType.PUSHABLE: 1.0, FoodType.POISONOUS: 1.0},
}
"""Odds of food types, by the name in tables."""
GROUPS = (*FAMILY, *DIFFICULTIES)
"""The named arenas, and the difficulties of procedural ones."""


@dataclass(frozen=True, slots=True)
class Delivery:
    """One recall on one backend.

    Attributes:
        group: A named arena, or a difficulty.
        arena: Number of the arena in its group.
        food: A name in `FOODS`.
        seed: Of the episode.
        backend: `pymunk` or `compiled`.
        deliverable: Food objects that are not poisonous.
        poisonous: Food objects that are.
        delivered: Food brought home that is not poisonous.
        poison_home: Poisonous food brought home.
        steps: How many it took.
    """

    group: str
    arena: int
    food: str
    seed: int
    backend: str
    deliverable: int
    poisonous: int
    delivered: int
    poison_home: int
    steps: int

    @property
    def replication(self) -> int:
        """Intervals resample arenas; of a single arena, recalls."""
        return self.seed if self.group in FAMILY else self.arena


class ArenaRecalls(NamedTuple):
    """Recalls in one arena, with one kind of food.

    Attributes:
        group: A name in `GROUPS`.
        arena: Number of the arena in its group.
        food: A name in `FOODS`.
        seeds: Of the episodes.
    """

    group: str
    arena: int
    food: str
    seeds: tuple[int, ...]

    @property
    def key(self) -> str:
        """Arena, food and seeds."""
        return f"{self.group} {self.arena}, {self.food}, seeds {self.seeds[0]} to {self.seeds[-1]}"

    def run(self) -> list[Delivery]:
        """Recall with every seed on both backends."""
        arguments = {**_arguments(self.group, self.arena), "food_types": FOODS[self.food]}
        env = BehavioursEnv(**arguments)
        policy, foods = Teacher.of(env), arguments["foods"]
        rows, deliverable = [], []
        for seed in self.seeds:
            row = recall(env, policy, seed, learner="teacher")
            types = [food.type for food in env.forager.tracker.foods]
            deliverable.append(foods - types.count(FoodType.POISONOUS))
            rows.append(
                self._delivery(
                    seed, PYMUNK, foods, deliverable[-1], row.delivered, row.poison_home, row.steps
                )
            )
        env.close()
        return rows + self._compiled(arguments, deliverable)

    def _compiled(self, arguments: dict[str, Any], deliverable: Sequence[int]) -> list[Delivery]:
        from khepera_forage.rollouts.compiled import recalls

        given = dict(arguments)
        arena, count = given.pop("arena"), len(self.seeds)
        policies, seeds = np.full(count, recalls.TEACHER), np.array(self.seeds, np.int64)
        done = recalls.run_recalls(arena, None, policies, seeds, **given)
        columns = (done.delivered.tolist(), done.poison_home.tolist(), done.steps.tolist())
        return [
            self._delivery(seed, COMPILED, arguments["foods"], *numbers)
            for seed, *numbers in zip(self.seeds, deliverable, *columns, strict=True)
        ]

    def _delivery(self, seed: int, backend: str, foods: int, deliverable: int, *numbers: int) -> Delivery:
        delivered, poison_home, steps = numbers
        poisonous = foods - deliverable
        return Delivery(
            *(self.group, self.arena, self.food, seed, backend),
            *(deliverable, poisonous, delivered, poison_home, steps),
        )


def units(seed: int, levels: int, recalls: int) -> list[ArenaRecalls]:
    """All recalls.

    Args:
        seed: Of the first episode of every arena.
        levels: Test levels of each difficulty, with one recall each.
        recalls: Recalls in each named arena.
    """
    many = tuple(range(seed, seed + recalls))
    named = [ArenaRecalls(group, 0, food, many) for group in FAMILY for food in FOODS]
    return named + [
        ArenaRecalls(group, level, food, (seed + level,))
        for group in DIFFICULTIES
        for food in FOODS
        for level in range(levels)
    ]


def _arguments(group: str, number: int) -> dict[str, Any]:
    """What environments take in an arena of a group."""
    if group in FAMILY:
        arena: Arena = named_arena(group, set_up_of(DEFAULT_DECISIONS))
        foods, limit, noise = len(arena.foods), FAMILY[group].limit, Noise.laboratory()
    else:
        difficulty = DIFFICULTIES[group]
        arena = ProceduralArenas(group, "test", num_levels=number + 1)[number]
        foods, limit, noise = difficulty.foods, difficulty.limit, difficulty.scaled_noise()
    return {"arena": arena, "foods": foods, "limit": limit, "noise": noise}
