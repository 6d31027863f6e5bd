"""The imitator with real experience, asked real questions, one at a time."""

from collections.abc import Callable
from functools import cache
from time import perf_counter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from _throughput.lines import Job, Measure, Values
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.experiments.recalling import recall_env
from khepera_forage.experiments.training import arrays, train
from khepera_forage.policies import NearestNeighbourImitator, state_vector_of

VECTORS = 1_000
GOAL = 40_000
SECTION = "Imitator"
NOTE = (
    f"{VECTORS:,} experience vectors of complete trainings; `act`, one observation at a time, on those that it has "
    "while it forages in the corridor, in their order."
)
MEMO = Measure(SECTION, "imitator as it forages", "decisions/s", "its memo is empty at the start", GOAL)
NO_MEMO = Measure(
    SECTION, "imitator, memo emptied before every query", "decisions/s", "every query is searched for", GOAL
)
SEEN = Measure(
    SECTION, "queries that the memo answers", "%", "state vectors that came before among the queries"
)

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
    """Measure `count` decisions with the memo and as many without it."""

    def run() -> Values:
        asked = queries(seed, count)
        distinct = len({state_vector_of(observation) for observation in asked})
        imitator = _imitator(seed)
        as_it_forages = _rate(imitator, asked, seed, lambda: None)
        imitator = _imitator(seed)
        imitator.act(asked[0], np.random.default_rng(seed))  # now there is a memo to empty
        assert imitator._memo is not None
        searching = _rate(imitator, asked, seed, imitator._memo.found.clear)
        return {MEMO: as_it_forages, NO_MEMO: searching, SEEN: 100 * (1 - distinct / count)}

    return run


def _rate(
    imitator: NearestNeighbourImitator, asked: list[Any], seed: int, before: Callable[[], None]
) -> float:
    draws = np.random.default_rng(seed)
    start = perf_counter()
    for observation in asked:
        before()
        imitator.act(observation, draws)
    return len(asked) / (perf_counter() - start)


def _imitator(seed: int) -> NearestNeighbourImitator:
    return NearestNeighbourImitator().fit(*experience(seed))
