"""Demonstrations, what is learned from them, and recalls, all in compiled worlds, where many advance together.

A demonstration is where the learner's robot starts and where the food lies: x and y (mm), heading (degrees), x and y.
"""

import copy
import math
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from itertools import groupby
from operator import itemgetter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.counter_rng import key_of
from khepera_forage.envs.arena_settings import procedural_settings, settings_of, training_rounds
from khepera_forage.envs.arguments import checked_arena
from khepera_forage.envs.compiled.vector_env import BehavioursVectorEnv, RecallVectorEnv, WheelsVectorEnv
from khepera_forage.envs.layouts import random_layout
from khepera_forage.policies.distance import CORRIDOR_DIAGONAL
from khepera_forage.policies.features import wheels_features
from khepera_forage.policies.imitator import NearestNeighbourImitator
from khepera_forage.policies.learners import OfflineImitation
from khepera_forage.policies.memories import Memories, memories_of
from khepera_forage.policies.policy import behaviours_of
from khepera_forage.rollouts.compiled.recalls import TEACHER, UNIFORM, Recalls
from khepera_forage.rollouts.compiled.training import train_learners
from khepera_forage.rollouts.training import IncompleteTrainingError
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.sim.arenas.thesis import CORRIDOR
from khepera_forage.task.decisions import DEFAULT_DECISIONS, DEFAULT_VALUES, Decisions
from khepera_forage.task.placement import layout_key
from khepera_forage.task.states import NUM_BEHAVIOURS, FoodType, StateVector

TEST_LEVELS = 20
"""Procedural test arenas of each difficulty."""
Seeds = Mapping[str, Sequence[int]]
"""Seeds of the recalls in each place: a named arena, or a difficulty of procedural test arenas."""


class TrainingData(NamedTuple):
    """State vectors to learn from, shape (n, 5), what was heard with each, and its training episode, shape (n,)."""

    vectors: NDArray[np.int64]
    behaviours: NDArray[np.int64]
    episodes: NDArray[np.int64]


class Foraged(NamedTuple):
    """Recalls in one place, one element each: scores (percent), and food that is not poisonous."""

    score: NDArray[np.float64]
    delivered: NDArray[np.int64]
    foods: NDArray[np.int64]


def recalls_after(
    learner: OfflineImitation, training: TrainingData, seeds: Seeds, seed: int, diagonal: int
) -> dict[str, Foraged]:
    """Let a learner learn, and forage in several places.

    A learner that takes the arena's diagonal has that of the arena foraged in; `diagonal` (pixels) is that of the
    training. `seed` is that of the learner's random choices; those of the thesis's imitator follow from `seeds`.
    """
    if learner.make is NearestNeighbourImitator:
        own = memories_of([training[:2]])
        return {place: kernel_recalls(place, own, np.zeros(len(some), np.int64), some) for place, some in seeds.items()}
    classifier = learner.fitted(training.vectors, training.behaviours, diagonal, seed, training.episodes)
    rng = np.random.default_rng(seed)
    known: dict[tuple[int, ...], NDArray[np.float64]] = {}

    def draw(rows: NDArray[np.int64]) -> NDArray[np.int64]:
        """A behaviour for each row, a diagonal and a state vector, drawn with its probability."""
        if not learner.diagonal:
            rows[:, 0] = 0
        keys = list(map(tuple, rows.tolist()))
        for own, group in groupby(sorted(set(keys).difference(known)), key=itemgetter(0)):
            new = list(group)
            known.update(zip(new, _levels(learner, classifier, np.array(new)[:, 1:], own), strict=True))
        steps = np.array([known[key] for key in keys]).cumsum(axis=1)
        drawn: NDArray[np.int64] = (steps <= rng.random((len(keys), 1)) * steps[:, -1:]).sum(axis=1)
        return drawn

    return _together(BehavioursVectorEnv, seeds, _vectors, draw)


def _levels(
    learner: OfflineImitation, classifier: Any, vectors: NDArray[np.int64], diagonal: int
) -> NDArray[np.float64]:
    """The probability of each behaviour in some state vectors."""
    if learner.diagonal:
        classifier = copy.copy(classifier)
        classifier.diagonal = diagonal
    classes, levels = np.array(behaviours_of(classifier.classes_)), np.zeros((len(vectors), NUM_BEHAVIOURS))
    if len(classes) == 1:  # for which scikit-learn's networks predict two probabilities
        levels[:, classes] = 1.0
        return levels
    found = np.asarray(classifier.predict_proba(vectors), np.float64)
    if learner.sample:
        levels[:, classes] = found
    else:
        levels[np.arange(len(vectors)), classes[found.argmax(axis=1)]] = 1.0
    return levels


def recalls_on_wheels(policy: Callable[[NDArray[Any]], NDArray[Any]], seeds: Seeds) -> dict[str, Foraged]:
    """Recalls of a policy from `wheels_features`, one row a world, to motors, four numbers in -1..1 each."""
    return _together(WheelsVectorEnv, seeds, lambda shown, _: wheels_features(shown), policy)


def reference_recalls(expert: bool, seeds: Seeds) -> dict[str, Foraged]:
    """Recalls of the teacher, or of behaviours drawn uniformly."""
    policy = TEACHER if expert else UNIFORM
    return {place: kernel_recalls(place, None, np.full(len(some), policy), some) for place, some in seeds.items()}


def kernel_recalls(place: str, memories: Memories | None, policies: NDArray[np.int64], seeds: Sequence[int]) -> Foraged:
    """Recalls of imitators, the teacher or chance; arguments as for `Recalls.run`."""
    numbers = np.array(seeds, np.int64)
    done = _recalls(place).run(memories, policies, numbers)
    env = BehavioursVectorEnv(len(numbers), **settings_at(place))
    env.reset(seed=numbers.tolist())
    return Foraged(done.score, done.delivered, _foods(env))


def settings_at(place: str) -> dict[str, Any]:
    """The arguments of the environments of a place."""
    return procedural_settings(place, "test", TEST_LEVELS, 0) if place in DIFFICULTIES else settings_of(place)


@lru_cache
def _recalls(place: str) -> Recalls:
    return Recalls(**settings_at(place))


def _foods(env: RecallVectorEnv) -> NDArray[np.int64]:
    """Food objects of each world that are not poisonous."""
    found: NDArray[np.int64] = (env.batch.worlds.objects["type"] != FoodType.POISONOUS).sum(axis=1)
    return found


def _vectors(shown: Mapping[str, Any], env: RecallVectorEnv) -> NDArray[np.int64]:
    """The diagonal of each world's arena, and its state vector."""
    columns: list[Any] = [env.get_attr("diagonal"), *(np.ravel(shown[name]) for name in StateVector._fields)]
    return np.stack(columns, axis=1).astype(np.int64)


def _together(
    kind: type[RecallVectorEnv],
    seeds: Seeds,
    features: Callable[[Mapping[str, Any], RecallVectorEnv], NDArray[Any]],
    decide: Callable[[NDArray[Any]], NDArray[Any]],
) -> dict[str, Foraged]:
    """Run the recalls of all places, round by round: `features` makes a row for each world, `decide` acts on rows."""
    envs = {place: kind(len(some), **settings_at(place)) for place, some in seeds.items()}
    shown = {place: env.reset(seed=list(seeds[place]))[0] for place, env in envs.items()}
    found = {
        place: Foraged(np.zeros(env.num_envs), np.zeros(env.num_envs, np.int64), _foods(env))
        for place, env in envs.items()
    }
    under_way = {place: np.ones(env.num_envs, np.bool_) for place, env in envs.items()}
    while under_way:
        rows = [features(shown[place], envs[place])[worlds] for place, worlds in under_way.items()]
        decided = np.split(decide(np.concatenate(rows)), np.cumsum([len(part) for part in rows])[:-1])
        for (place, worlds), own in zip(list(under_way.items()), decided, strict=True):
            actions = np.zeros((len(worlds), *own.shape[1:]), own.dtype)
            actions[worlds] = own
            shown[place], _, terminated, truncated, infos = envs[place].step(actions)
            ended = worlds & (terminated | truncated)
            found[place].score[ended] = infos["score"][ended]
            found[place].delivered[ended] = infos["delivered"][ended]
            under_way[place] = worlds & ~ended
            if not under_way[place].any():
                del under_way[place]
    return found


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
    """How much a search does: trainings with each set, and recalls after all of these."""

    sets: int
    generations: int
    trainings: int
    recalls: int


def joined(episodes: Sequence[NDArray[Any]]) -> TrainingData:
    """Episodes of six columns, five attributes and the behaviour heard, as experience to learn from."""
    rows = np.concatenate(episodes).astype(np.int64)
    return TrainingData(rows[:, :-1], rows[:, -1], np.repeat(np.arange(len(episodes)), list(map(len, episodes))))


def thesis_teacher(amount: int, seed: int) -> TrainingData:
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


def demonstrate(marks: Marks, seed: int, learners: int = 1) -> list[TrainingData]:
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


def varied_arenas(amount: int, seed: int, decisions: Decisions = DEFAULT_DECISIONS) -> TrainingData:
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
                decisions=decisions,
                attempts=ATTEMPTS,
            )
        except IncompleteTrainingError:
            continue
        episodes.append(trained.vectors_of(0))
    return joined(episodes)


def thinned(training: TrainingData, size: int, seed: int) -> TrainingData:
    """At most so many vectors of an experience, drawn at random."""
    count = len(training.vectors)
    drawn = np.sort(np.random.default_rng(seed).choice(count, min(size, count), replace=False))
    return TrainingData(*(part[drawn] for part in training))


def search(learner: OfflineImitation, amount: int, budget: Budget, rng: np.random.Generator) -> Marks:
    """The demonstrations after which a learner delivers most, found by hill climbing with a population.

    Each generation tries sets that differ from those of the best quarter so far in some demonstrations, with seeds of
    its own; the best quarter is tried again in each, and in the end longer.
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


def _value(learner: OfflineImitation, marks: Marks, budget: Budget, seed: int) -> float:
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
    shares = [
        recalls_after(learner, training, {CORRIDOR: seeds[k * each : (k + 1) * each]}, seed, CORRIDOR_DIAGONAL)
        for k, training in enumerate(trainings)
    ]
    return float(np.mean([share[CORRIDOR].delivered.mean() for share in shares]))
