"""Forages of the teacher alone: conditions, rows, and blocks of work for any number of processes."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from khepera_forage.policies import Observation, Policy, Teacher
from khepera_forage.rollouts.recall import recall, recall_env
from khepera_forage.task.states import Behaviour, FoodType

TEACHER, NO_ORIENT = "teacher", "SEARCH for ORIENT"
ARENAS = ("corridor", "rectangle")
BLOCK = 25
"""Forages in one piece of work."""


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
    for policy, foods in (
        (TEACHER, (FoodType.PICKABLE, FoodType.PUSHABLE, FoodType.POISONOUS)),
        (NO_ORIENT, (FoodType.PICKABLE,)),
    )
    for food in (food.name for food in foods)
)


@dataclass(frozen=True, slots=True)
class Forage:
    """One forage.

    Attributes:
        arena: `corridor` or `rectangle`.
        food: Name of the type of all food there.
        policy: Who foraged.
        seed: Of the episode; the same places for every food and policy.
        steps: Until all food was delivered or known to be poisonous, or the limit was reached.
        limit: In steps, the thesis' own.
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
    """Decides as the teacher does, but searches where the teacher would orient."""

    teacher: Teacher

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """The teacher's behaviour, or SEARCH FOR FOOD for ORIENT WITH FOOD."""
        behaviour = self.teacher.act(observation)
        return Behaviour.SEARCH_FOR_FOOD if behaviour == Behaviour.ORIENT_WITH_FOOD else behaviour


@dataclass(frozen=True, slots=True)
class Block:
    """Some forages under one condition.

    Attributes:
        condition: Which.
        seeds: One a forage.
    """

    condition: Condition
    seeds: tuple[int, ...]

    def run(self) -> list[Forage]:
        """Forage from each start, in the laboratory's noise."""
        arena, food, policy = self.condition
        env = recall_env(arena, food_types=food)
        teacher = Teacher(env.home_radius)
        who: Policy = teacher if policy == TEACHER else WithoutOrienting(teacher)
        rows = []
        for seed in self.seeds:
            row = recall(env, who, seed, learner=policy)
            register = env.forager.register
            left = sum(kind == FoodType.POISONOUS for kind in register.known) - row.poison_home
            rows.append(
                Forage(
                    arena=arena,
                    food=food,
                    policy=policy,
                    seed=seed,
                    steps=row.steps,
                    limit=row.limit,
                    foods=row.foods,
                    delivered=row.delivered,
                    left=left,
                    poison_home=row.poison_home,
                    finished=register.finished,
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
        work += [Block(condition, tuple(numbers[i : i + BLOCK])) for i in range(0, forages, BLOCK)]
    return work
