"""Three experiments on what is trained with: types of food, places of the set-up, and robots that differ."""

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import count
from typing import Any

import numpy as np

import further_experiments.common as fw
from khepera_forage.counter_rng import key_of
from khepera_forage.envs.arguments import FoodOdds, checked_arena, timing_of
from khepera_forage.envs.layouts import random_layout
from khepera_forage.estimates import MIN_REPLICATIONS, UNKNOWN, Estimate, Sample, combined, percent, pick, replications
from khepera_forage.experience import Experience
from khepera_forage.figures import legend, levels, panels
from khepera_forage.policies import Teacher
from khepera_forage.policies.policy import UniformPolicy
from khepera_forage.robots.parameters import RobotParameters
from khepera_forage.rollouts.training import IncompleteTrainingError
from khepera_forage.sim.arena import copies
from khepera_forage.sim.arenas.thesis import CORRIDOR
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.task.decisions import DEFAULT_DECISIONS, DEFAULT_VALUES
from khepera_forage.task.placement import layout_key
from khepera_forage.thesis.claims import Claim, above, at_most, percent_change, points
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
    files, trainings = fw.all_files(trial, trial.env(food_types=odds))
    recalls: list[fw.RecallEpisode] = []
    for arena in fw.ARENAS:
        env = trial.alone(arena, food_types=odds)
        recalls += fw.recall_all(env, UniformPolicy(), trial)
        recalls += fw.recall_imitators(env, trial, files)
    return [*trainings, *recalls]


def report_food(found: fw.Analysis) -> fw.Report:
    """Whether the thesis's conclusions hold for every kind of food."""
    note = (
        "Noise of the laboratory. Settled: delivered, or known to be poisonous and not brought home. 0 episodes: every "
        "behaviour drawn at random. A recall ends when all food is settled or was brought home as poison."
    )
    tables = (
        found.recall_table(note, (fw.SCORE, fw.SETTLED, fw.POISON_HOME, fw.STEPS)),
        found.training_table("Per complete episode.", (fw.ATTEMPTS, fw.ROUNDS, fw.TRUE)),
    )
    figure = fw.score_and_food(found, "Pushing and avoiding food", fw.SETTLED)
    return [made for food in FOOD for made in _food_claims(found, food)], tables, figure


def _food_claims(found: fw.Analysis, food: str) -> Iterator[Claim]:
    rows = pick(found.recalls, condition=food)
    amounts = fw.amounts_of(rows)
    first, second, before, last = (*amounts[:2], *amounts[-2:])
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
    yield Claim(f"{food}, corridor: the gain from an episode shrinks", "", effect, above(0.0), points)
    learned, chance = (pick(rows, arena="rectangle", amount=amount) for amount in (last, 0))
    effect = Estimate(*(value / 100 for value in found.difference(learned, chance, fw.SETTLED)))
    name = f"{food}: trained in the corridor, it forages in the rectangle"
    yield Claim(name, "", effect, above(0.0), percent_change)
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
    tuple(FOOD),
    train_with_food,
    report_food,
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
    files, trainings = fw.all_files(trial, seeds=seeds.spawn(trial.size.files), setups=marks)
    rows: list[fw.Row] = [*trainings]
    for arena in fw.ARENAS:
        rows += fw.recall_imitators(trial.alone(arena), trial, files)
    return rows


def report_setups(found: fw.Analysis) -> fw.Report:
    """Whether variety helps with the same number of episodes, and with fewer."""
    half, last = found.amounts[-2:]
    claims = []
    for arena in fw.ARENAS:
        for condition in (MOVED, ALL):
            for various in (last, half):
                rows = pick(found.recalls, condition=condition, amount=various, arena=arena)
                others = pick(found.recalls, condition=ONE, amount=last, arena=arena)
                name = f"variety is worth more than quantity ({various} episodes against {last})"
                name = f"{condition}, {arena}: {'variety helps' if various == last else name}"
                claims.append(found.compared(name, rows, others, fw.SCORE))
    tables = (
        found.recall_table(
            "Noise of the laboratory; random places, the same for every line of an arena.",
            (fw.SCORE, fw.DELIVERED, fw.STEPS, fw.VECTORS, fw.DISTINCT),
        ),
        found.training_table("Per complete episode.", (fw.ATTEMPTS, fw.ROUNDS, fw.TRUE)),
        found.places_table(last),
    )
    return claims, tables, fw.score_and_food(found, "Training episodes from one set-up, and from several")


SPATIAL_VARIETY = fw.Experiment(
    "spatial_variety",
    "Spatial variety",
    "5.5, 6.2",
    "Is variety of the training episodes worth as much as their quantity, or more?",
    "Three learners with the same number of training episodes in the corridor: with the set-up of figure 5.1, with the "
    "food at a random place ahead, and with start and food at random places. A failed attempt is repeated with the "
    "same set-up.",
    (ONE, MOVED, ALL),
    train_with_setups,
    report_setups,
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
    robot = ROBOTS[trial.condition]
    decisions, timing = DEFAULT_DECISIONS, timing_of(DEFAULT_DECISIONS)
    corridors = copies(checked_arena(CORRIDOR, decisions), 2)
    pair = PymunkWorld(corridors, (1, 2), robot_parameters=(RobotParameters(), robot), timing=timing)
    rows: list[fw.Row] = []
    files: list[Experience] = []
    try:
        for experience, row in fw.train_files(trial.env(world=pair), trial, trial.seeds(trial.size.files)):
            files.append(experience)
            rows.append(row)
    except IncompleteTrainingError:
        pass  # A result: training this robot hardly ever succeeds.
    for arena in fw.ARENAS:
        places, markers = [checked_arena(arena, decisions)], (decisions.recall_marker,)
        world = PymunkWorld(places, markers, robot_parameters=(robot,), timing=timing)
        alone = trial.alone(arena, world=world)
        rows += fw.recall_all(alone, Teacher.of(alone), trial)
        rows += fw.recall_imitators(alone, trial, files)
    return rows


def report_robots(found: fw.Analysis) -> fw.Report:
    """Which robot forages better by imitating than by copying."""
    claims = []
    for robot in ROBOTS:
        for arena in fw.ARENAS:
            rows = pick(found.recalls, condition=robot, arena=arena)
            last = max(fw.amounts_of(rows), default=0)
            copied, imitated = (pick(rows, amount=amount) for amount in (0, last))
            effect = found.difference(imitated, copied, fw.DELIVERED) if last else UNKNOWN
            name = f"{robot}, {arena}: imitating delivers more than copying"
            claims.append(Claim(name, "", effect, above(0.0), fw.FOOD_POINTS))
    tables = (
        found.recall_table(
            "0 episodes: the teacher's program, copied. A copy always scores 100 % less its penalty, because the score "
            "compares it with the same program. Compare the food delivered.",
            (fw.DELIVERED, fw.SCORE, fw.STEPS),
        ),
        found.training_table(
            "The teacher is a standard robot. A learner whose training episode failed a hundred times in a row gets no "
            "further episodes.",
            (fw.ATTEMPTS, fw.ROUNDS, fw.TRUE),
        ),
    )
    last = max(found.amounts, default=0)
    figure, axes = panels(2, "Different robots: the teacher's program copied, and imitated")
    for panel, arena in zip(axes, fw.ARENAS, strict=True):
        own = pick(found.recalls, arena=arena)
        estimates = {
            robot: [found.mean(pick(own, condition=robot, amount=n), fw.DELIVERED) for n in (0, last)]
            for robot in ROBOTS
        }
        levels(panel, estimates, f"{fw.DELIVERED.name}, {arena}", ("copied", f"imitated, {last} episodes"))
        panel.set_xlim(-4, 104)
    axes[1].set_yticklabels([])
    legend(figure, axes[0], fw.INTERVALS)
    return claims, tables, figure


DIFFERENT_ROBOTS = fw.Experiment(
    "different_robots",
    "Different robots",
    "1.2, 6.3",
    "On a robot that differs from the teacher, is it better to imitate the teacher's program than to copy it?",
    "The learner differs from the teacher in one parameter. Copied: the teacher's decision tree runs on that robot. "
    "Imitated: that robot is trained beside a standard teacher, and recalls. An arm that reads 231 when it is raised "
    "changes what the robot perceives, because figure 4.2 expects 225 or less; the others change what behaviours do.",
    tuple(ROBOTS),
    train_robot,
    report_robots,
)
