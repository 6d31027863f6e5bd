"""Recalls of any learner in compiled worlds: those of all places advance together, so that it decides in bulk."""

import copy
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.arena_settings import procedural_settings, settings_of
from khepera_forage.envs.compiled.vector_env import BehavioursVectorEnv, RecallVectorEnv, WheelsVectorEnv
from khepera_forage.policies.features import wheels_features
from khepera_forage.policies.imitator import NearestNeighbourImitator
from khepera_forage.policies.learners import FromVectors
from khepera_forage.policies.memories import Memories, memories_of
from khepera_forage.rollouts.compiled.recalls import TEACHER, UNIFORM, Recalls
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.task.states import NUM_BEHAVIOURS, FoodType, StateVector

TEST_LEVELS = 20
"""Procedural test arenas of each difficulty."""
Seeds = Mapping[str, Sequence[int]]
"""Seeds of the recalls in each place: a named arena, or a difficulty of procedural test arenas."""


class Training(NamedTuple):
    """Experience to learn from.

    Attributes:
        vectors: State vectors, shape (n, 5).
        behaviours: What was heard with each, shape (n,).
        episodes: The training episode of each vector, shape (n,).
    """

    vectors: NDArray[np.int64]
    behaviours: NDArray[np.int64]
    episodes: NDArray[np.int64]


class Foraged(NamedTuple):
    """Recalls in one place, one element each.

    Attributes:
        score: Equation 5.1, percent.
        delivered: Food brought home that is not poisonous.
        foods: Food objects that are not poisonous.
    """

    score: NDArray[np.float64]
    delivered: NDArray[np.int64]
    foods: NDArray[np.int64]


def recalls_after(
    learner: FromVectors, training: Training, seeds: Seeds, seed: int, diagonal: int
) -> dict[str, Foraged]:
    """Let a learner learn, and forage in several places.

    A learner that takes the arena's diagonal has that of the arena foraged in.

    Args:
        learner: An entry of `LEARNERS`.
        training: Its experience.
        seeds: Of the recalls.
        seed: Of the learner's random choices. Those of the thesis's imitator, which runs compiled, follow from `seeds`.
        diagonal: Of the arena of the training, in pixels.
    """
    if learner.make is NearestNeighbourImitator:
        own = memories_of([training[:2]])
        return {
            place: kernel_recalls(place, own, np.zeros(len(some), np.int64), some)
            for place, some in seeds.items()
        }
    more = {"groups": training.episodes} if learner.grouped else {}
    classifier = learner.classifier(diagonal, seed).fit(training.vectors, training.behaviours, **more)
    table, rng = _Decisions(learner, classifier), np.random.default_rng(seed)
    return _together(BehavioursVectorEnv, seeds, _vectors, lambda rows: table.draw(rows, rng))


def recalls_on_wheels(policy: Callable[[NDArray[Any]], NDArray[Any]], seeds: Seeds) -> dict[str, Foraged]:
    """Recalls of a policy that commands motors.

    Args:
        policy: From `wheels_features`, one row a world, to four numbers in -1..1 each.
        seeds: Of the recalls.
    """
    return _together(WheelsVectorEnv, seeds, lambda shown, _: wheels_features(shown), policy)


def reference_recalls(expert: bool, seeds: Seeds) -> dict[str, Foraged]:
    """Recalls of the teacher, or of behaviours drawn uniformly."""
    policy = TEACHER if expert else UNIFORM
    return {
        place: kernel_recalls(place, None, np.full(len(some), policy), some) for place, some in seeds.items()
    }


def kernel_recalls(
    place: str, memories: Memories | None, policies: NDArray[np.int64], seeds: Sequence[int]
) -> Foraged:
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
    columns = [env.batch.shown["diagonal"], *(np.ravel(shown[name]) for name in StateVector._fields)]
    return np.stack(columns, axis=1).astype(np.int64)


def _together(
    kind: type[RecallVectorEnv],
    seeds: Seeds,
    features: Callable[[Mapping[str, Any], RecallVectorEnv], NDArray[Any]],
    decide: Callable[[NDArray[Any]], NDArray[Any]],
) -> dict[str, Foraged]:
    """Run the recalls of all places, round by round.

    Args:
        kind: Of environments.
        seeds: Of the recalls.
        features: From observations of a place's worlds to a row a world.
        decide: From such rows to an action each.
    """
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


class _Decisions:
    """What a classifier decides in state vectors: each is computed once."""

    def __init__(self, learner: FromVectors, classifier: Any) -> None:
        self._learner, self._classifier = learner, classifier
        self._row_of: dict[tuple[int, ...], int] = {}
        self._levels = np.zeros((0, NUM_BEHAVIOURS))

    def draw(self, rows: NDArray[np.int64], rng: np.random.Generator) -> NDArray[np.int64]:
        """A behaviour for each row, a diagonal and a state vector, drawn with its probability."""
        if not self._learner.diagonal:
            rows[:, 0] = 0
        keys = list(map(tuple, rows.tolist()))
        missing = np.array(sorted({key for key in keys if key not in self._row_of}), np.int64)
        for diagonal in np.unique(missing[:, 0]) if len(missing) else ():
            own = missing[missing[:, 0] == diagonal]
            first = len(self._row_of)
            self._row_of.update(zip(map(tuple, own.tolist()), range(first, first + len(own)), strict=True))
            self._levels = np.concatenate((self._levels, self._predicted(own[:, 1:], int(diagonal))))
        steps = self._levels[[self._row_of[key] for key in keys]].cumsum(axis=1)
        drawn: NDArray[np.int64] = (steps <= rng.random((len(keys), 1)) * steps[:, -1:]).sum(axis=1)
        return drawn

    def _predicted(self, vectors: NDArray[np.int64], diagonal: int) -> NDArray[np.float64]:
        classifier = self._classifier
        if self._learner.diagonal:
            classifier = copy.copy(classifier)
            classifier.diagonal = diagonal
        classes, levels = classifier.classes_, np.zeros((len(vectors), NUM_BEHAVIOURS))
        if len(classes) == 1:  # for which scikit-learn's networks predict two probabilities
            levels[:, classes] = 1.0
            return levels
        found = np.asarray(classifier.predict_proba(vectors), np.float64)
        if self._learner.sample:
            levels[:, classes] = found
        else:
            levels[np.arange(len(vectors)), classes[found.argmax(axis=1)]] = 1.0
        return levels
