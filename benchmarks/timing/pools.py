"""Compiled worlds in thousands of procedural arenas, beside worlds that are all in the corridor. Needs numba."""

from time import perf_counter
from typing import Any

import gymnasium as gym
import numpy as np

import khepera_forage  # noqa: F401 (registers the environments)
from timing.compiled import SECTION, WORLDS
from timing.measures import Job, Measure, Values

ARENAS, QUICK_ARENAS = 10_000, 50
FOODS = 2
"""Food objects of a medium arena."""
RESETS = 8
"""Resets of all worlds, after which nearly every arena has been entered, and so prepared, once."""
PREPARED = Measure(
    SECTION,
    "drawing and preparing a medium procedural arena",
    "ms",
    f"mean of a pool, with {RESETS} resets of all worlds",
)
POOL = Measure(
    SECTION,
    f"Procedural-v1 of make_vec, {WORLDS:,} worlds in medium arenas",
    "steps/s",
    "behaviours in, observations and infos out, all cores; with as many steps before",
)
SHARE = Measure(
    SECTION,
    f"Procedural-v1 of make_vec, as a share of Corridor-v1 with {FOODS} food objects",
    "times",
    "same repeat",
    0.5,
)


def pool_job(arenas: int, rounds: int, seed: int) -> Job:
    """A batch whose episodes take place in many arenas.

    Args:
        arenas: How many.
        rounds: Of all worlds in each repeat.
        seed: Of all worlds.
    """
    pool: Any = gym.make_vec("khepera_forage/Procedural-v1", num_envs=WORLDS, num_levels=arenas)
    corridor: Any = gym.make_vec("khepera_forage/Corridor-v1", num_envs=WORLDS, foods=FOODS)
    start = perf_counter()
    for reset in range(RESETS):
        infos = pool.reset(seed=seed + WORLDS * reset)[1]
    prepared = 1000 * (perf_counter() - start) / arenas
    latest = {pool: infos, corridor: corridor.reset(seed=seed)[1]}

    def rate(env: Any) -> float:
        seconds = []
        for _ in range(rounds):
            actions = latest[env]["correct_behaviour"]
            before = perf_counter()
            latest[env] = env.step(actions)[4]
            seconds.append(perf_counter() - before)
        return WORLDS / float(np.median(seconds))

    def repeat() -> Values:
        alone, together = rate(corridor), rate(pool)
        return {PREPARED: prepared, POOL: together, SHARE: together / alone}

    return repeat
