"""Forages of the teacher alone, with and without ORIENT WITH FOOD."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from khepera_forage.policies import Observation, Policy, Teacher
from khepera_forage.rollouts.recall import recall, recall_env
from khepera_forage.task.food_tracking import is_finished
from khepera_forage.task.states import Behaviour, FoodType

TEACHER, NO_ORIENT = "teacher", "SEARCH for ORIENT"
ARENAS = ("corridor", "rectangle")
BLOCK = 25
"""Forages of one unit of work."""


class Condition(NamedTuple):
    """What is repeated from many random starts.

    Attributes:
        arena: `corridor` or `rectangle`.
        food: Name of the type of all food there.
        policy: `TEACHER`, or `NO_ORIENT`: the teacher with ORIENT WITH FOOD replaced by SEARCH FOR FOOD.
    """

    arena: str
    food: str
    policy: str


CONDITIONS = tuple(
    Condition(arena, food, policy)
    for arena in ARENAS
    for food, policy in (
        (FoodType.PICKABLE.name, TEACHER),
        (FoodType.PUSHABLE.name, TEACHER),
        (FoodType.POISONOUS.name, TEACHER),
        (FoodType.PICKABLE.name, NO_ORIENT),
    )
)


@dataclass(frozen=True, slots=True)
class Forage:
    """One forage.

    Attributes:
        arena: `corridor` or `rectangle`.
        food: Name of the type of all food there.
        policy: `TEACHER` or `NO_ORIENT`.
        seed: Of the episode; the same places for every food and policy.
        steps: Until all food was delivered or known to be poisonous, or the limit was reached.
        limit: In steps, as in the thesis.
        foods: Food objects.
        delivered: Objects brought home, poison not counted.
        left: Objects known to be poisonous and not brought home.
        poison_home: Poisonous objects brought home.
        finished: Whether all food was delivered or known to be poisonous within the limit.
    """

    arena: str
    food: str
    policy: str
    seed: int
    steps: int
    limit: int
    foods: int
    delivered: int
    left: int
    poison_home: int
    finished: bool


@dataclass(frozen=True, slots=True)
class WithoutOrienting:
    """The teacher with SEARCH FOR FOOD in place of ORIENT WITH FOOD."""

    teacher: Teacher

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """The teacher's behaviour, or SEARCH FOR FOOD for ORIENT WITH FOOD."""
        behaviour = self.teacher.act(observation)
        return Behaviour.SEARCH_FOR_FOOD if behaviour == Behaviour.ORIENT_WITH_FOOD else behaviour


class Block(NamedTuple):
    """Some forages under one condition.

    Attributes:
        condition: Which.
        first: Number of the first forage.
        seeds: One a forage.
    """

    condition: Condition
    first: int
    seeds: tuple[int, ...]

    @property
    def key(self) -> str:
        """Condition and numbers of the forages."""
        return f"{' '.join(self.condition)} {self.first}-{self.first + len(self.seeds)}"

    def run(self) -> list[Forage]:
        """Forage from each start, in the laboratory's noise."""
        arena, food, name = self.condition
        env = recall_env(arena, food_types=food)
        teacher = Teacher.of(env)
        policy: Policy = teacher if name == TEACHER else WithoutOrienting(teacher)
        rows = []
        for seed in self.seeds:
            row = recall(env, policy, seed, learner=name)
            tracker = env.forager.tracker
            poisonous = sum(food.known == FoodType.POISONOUS for food in tracker.foods)
            rows.append(
                Forage(
                    arena=arena,
                    food=food,
                    policy=name,
                    seed=seed,
                    steps=row.steps,
                    limit=row.limit,
                    foods=row.foods,
                    delivered=row.delivered,
                    left=poisonous - row.poison_home,
                    poison_home=row.poison_home,
                    finished=is_finished(tracker),
                )
            )
        env.close()
        return rows


def blocks(seed: int, forages: int) -> list[Block]:
    """All work; every condition of an arena has the same starts."""
    work = []
    for condition in CONDITIONS:
        seeds = np.random.SeedSequence(seed, spawn_key=(ARENAS.index(condition.arena),))
        numbers = seeds.generate_state(forages).tolist()
        work += [Block(condition, i, tuple(numbers[i : i + BLOCK])) for i in range(0, forages, BLOCK)]
    return work
