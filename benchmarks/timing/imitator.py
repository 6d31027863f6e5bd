"""The imitator with real experience and real observations, one at a time."""

from collections.abc import Callable
from functools import cache
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.training import TrainingEnv
from khepera_forage.policies import NearestNeighbourImitator, Teacher, state_vector_of
from khepera_forage.rollouts.recall import recall_env
from khepera_forage.rollouts.training import arrays, train
from timing.measures import Job, Measure, Values

VECTORS = 1_000
GOAL = 40_000
MANY_VECTORS = 1_000_000
MANY_GOAL = 20_000
VECTORS_A_QUERY = 100
"""Vectors for each query, up to `MANY_VECTORS`, so that a quick run has fewer."""
SECTION = "Imitator"
NOTE = (
    f"{VECTORS:,} experience vectors of complete trainings. The observations are those that the imitator has while it "
    "forages in the corridor, in their order, one `act` each. The last lines have the same observations and an "
    "imitator with many vectors, from the teacher's forages from random places in the corridor."
)
CACHE = Measure(SECTION, "imitator while it forages", "decisions/s", "with an empty cache at the start", GOAL)
NO_CACHE = Measure(
    SECTION, "imitator, cache emptied before every query", "decisions/s", "every query is searched for", GOAL
)
SEEN = Measure(
    SECTION, "queries that the cache answers", "%", "state vectors that came before among the queries"
)
MANY = Measure(
    SECTION, "imitator over many vectors", "decisions/s", "cache emptied before every query", MANY_GOAL
)
MORE = Measure(SECTION, "one more vector learned", "vectors/s", "`partial_fit` of one vector after the other")
SIZE = Measure(SECTION, "vectors of that imitator", "vectors")
DISTINCT = Measure(SECTION, "distinct among them", "vectors")

Experience = tuple[NDArray[np.int64], NDArray[np.int64]]


@cache
def experience(seed: int, size: int = VECTORS) -> Experience:
    """The first experience vectors of as many complete trainings as it takes, and what was heard with each."""
    env = TrainingEnv()
    files = []
    for number in range(size):  # more than enough: a training records dozens
        files.append(train(env, np.random.SeedSequence(seed, spawn_key=(number,)))[0])
        vectors, heard = arrays(files)
        if len(heard) >= size:
            break
    env.close()
    return vectors[:size], heard[:size]


@cache
def forages(seed: int, size: int) -> Experience:
    """The state vectors of the teacher's forages from random places in the corridor, and what it does on each."""
    env = recall_env("corridor")
    teacher = Teacher.of(env)
    vectors, done = np.empty((size, 5), np.int64), np.empty(size, np.int64)
    observation, _ = env.reset(seed=seed)
    for i in range(size):
        vectors[i] = state_vector_of(observation)
        done[i] = teacher.act(observation)
        observation, _, terminated, truncated, _ = env.step(int(done[i]))
        if terminated or truncated:
            observation, _ = env.reset()
    env.close()
    return vectors, done


@cache
def queries(seed: int, count: int) -> list[Any]:
    """Observations that an imitator with that experience has in the corridor, in the order it has them."""
    imitator, env, draws = _imitator(seed), recall_env("corridor"), np.random.default_rng(seed)
    observations: list[Any] = []
    observation, _ = env.reset(seed=seed)
    while len(observations) < count:
        observations.append(observation)
        observation, _, terminated, truncated, _ = env.step(imitator.act(observation, draws))
        if terminated or truncated:
            observation, _ = env.reset()
    env.close()
    return observations


def job(count: int, seed: int) -> Job:
    """Measure `count` decisions with the cache, as many without it, and as many over many vectors."""

    def run() -> Values:
        observed = queries(seed, count)
        distinct = len({state_vector_of(observation) for observation in observed})
        imitator = _imitator(seed)
        as_it_forages = _rate(imitator, observed, seed, lambda: None)
        imitator = _imitator(seed)
        imitator.act(observed[0], np.random.default_rng(seed))  # now there is a cache to empty
        searching = _searching(imitator, observed, seed)
        values = {CACHE: as_it_forages, NO_CACHE: searching, SEEN: 100 * (1 - distinct / count)}
        return {**values, **_many(observed, seed)}

    return run


def _many(observed: list[Any], seed: int) -> Values:
    """Decisions over many vectors, and learning of one more vector: of an observation, with a fixed behaviour."""
    vectors, done = forages(seed, min(MANY_VECTORS, VECTORS_A_QUERY * len(observed)))
    imitator = NearestNeighbourImitator().fit(vectors, done)
    imitator.act(observed[0], np.random.default_rng(seed))
    searching = _searching(imitator, observed, seed)
    more = [
        (np.array([state_vector_of(observation)]), [0]) for observation in observed[: len(observed) // 10]
    ]
    start = perf_counter()
    for vector, said in more:
        imitator.partial_fit(vector, said)
    learning = len(more) / (perf_counter() - start)
    sizes = {SIZE: float(len(vectors)), DISTINCT: float(len(np.unique(vectors, axis=0)))}
    return {MANY: searching, MORE: learning, **sizes}


def _searching(imitator: NearestNeighbourImitator, observed: list[Any], seed: int) -> float:
    """Decisions a second with the cache emptied before each."""
    assert imitator._cache is not None
    return _rate(imitator, observed, seed, imitator._cache.found.clear)


def _rate(
    imitator: NearestNeighbourImitator, observed: list[Any], seed: int, before: Callable[[], None]
) -> float:
    draws = np.random.default_rng(seed)
    start = perf_counter()
    for observation in observed:
        before()
        imitator.act(observation, draws)
    return len(observed) / (perf_counter() - start)


def _imitator(seed: int) -> NearestNeighbourImitator:
    return NearestNeighbourImitator().fit(*experience(seed))
