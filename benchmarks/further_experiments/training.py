"""Three experiments on what is trained with: types of food, places of the set-up, and robots that differ."""

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from itertools import count, product
from typing import Any

import numpy as np

import further_experiments.common as fw
from khepera_forage.counter_rng import key_of
from khepera_forage.envs.arguments import PYMUNK, FoodOdds, checked_arena, timing_of
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.layouts import random_layout
from khepera_forage.estimates import MIN_REPLICATIONS, Estimate, Sample, combined, percent, pick, replications
from khepera_forage.policies import Teacher
from khepera_forage.policies.policy import UniformPolicy
from khepera_forage.robots.parameters import RobotParameters
from khepera_forage.sim.arena import Arena, copies
from khepera_forage.sim.arenas.thesis import CORRIDOR
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.task.decisions import DEFAULT_DECISIONS, DEFAULT_VALUES
from khepera_forage.task.placement import layout_key
from khepera_forage.thesis.claims import Claim, at_most, percent_change, points
from khepera_forage.vision.scene import MM_PER_PIXEL

FOOD: dict[str, FoodOdds] = {
    "pickable": "PICKABLE",
    "pushable": "PUSHABLE",
    "poisonous": "POISONOUS",
    "mixed": {"PICKABLE": 1.0, "PUSHABLE": 1.0, "POISONOUS": 1.0},
}
MAX_POISON_HOME = 5.0
"""Percent of the food that a learner may bring home as poison and still count as one that avoids poison."""


def train_with_food(trial: fw.Trial) -> list[fw.Row]:
    """Training and recall with one kind of food. The policy with 0 episodes draws behaviours at random."""
    odds = FOOD[trial.condition]
    learners = partial(fw.imitators, untrained=UniformPolicy())
    alone = partial(trial.alone, food_types=odds)
    return fw.train_and_recall(trial, learners, alone, env=trial.env(food_types=odds))


def food_claims(found: fw.Analysis) -> Iterator[Claim]:
    """Whether the thesis's conclusions hold for every kind of food."""
    (first, second), (before, last) = found.amounts[:2], found.amounts[-2:]
    for food in FOOD:
        rows = pick(found.recalls, condition=food)
        for arena in fw.ARENAS:
            many, few = (pick(rows, arena=arena, amount=amount) for amount in (last, first))
            yield found.compared(f"{food}, {arena}: more episodes improve the learner", many, few, fw.SCORE)
        # The gain of the first episodes minus that of the last ones: positive where the gain shrinks.
        early, late = 1.0 / (second - first), 1.0 / (last - before)
        terms = [
            (weight, Sample(pick(rows, arena=CORRIDOR, amount=amount), fw.SCORE.value))
            for weight, amount in ((early, second), (-early, first), (-late, last), (late, before))
        ]
        effect = combined(terms, found.rng)
        yield Claim(f"{food}, corridor: the gain from an episode shrinks", "", effect, fw.POSITIVE, points)
        learned, chance = (pick(rows, arena="rectangle", amount=amount) for amount in (last, 0))
        effect = found.difference(learned, chance, fw.SETTLED).times(0.01)
        name = f"{food}: trained in the corridor, it forages in the rectangle"
        yield Claim(name, "", effect, fw.POSITIVE, percent_change)
        if food in ("poisonous", "mixed"):
            home = _poison_home(found, pick(rows, amount=last))
            yield Claim(f"{food}: the learner leaves poison alone", "", home, at_most(MAX_POISON_HOME), fw.PERCENT)


def _poison_home(found: fw.Analysis, rows: Sequence[fw.RecallEpisode]) -> Estimate:
    """The share of poison brought home. Where there was none, resampling would give an interval without width."""
    if any(row.poison_home for row in rows) or len(replications(rows)) < MIN_REPLICATIONS:
        return found.mean(rows, fw.POISON_HOME)
    return percent(0, sum(row.foods for row in rows))


PUSH_AND_AVOID = fw.Experiment(
    "push_and_avoid",
    "Pushing and avoiding",
    "5.5, 6.2",
    "Do the thesis's conclusions about picking up hold for pushing and avoiding, too?",
    "Training in the corridor and recall in both arenas: with each type of food alone, and with the type of every "
    "object drawn at equal odds. A training episode with poison is complete when both robots have left it.",
    conditions=tuple(FOOD),
    run=train_with_food,
    claims=food_claims,
    picture=(fw.SCORE, fw.SETTLED),
    recalls=(
        "Noise of the laboratory. Settled: delivered, or known to be poisonous and not brought home. 0 episodes: every "
        "behaviour drawn at random. A recall ends when all food is settled or was brought home as poison.",
        (fw.SCORE, fw.SETTLED, fw.POISON_HOME, fw.STEPS),
    ),
    trainings=("Per complete episode.", (fw.ATTEMPTS, fw.ROUNDS, fw.TRUE)),
)

ONE, MOVED, ALL = "one set-up", "food moved", "start and food moved"
_AHEAD = DEFAULT_DECISIONS.close_to_food * MM_PER_PIXEL + 10.0
"""mm from the start of figure 5.1 to the nearest food: further than the close threshold, as in recall."""


def setups(condition: str, rng: np.random.Generator) -> Iterator[Mapping[str, Any]]:
    """Start and food of one training episode after another.

    `ONE`: always as in figure 5.1; `MOVED`: the start of figure 5.1, food at random; `ALL`: start and food at random,
    as in recall.
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


def train_with_setups(trial: fw.Trial) -> list[fw.Row]:
    """Training episodes of one kind, and recalls after some of them and after all."""
    seeds, places = trial.seeds(2)
    marks = setups(trial.condition, np.random.default_rng(places))
    return fw.train_and_recall(trial, seeds=seeds.spawn(trial.size.files), setups=marks)


def setup_claims(found: fw.Analysis) -> Iterator[Claim]:
    """Whether variety helps with the same number of episodes, and with fewer."""
    half, last = found.amounts[-2:]
    for arena, condition in product(fw.ARENAS, (MOVED, ALL)):
        for various, statement in (
            (last, "variety helps"),
            (half, f"variety is worth more than quantity ({half} episodes against {last})"),
        ):
            rows = pick(found.recalls, condition=condition, amount=various, arena=arena)
            others = pick(found.recalls, condition=ONE, amount=last, arena=arena)
            yield found.compared(f"{condition}, {arena}: {statement}", rows, others, fw.SCORE)


SPATIAL_VARIETY = fw.Experiment(
    "spatial_variety",
    "Spatial variety",
    "5.5, 6.2",
    "Is variety of the training episodes worth as much as their quantity, or more?",
    "Three learners with the same number of training episodes in the corridor: with the set-up of figure 5.1, with the "
    "food at a random place ahead, and with start and food at random places. A failed attempt is repeated with the "
    "same set-up.",
    conditions=(ONE, MOVED, ALL),
    run=train_with_setups,
    claims=setup_claims,
    picture=(fw.SCORE, fw.DELIVERED),
    recalls=(
        "Noise of the laboratory; random places, the same for every line of an arena.",
        (fw.SCORE, fw.DELIVERED, fw.STEPS, fw.VECTORS, fw.DISTINCT),
    ),
    trainings=("Per complete episode.", (fw.ATTEMPTS, fw.ROUNDS, fw.TRUE)),
    places=True,
)

ROBOTS = {
    "same robot": RobotParameters(),
    "infra-reds at 30 %": RobotParameters(infra_red_gain=0.3),
    "blind infra-reds": RobotParameters(infra_red_gain=0.0),
    "left wheel 20 % slow": RobotParameters(left_wheel_error=-0.2),
    "left wheel 30 % slow": RobotParameters(left_wheel_error=-0.3),
    "fingers of 30 mm": RobotParameters(finger_length=30.0),
    "arm reads 231 when raised": RobotParameters(arm_reading_scale=0.6),
}


def train_robot(trial: fw.Trial) -> list[fw.Row]:
    """Forage with the teacher's program on this robot; train this robot, and forage with what it recorded."""
    robot, decisions = ROBOTS[trial.condition], DEFAULT_DECISIONS

    def world(arenas: Sequence[Arena], markers: Sequence[int], *robots: RobotParameters) -> dict[str, Any]:
        timing = timing_of(decisions)
        return {"backend": PYMUNK, "world": PymunkWorld(arenas, markers, robot_parameters=robots, timing=timing)}

    def alone(arena: str) -> BehavioursEnv:
        return trial.alone(arena, **world([checked_arena(arena, decisions)], [decisions.recall_marker], robot))

    pair = world(copies(checked_arena(CORRIDOR, decisions), 2), (1, 2), RobotParameters(), robot)
    learners = partial(fw.imitators, untrained=Teacher())
    return fw.train_and_recall(trial, learners, alone, env=trial.env(**pair), may_fail=True)


def robot_claims(found: fw.Analysis) -> Iterator[Claim]:
    """Which robot forages better by imitating than by copying."""
    for robot, arena in product(ROBOTS, fw.ARENAS):
        rows = pick(found.recalls, condition=robot, arena=arena)
        last = max(fw.amounts_of(rows), default=None)  # there is none for a robot that was never trained
        copied, imitated = (pick(rows, amount=amount) for amount in (0, last))
        yield found.compared(f"{robot}, {arena}: imitating delivers more than copying", imitated, copied, fw.DELIVERED)


DIFFERENT_ROBOTS = fw.Experiment(
    "different_robots",
    "Different robots",
    "1.2, 6.3",
    "On a robot that differs from the teacher, is it better to imitate the teacher's program than to copy it?",
    "The learner differs from the teacher in one parameter. Copied: the teacher's decision tree runs on that robot. "
    "Imitated: that robot is trained beside a standard teacher, and recalls. An arm that reads 231 when it is raised "
    "changes what the robot perceives, because figure 4.2 expects 225 or less; the others change what behaviours do.",
    conditions=tuple(ROBOTS),
    run=train_robot,
    claims=robot_claims,
    picture=(fw.DELIVERED, fw.SCORE),
    recalls=(
        "0 episodes: the teacher's program, copied. A copy always scores 100 % less its penalty, because the score "
        "compares it with the same program. Compare the food delivered.",
        (fw.DELIVERED, fw.SCORE, fw.STEPS),
    ),
    trainings=(
        "The teacher is a standard robot. A learner whose training episode failed a hundred times in a row gets no "
        "further episodes.",
        (fw.ATTEMPTS, fw.ROUNDS, fw.TRUE),
    ),
)
