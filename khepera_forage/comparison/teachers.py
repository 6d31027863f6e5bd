"""Which demonstrations should a teacher give? Teachers that choose start and food places of training episodes.

A demonstration is where the learner's robot starts and where the food lies: x and y (mm), heading (degrees), x and y.
"""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.comparison.batch_recalls import Training, kernel_recalls, recalls_after
from khepera_forage.counter_rng import key_of
from khepera_forage.envs.arena_settings import procedural_settings, training_rounds
from khepera_forage.envs.arguments import checked_arena
from khepera_forage.envs.layouts import random_layout
from khepera_forage.policies.distance import CORRIDOR_DIAGONAL
from khepera_forage.policies.imitator import NearestNeighbourImitator
from khepera_forage.policies.learners import FromVectors
from khepera_forage.policies.memories import memories_of
from khepera_forage.rollouts.compiled.training import train_learners
from khepera_forage.rollouts.training import IncompleteTrainingError
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.sim.arenas.thesis import CORRIDOR
from khepera_forage.task.decisions import DEFAULT_DECISIONS, DEFAULT_VALUES
from khepera_forage.task.placement import layout_key

PLACES = 5
"""Numbers of a demonstration."""
ATTEMPTS = 20
"""Incomplete attempts at a training episode after which a demonstration is impossible."""
Marks = NDArray[np.float64]
"""Demonstrations, one a row."""
_SPREAD = np.array((60.0, 20.0, 60.0, 60.0, 20.0))
"""How far the search moves each number of a demonstration at first."""
_PRIOR = 2
"""Trials that the average of a generation counts for."""
_FINAL = 6
"""How much more the best quarter is tried in the end."""
_CHANGED = 0.25
"""Chance that a demonstration of a good set is changed in a new one; one always is."""


class Budget(NamedTuple):
    """How much a search does.

    Attributes:
        sets: Of demonstrations, in each generation.
        generations: How many.
        trainings: With each set.
        recalls: After all trainings with a set.
    """

    sets: int
    generations: int
    trainings: int
    recalls: int


def joined(episodes: Sequence[NDArray[Any]]) -> Training:
    """Episodes of six columns, five attributes and the behaviour heard, as experience to learn from."""
    rows = np.concatenate(episodes).astype(np.int64)
    return Training(rows[:, :-1], rows[:, -1], np.repeat(np.arange(len(episodes)), list(map(len, episodes))))


def thesis_teacher(amount: int, seed: int) -> Training:
    """Always the marks of figure 5.1."""
    trained = train_learners(1, CORRIDOR, seed, episodes=amount)
    return joined([trained.vectors_of(0, number) for number in range(amount)])


def random_marks(amount: int, seed: int) -> Marks:
    """Random demonstrations, drawn like the places of recalls."""
    corridor, key = checked_arena(CORRIDOR, DEFAULT_DECISIONS), key_of(seed)
    found = []
    for number in range(amount):
        layout = random_layout(corridor, 1, layout_key(key, number), DEFAULT_VALUES)
        start, food = layout.starts[0], layout.foods[0]
        found.append((start.x, start.y, math.degrees(start.heading), food.x, food.y))
    return np.array(found)


def demonstrate(marks: Marks, seed: int, learners: int = 1) -> list[Training]:
    """What learners record of the same demonstrations.

    Raises:
        ValueError: There is no room for a demonstration.
        IncompleteTrainingError: A learner cannot follow it.
    """
    episodes = []
    for number, (x, y, heading, food_x, food_y) in enumerate(marks.tolist()):
        options = {"start": (x, y, heading), "foods": [(food_x, food_y)]}
        key = seed + learners * number
        episodes.append(train_learners(learners, CORRIDOR, key, options=options, attempts=ATTEMPTS))
    return [joined([trained.vectors_of(i) for trained in episodes]) for i in range(learners)]


def varied_arenas(amount: int, seed: int) -> Training:
    """One episode in each of several procedural training arenas, of every difficulty in turn."""
    episodes: list[NDArray[Any]] = []
    level = seed % 900_000
    while len(episodes) < amount:
        difficulty = tuple(DIFFICULTIES)[len(episodes) % len(DIFFICULTIES)]
        settings = procedural_settings(difficulty, "train", 1, level)
        level += 1
        try:
            trained = train_learners(
                1,
                settings["arena"][0],
                seed + level,
                max_cycles=training_rounds(settings["limit"]),
                food_types=settings["food_types"],
                noise=settings["noise"],
                attempts=ATTEMPTS,
            )
        except IncompleteTrainingError:
            continue
        episodes.append(trained.vectors_of(0))
    return joined(episodes)


def thinned(training: Training, size: int, seed: int) -> Training:
    """At most so many vectors of an experience, drawn at random."""
    count = len(training.vectors)
    drawn = np.sort(np.random.default_rng(seed).choice(count, min(size, count), replace=False))
    return Training(*(part[drawn] for part in training))


def search(
    learner: FromVectors,
    amount: int,
    budget: Budget,
    rng: np.random.Generator,
    watch: Callable[[float], object] = lambda _: None,
) -> Marks:
    """The demonstrations after which a learner delivers most, found by hill climbing with a population.

    Each generation tries sets that differ from those of the best quarter so far in some demonstrations. All sets of a
    generation have the same seeds, which no other generation has; the best quarter is tried again in each, and in the
    end longer.

    Args:
        learner: That is taught.
        amount: Demonstrations in a set.
        budget: How much is tried.
        rng: Of everything.
        watch: Receives the best mean share of the food so far, after each generation.
    """
    best, tried = budget.sets // 4, list[tuple[Marks, list[float]]]()
    for generation in range(budget.generations):
        spread = _SPREAD * 0.1 ** (generation / budget.generations)
        sets = tried[:best] + [
            (_near([marks for marks, _ in tried[:best]], amount, spread, rng), [])
            for _ in range(budget.sets - len(tried[:best]))
        ]
        seed = int(rng.integers(2**31))
        for marks, values in sets:
            values.append(_value(learner, marks, budget, seed))
        # A set that was tried once may have been lucky: its mean counts as if it had been average before.
        usual = float(np.mean([values[-1] for _, values in sets]))
        tried = sorted(sets, key=lambda one: -(sum(one[1]) + _PRIOR * usual) / (len(one[1]) + _PRIOR))
        watch(float(np.mean(tried[0][1])))
    thorough = budget._replace(trainings=_FINAL * budget.trainings, recalls=_FINAL * budget.recalls)
    seed = int(rng.integers(2**31))
    return max((marks for marks, _ in tried[:best]), key=lambda marks: _value(learner, marks, thorough, seed))


def _near(good: Sequence[Marks], amount: int, spread: NDArray[np.float64], rng: np.random.Generator) -> Marks:
    """A good set of which some demonstrations are moved, taken from another good set, or random."""
    other = random_marks(amount, int(rng.integers(2**31)))
    if not good:
        return other
    marks: Marks = good[int(rng.integers(len(good)))].copy()
    changed = rng.random(amount) < _CHANGED
    changed[rng.integers(amount)] = True
    for number in np.flatnonzero(changed):
        match rng.integers(3):
            case 0:
                marks[number] += spread * rng.normal(size=PLACES)
            case 1:
                marks[number] = good[int(rng.integers(len(good)))][rng.integers(amount)]
            case _:
                marks[number] = other[number]
    return marks


def _value(learner: FromVectors, marks: Marks, budget: Budget, seed: int) -> float:
    """Mean share of the food that a learner delivers after these demonstrations; 0 if they are impossible."""
    try:
        trainings = demonstrate(marks, seed, budget.trainings)
    except (ValueError, IncompleteTrainingError):
        return 0.0
    each = budget.recalls // budget.trainings
    seeds = [seed + number for number in range(each * budget.trainings)]
    if learner.make is NearestNeighbourImitator:
        memories = memories_of([training[:2] for training in trainings])
        done = kernel_recalls(CORRIDOR, memories, np.repeat(np.arange(budget.trainings), each), seeds)
        return float(done.delivered.mean())
    parts = [seeds[first : first + each] for first in range(0, len(seeds), each)]
    return float(
        np.mean(
            [
                recalls_after(learner, training, {CORRIDOR: part}, seed, CORRIDOR_DIAGONAL)[
                    CORRIDOR
                ].delivered.mean()
                for training, part in zip(trainings, parts, strict=True)
            ]
        )
    )
