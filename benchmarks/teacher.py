"""How reliably and how fast the teacher forages, and whether the task is trivial.

    python benchmarks/teacher.py --help

The teacher forages alone in the corridor and in the rectangle, for each type of food, from many random starts. A
second policy does SEARCH FOR FOOD where the teacher does ORIENT WITH FOOD. It must deliver nothing: otherwise ORIENT
would not matter.
"""

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from khepera_forage.experiments.arguments import Count, parse
from khepera_forage.experiments.figures import (
    OURS,
    SMALL,
    THESIS,
    WIDTH,
    entry,
    grid,
    legend,
    mark,
    new_figure,
)
from khepera_forage.experiments.measures import percent, pick, quantiles
from khepera_forage.experiments.page import Page, Picture, finish
from khepera_forage.experiments.processes import collect
from khepera_forage.experiments.statistics import Estimate
from khepera_forage.experiments.tables import Column, Table
from khepera_forage.policies import Observation, Policy, Teacher
from khepera_forage.rollouts.recall import recall, recall_env
from khepera_forage.task.food_tracking import is_finished
from khepera_forage.task.states import Behaviour, FoodType

if TYPE_CHECKING:
    from matplotlib.figure import Figure

TEACHER, NO_ORIENT = "teacher", "SEARCH for ORIENT"
ARENAS = ("corridor", "rectangle")
BLOCK = 25
"""Forages of one unit of work."""
_NOTE = (
    "Noise of the laboratory; the thesis's limits of 500 and 700 steps; the same random starts for every line of an "
    "arena. Shares are percentages with Wilson's 95 % interval. Shares of food treat two objects in one arena as "
    "independent; shares of forages need no such assumption. Settled: delivered, or known to be poisonous and left "
    "where it was. A forage is finished when all its food is settled or poison was brought home. Steps: median and, in "
    "brackets, 5th and 95th percentile of all forages, including those that reached the limit. The lines without "
    "ORIENT are a check: they must deliver nothing."
)


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


def page(rows: Sequence[Forage]) -> Page:
    """A table and a picture of all conditions."""
    columns = (
        Column("arena"),
        Column("food"),
        Column("policy"),
        Column("forages"),
        Column("food objects"),
        Column("food delivered (%)", estimate=True),
        Column("food settled (%)", estimate=True),
        Column("forages finished (%)", estimate=True),
        Column("poison brought home"),
        Column("steps", digits=0, estimate=True),
    )
    own = {condition: pick(rows, **condition._asdict()) for condition in CONDITIONS}
    table = Table(
        "teacher", "The teacher alone", _NOTE, columns, [(*c, *_summary(own[c])) for c in CONDITIONS]
    )
    return Page(
        "The teacher", [table, Picture("teacher", "food delivered and steps of a forage", _picture(own))]
    )


def _summary(rows: Sequence[Forage]) -> tuple[int | Estimate, ...]:
    foods = sum(row.foods for row in rows)
    return (
        len(rows),
        foods,
        percent(sum(row.delivered for row in rows), foods),
        _settled(rows),
        percent(sum(row.finished for row in rows), len(rows)),
        sum(row.poison_home for row in rows),
        quantiles([row.steps for row in rows]),
    )


def _settled(rows: Sequence[Forage]) -> Estimate:
    return percent(sum(row.delivered + row.left for row in rows), sum(row.foods for row in rows))


def _picture(own: dict[Condition, list[Forage]]) -> "Figure":
    figure = new_figure(WIDTH, 1.1 + 0.42 * len(own))
    left, right = figure.subplots(1, 2, sharey=True)
    for place, (condition, rows) in enumerate(reversed(own.items())):
        colour, marker = (THESIS, "s") if condition.policy == NO_ORIENT else (OURS, "o")
        # Without ORIENT food may lie about untouched: only the teacher's poison counts as settled when it is left.
        delivered = percent(sum(row.delivered for row in rows), sum(row.foods for row in rows))
        share = _settled(rows) if condition.food == FoodType.POISONOUS.name else delivered
        steps = quantiles([row.steps for row in rows])
        mark(left, share.value, place, share, colour, level=True, marker=marker)
        mark(right, steps.value, place, steps, colour, level=True, marker=marker)
    names = [f"{condition.arena}, {condition.food.lower()} food" for condition in reversed(own)]
    left.set_yticks(range(len(names)), names, fontsize=SMALL)
    left.set_ylim(-0.6, len(names) - 0.4)
    left.set_xlim(-4, 104)
    left.set_xlabel("food delivered, poison left alone (%)\nbars: Wilson's 95 % interval", fontsize=9)
    right.set_xlim(left=0)
    right.set_xlabel("steps of a forage (median)\nbars: 5th to 95th percentile", fontsize=9)
    entry(left, "teacher", OURS, "o")
    entry(left, "teacher that searches in place of orienting", THESIS, "s")
    grid(left, "x")
    grid(right, "x")
    count = len(next(iter(own.values())))
    legend(figure, left, f"{count} random starts each, noise of the laboratory")
    return figure


def main() -> int:
    """Run the benchmark."""
    forages = Count("forages", 500, 25, "random starts of each line", adds_units=True)
    given = parse("teacher", __doc__, forages)
    rows = collect(given, blocks(given.seed, given.forages), {Forage: "forages"})
    return finish(given, page(rows.of(Forage)))


if __name__ == "__main__":
    sys.exit(main())
