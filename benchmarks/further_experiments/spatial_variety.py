"""Spatial variety: training episodes from one set-up, or from several (5.5, 6.2)."""

import math
from collections.abc import Iterator, Mapping
from itertools import count
from typing import Any

import numpy as np

from further_experiments.analysis import (
    ATTEMPTS,
    DELIVERED,
    DISTINCT,
    FOOD_POINTS,
    ROUNDS,
    SCORE,
    STEPS,
    TRUE,
    VECTORS,
    Analysis,
    claim,
)
from further_experiments.episodes import ARENAS, recall_everywhere, train_files, training_seeds
from further_experiments.experiment import Experiment, Report, Trial
from further_experiments.pictures import INTERVALS, curves
from further_experiments.rows import Row
from khepera_forage.counter_rng import key_of
from khepera_forage.envs.arguments import checked_arena
from khepera_forage.envs.layouts import random_layout
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.estimates import pick
from khepera_forage.figures import legend, panels
from khepera_forage.sim.arenas.thesis import CORRIDOR
from khepera_forage.task.decisions import DEFAULT_DECISIONS, DEFAULT_VALUES
from khepera_forage.task.placement import layout_key
from khepera_forage.thesis.claims.claim import Above, Claim, points
from khepera_forage.vision.scene import MM_PER_PIXEL

ONE, FOOD, ALL = "one set-up", "food moved", "start and food moved"
_AHEAD = DEFAULT_DECISIONS.close_to_food * MM_PER_PIXEL + 10.0
"""mm from the start of figure 5.1 to the nearest food: further than the close threshold, as in recall."""


def setups(condition: str, rng: np.random.Generator) -> Iterator[Mapping[str, Any]]:
    """Start and food of one training episode after another.

    Args:
        condition: `ONE`: always as in figure 5.1; `FOOD`: the start of figure 5.1, food at random; `ALL`: start and
            food at random, as in recall.
        rng: Draws the places.
    """
    key, corridor = key_of(int(rng.integers(2**62))), checked_arena(CORRIDOR, DEFAULT_DECISIONS)
    for number in count():
        layout = random_layout(corridor, 1, layout_key(key, number), DEFAULT_VALUES)
        start, foods = layout.starts[0], layout.foods
        if condition == ONE:
            yield {}
        elif condition == ALL:
            yield {"start": (start.x, start.y, math.degrees(start.heading)), "foods": foods}
        elif foods[0].x > corridor.start.x + _AHEAD:
            yield {"foods": foods}


def run(trial: Trial) -> list[Row]:
    """Training episodes of one kind, and recalls after some of them and after all."""
    seeds, places = training_seeds(trial).spawn(2)
    env = TrainingEnv(max_cycles=trial.size.rounds)
    marks = setups(trial.condition, np.random.default_rng(places))
    trained = list(train_files(env, trial, seeds.spawn(trial.size.files), setups=marks))
    env.close()
    recalls = recall_everywhere(trial, [experience for experience, _ in trained])
    return [*(row for _, row in trained), *recalls]


def report(found: Analysis) -> Report:
    """Whether variety helps with the same number of episodes, and with fewer."""
    half, last = found.amounts[-2:]
    claims = [
        _claim(found, arena, condition, various, last)
        for arena in ARENAS
        for condition in (FOOD, ALL)
        for various in (last, half)
    ]
    tables = (
        found.recall_table(
            "Noise of the laboratory; random places, the same for every line of an arena.",
            (SCORE, DELIVERED, STEPS, VECTORS, DISTINCT),
        ),
        found.training_table("Per complete episode.", (ATTEMPTS, ROUNDS, TRUE)),
        found.places_table(last),
    )
    figure, axes = panels(4, "Training episodes from one set-up, and from several")
    for i, arena in enumerate(ARENAS):
        own = pick(found.recalls, arena=arena)
        curves(axes[2 * i], found, own, SCORE, "training episodes", arena)
        curves(axes[2 * i + 1], found, own, DELIVERED, "training episodes", arena)
    legend(figure, axes[0], INTERVALS)
    return Report(claims, tables, figure)


def _claim(found: Analysis, arena: str, condition: str, various: int, same: int) -> Claim:
    """Some episodes from several set-ups against as many or more from one."""
    rows = pick(found.recalls, condition=condition, amount=various, arena=arena)
    others = pick(found.recalls, condition=ONE, amount=same, arena=arena)
    name = (
        "variety helps"
        if various == same
        else f"variety is worth more than quantity ({various} episodes against {same})"
    )
    food = FOOD_POINTS.estimate(found.difference(rows, others, DELIVERED))
    return claim(
        f"{condition}, {arena}: {name}",
        "5.5",
        found.difference(rows, others, SCORE),
        Above(0.0),
        points,
        f"Mean score {found.percent(rows, SCORE)} after {various} episodes with {condition} and "
        f"{found.percent(others, SCORE)} after {same} with one set-up; food delivered {found.percent(rows)} and "
        f"{found.percent(others)}, {food}.",
    )


EXPERIMENT = Experiment(
    "spatial_variety",
    "Spatial variety",
    "5.5, 6.2",
    "Is variety of the training episodes worth as much as their quantity, or more?",
    "Three learners with the same number of training episodes in the corridor. The first has the set-up of figure 5.1 "
    "in all of them, the second has the food at a random place ahead in each, and the third has start and food at "
    "random places in each, as in recall. All recall in both arenas. A failed attempt is repeated with the same "
    "set-up.",
    (ONE, FOOD, ALL),
    run,
    report,
)
