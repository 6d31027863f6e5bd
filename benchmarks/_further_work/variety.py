"""Experiment 3: as many episodes from one set-up as from several (5.5, 6.2)."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from _further_work.experiment import Experiment, Report
from _further_work.measures import (
    ATTEMPTS,
    DELIVERED,
    DISTINCT,
    ROUNDS,
    SCORE,
    STEPS,
    TRUE,
    VECTORS,
    amounts_of,
    difference,
    mean,
    means_table,
    pick,
)
from _further_work.phases import ARENAS, imitator, learn, recall_all, training_seeds
from _further_work.pictures import curves, legend, panels
from _further_work.rows import Done, Recalled, Unit
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.rollouts.recall import recall_env
from khepera_forage.sim.arena import CORRIDOR
from khepera_forage.task.placement import random_layout
from khepera_forage.thesis.claims.claim import Above, Claim, judged, points
from khepera_forage.thesis.claims.claim import Unit as Scale
from khepera_forage.thesis.tables import Table

ONE, FOOD, ALL = "one set-up", "food moved", "start and food moved"
_percent = Scale("%", ".1f")
_food = Scale("points of food delivered", "+.1f")


def setups(condition: str, rng: np.random.Generator) -> Iterator[Mapping[str, Any]]:
    """The marks of one lesson after another.

    Args:
        condition: `ONE`: those of figure 5.1 always; `FOOD`: the start of figure 5.1, food at random; `ALL`: start and
            food at random, as in recall.
        rng: Draws the places.
    """
    while True:
        layout = random_layout(CORRIDOR, 1, rng)
        start, foods = layout.starts[0], layout.foods
        if condition == ONE:
            yield {}
        elif condition == ALL:
            yield {"start": (start.x, start.y, math.degrees(start.heading)), "foods": foods}
        elif foods[0].x > CORRIDOR.start.x + _AHEAD:
            yield {"foods": foods}


_PLACES = (
    ("nearer home", -math.inf, -5.0),
    ("about as in training", -5.0, 15.0),
    ("further out", 15.0, math.inf),
)
"""Pixels beyond the mark of figure 5.1."""
_AHEAD = 160.0
"""mm from the start of figure 5.1 to the nearest food: further than the close threshold, as in recall."""


def run(unit: Unit) -> Done:
    """Lessons of one kind of variety, and recalls after some of them and after all."""
    seeds, places = training_seeds(unit).spawn(2)
    env = TrainingEnv()
    marks = setups(unit.condition, np.random.default_rng(places))
    taught = list(learn(env, unit, seeds.spawn(unit.size.files), setups=marks))
    env.close()
    files = [experience for experience, _ in taught]
    recalls: list[Recalled] = []
    for arena in ARENAS:
        alone = recall_env(arena)
        for amount in unit.size.amounts:
            learner = imitator(files[:amount], alone.diagonal)
            recalls += recall_all(alone, learner, unit, amount, files[:amount])
        alone.close()
    return Done(tuple(lesson for _, lesson in taught), tuple(recalls))


def report(done: Done, rng: np.random.Generator) -> Report:
    """Whether variety helps at the same quantity, and at less of it."""
    amounts = amounts_of(done.recalls)
    half, last = amounts[-2], amounts[-1]
    claims = tuple(
        claim
        for arena in ARENAS
        for condition in (FOOD, ALL)
        for claim in (
            _claim(done, arena, condition, last, last, rng),
            _claim(done, arena, condition, half, last, rng),
        )
    )
    tables: tuple[Table, ...] = (
        means_table(
            "recalls",
            "Recall",
            "Noise of the laboratory, random places, the same for every line of an arena.",
            "episodes",
            done.recalls,
            (SCORE, DELIVERED, STEPS, VECTORS, DISTINCT),
            rng,
        ),
        means_table(
            "lessons",
            "Training",
            "What one complete episode took and left.",
            "files",
            done.lessons,
            (ATTEMPTS, ROUNDS, TRUE),
            rng,
        ),
    )
    tables += (_by_place(done, last, rng),)
    figure, axes = panels(4, "Spatial variety: the same number of episodes from one set-up and from several")
    for i, arena in enumerate(ARENAS):
        own = pick(done.recalls, arena=arena)
        curves(axes[2 * i], own, SCORE, "training episodes", rng, arena)
        curves(axes[2 * i + 1], own, DELIVERED, "training episodes", rng, arena)
    legend(figure, axes[0])
    return Report(claims, tables, figure)


def _by_place(done: Done, amount: int, rng: np.random.Generator) -> Table:
    """Recall in the corridor by where the food lay."""
    rows = [
        replace(row, condition=f"{row.condition}; food {where}")
        for condition in (ONE, FOOD, ALL)
        for where, low, high in _PLACES
        for row in pick(done.recalls, condition, amount, "corridor")
        if low <= row.beyond < high
    ]
    return means_table(
        "places",
        "Where the food lay",
        "Recall in the corridor by how far from home the food lay, in pixels of 5 mm beyond (or short of) "
        "the mark of "
        "figure 5.1.",
        "episodes",
        rows,
        (SCORE, DELIVERED),
        rng,
    )


def _claim(
    done: Done, arena: str, condition: str, various: int, same: int, rng: np.random.Generator
) -> Claim:
    """Episodes from several set-ups against as many or more from one."""
    rows, others = pick(done.recalls, condition, various, arena), pick(done.recalls, ONE, same, arena)
    what = (
        "variety helps"
        if various == same
        else f"variety is worth more than quantity ({various} against {same})"
    )
    food = _food.estimate(difference(rows, others, DELIVERED, rng))
    return judged(
        f"{condition}, {arena}: {what}",
        "5.5",
        difference(rows, others, SCORE, rng),
        Above(0.0),
        points,
        "",
        f"Mean score {_percent(mean(rows, SCORE, rng).value)} after {various} episodes with {condition} and "
        f"{_percent(mean(others, SCORE, rng).value)} after {same} from one set-up; food delivered "
        f"{_percent(mean(rows, DELIVERED, rng).value)} and {_percent(mean(others, DELIVERED, rng).value)}, "
        f"{food}.",
    )


EXPERIMENT = Experiment(
    "variety",
    "Spatial variety",
    "5.5, 6.2",
    "Is variety of the training episodes worth as much as, or more than, their quantity?",
    "Learners with as many training episodes in the corridor: all from the set-up of figure 5.1; with the "
    "food at a random "
    "place ahead in each; and with start and food at random places in each, as in recall. Then recall in "
    "both arenas. "
    "An attempt that fails is repeated in the same set-up.",
    (ONE, FOOD, ALL),
    run,
    report,
)
