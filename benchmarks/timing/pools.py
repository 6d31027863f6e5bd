"""Compiled worlds in thousands of procedural arenas, beside worlds that are all in the corridor. Needs numba."""

import sys
from dataclasses import replace
from functools import _lru_cache_wrapper, partial
from itertools import count, islice
from time import perf_counter
from typing import Any

import gymnasium as gym
import numpy as np

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.envs.arena_pool import ArenaPool
from khepera_forage.envs.arena_settings import procedural_settings
from khepera_forage.envs.compiled.arenas import PreparedArenas
from khepera_forage.rollouts.compiled.recalls import TEACHER, Recalls
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.arenas.procedural import LEVELS, procedural_arena
from khepera_forage.task.decisions import Decisions
from timing.compiled import SECTION, WORLDS
from timing.measures import Job, Measure, Values

ARENAS, QUICK_ARENAS = 10_000, 50
FOODS = 2
"""Food objects of a medium arena."""
RESETS = 20
"""Resets of all worlds, after which all but about three of the arenas have been entered, and so prepared, once."""
PREPARED = Measure(
    SECTION,
    "drawing and preparing a medium procedural arena",
    "ms",
    f"mean of a pool, with {RESETS} resets of all worlds",
)
WALLS, TIMES = 30, 20
"""Walls of an arena that is prepared alone, and how many of these arenas."""
LONGEST = Measure(
    SECTION,
    f"preparing an arena of {WALLS} walls",
    "ms",
    f"the longest of {TIMES} extreme procedural arenas: checks, paths, and the bytes that kernels read",
    50.0,
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
    levels = map(partial(procedural_arena, difficulty="extreme"), count())
    large = list(islice((arena for arena in levels if len(arena.wall_records) == WALLS), TIMES))
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
        longest = max(map(_preparation, large))
        return {PREPARED: prepared, LONGEST: longest, POOL: together, SHARE: together / alone}

    return repeat


def recalls_job(recalls: int, seed: int) -> Job:
    """Whole recalls, nearly every one in an arena of its own.

    Args:
        recalls: How many in each repeat.
        seed: Of the first recall.
    """
    settings = procedural_settings("medium", "train", LEVELS, 0)
    pool, corridor = Recalls(**settings), Recalls(**{**settings, "arena": "corridor"})
    policies = np.full(recalls, TEACHER)
    of_pool = Measure(
        SECTION,
        f"whole recalls in {recalls:,} medium arenas, in the kernel",
        "steps/s",
        "one call of `Recalls.run`, nearly every recall in an arena of its own, all cores; arenas prepared before",
    )
    share = Measure(
        SECTION,
        f"the same, as a share of whole recalls in the corridor with {FOODS} food objects",
        "times",
        "same repeat; as many recalls, with the same food types and noise",
        0.5,
    )

    def rate(batch: Recalls) -> float:
        start = perf_counter()
        steps = int(batch.run(None, policies, seed).steps.sum())
        return steps / (perf_counter() - start)

    def repeat() -> Values:
        alone, together = rate(corridor), rate(pool)
        return {of_pool: together, share: together / alone}

    return repeat


def _preparation(arena: Arena) -> float:
    """Milliseconds to prepare an arena of which nothing is known."""
    for name, module in list(sys.modules.items()):
        if name.startswith("khepera_forage."):
            for thing in vars(module).values():
                if isinstance(thing, _lru_cache_wrapper):
                    thing.cache_clear()
    start = perf_counter()
    PreparedArenas(ArenaPool(replace(arena), Decisions()))
    return 1000 * (perf_counter() - start)
