"""The compiled backend: many worlds at once, one world, imitators, training, and the thesis's design. Needs numba."""

from time import perf_counter
from typing import Any

import gymnasium as gym
import numpy as np

import khepera_forage  # noqa: F401 (registers the environments)
from timing.imitator import experience
from timing.measures import Job, Measure, Values

WORLDS = 4096
SECTION = "The compiled backend"
NOTE = (
    "Worlds in kernels compiled by numba, with the teacher where nothing else is said; `docs/compiled.md` describes "
    "what they share with pymunk's."
)
KERNEL = Measure(
    SECTION,
    "recall in the corridor under the teacher, in the kernel",
    "steps/s",
    "whole episodes, all cores",
    4e6,
)
ONE_CORE = Measure(
    SECTION, "recall in the corridor under the teacher, in the kernel, one core", "steps/s", "one thread"
)
VECTOR = Measure(
    SECTION,
    f"Corridor-v1 of make_vec, {WORLDS:,} worlds",
    "steps/s",
    "behaviours in, observations and infos out, all cores",
    2e6,
)
TIMES_PYMUNK = Measure(
    SECTION,
    "Corridor-v1 of make_vec, as a multiple of that on pymunk",
    "times",
    "same repeat, resets included",
    100,
)
SINGLE = Measure(
    SECTION, 'Corridor-v1 with backend="compiled"', "steps/s", "gym.make, one world, resets included", 60_000
)
MEMORY = Measure(SECTION, "memory of a world", "bytes", "one food object", 2_000)
VECTORS, IMITATORS = 500, 64
"""Experience vectors of each imitator, and number of imitators that take turns."""
IMITATOR = Measure(
    SECTION,
    f"recall in the corridor under imitators of {VECTORS} experience vectors, in the kernel",
    "steps/s",
    f"whole episodes, {IMITATORS} imitators, all cores",
    1e6,
)
MEMORIES = Measure(SECTION, "experience vectors put into memories", "vectors/s", "`memories_of`, one core")
PAIRED = Measure(
    SECTION,
    "paired corridors, in the kernel",
    "rounds/s",
    "a teacher and a learner each, whole training episodes with failed attempts, all cores",
)
EPISODES = Measure(SECTION, "complete training episodes", "episodes/s", "the same run")
REPLICATIONS, QUICK_REPLICATIONS = 1000, 20


def worlds_job(episodes: int, seed: int) -> Job:
    """The kernel, the vector environment, and one world.

    Args:
        episodes: Whole episodes in the kernel in each repeat.
        seed: Of all worlds.
    """
    import numba

    from khepera_forage.rollouts.compiled.recalls import run_teacher

    env: Any = gym.make_vec("khepera_forage/Corridor-v1", num_envs=WORLDS)
    latest = {"infos": env.reset(seed=seed)[1]}

    def kernel() -> float:
        start = perf_counter()
        steps = int(run_teacher(episodes=episodes, seed=seed).steps.sum())
        return steps / (perf_counter() - start)

    def vector(rounds: int) -> float:
        seconds = []
        for _ in range(rounds):
            actions = latest["infos"]["correct_behaviour"]
            start = perf_counter()
            latest["infos"] = env.step(actions)[4]
            seconds.append(perf_counter() - start)
        return WORLDS / float(np.median(seconds))

    def repeat() -> Values:
        threads = numba.get_num_threads()
        values = {KERNEL: kernel(), VECTOR: vector(50), MEMORY: env.unwrapped.batch.bytes_per_world}
        values[TIMES_PYMUNK] = values[VECTOR] / single(2_000, seed)
        values[SINGLE] = single(20_000, seed, backend="compiled")
        numba.set_num_threads(1)
        values[ONE_CORE] = kernel()
        numba.set_num_threads(threads)
        return values

    return repeat


def single(steps: int, seed: int, **kwargs: Any) -> float:
    """Steps a second of Corridor-v1 of `gym.make` under the teacher, resets included."""
    env: Any = gym.make("khepera_forage/Corridor-v1", **kwargs)
    _, info = env.reset(seed=seed)
    start = perf_counter()
    for _ in range(steps):
        _, _, terminated, truncated, info = env.step(info["correct_behaviour"])
        if terminated or truncated:
            _, info = env.reset()
    rate = steps / (perf_counter() - start)
    env.close()
    return rate


def imitators_job(episodes: int, seed: int) -> Job:
    """Recalls under imitators; `episodes` and `seed` as in `worlds_job`."""
    from khepera_forage.policies.nearest_neighbour.memories import memories_of
    from khepera_forage.rollouts.compiled.recalls import run_recalls

    vectors, heard = experience(seed, 4 * VECTORS)
    # Each has learned from another stretch of the same trainings.
    firsts = np.linspace(0, 3 * VECTORS, IMITATORS, dtype=np.int64).tolist()
    parts = [(vectors[first : first + VECTORS], heard[first : first + VECTORS]) for first in firsts]
    which = np.arange(episodes) % IMITATORS

    def repeat() -> Values:
        start = perf_counter()
        memories = memories_of(parts * 16)
        stored = 16 * IMITATORS * VECTORS / (perf_counter() - start)
        start = perf_counter()
        steps = int(run_recalls("corridor", memories, which, seed).steps.sum())
        return {MEMORIES: stored, IMITATOR: steps / (perf_counter() - start)}

    return repeat


def training_job(episodes: int, seed: int) -> Job:
    """Training of as many learners as episodes."""
    from khepera_forage.rollouts.compiled.training import train_learners

    def repeat() -> Values:
        start = perf_counter()
        rounds = int(train_learners(episodes, seed=seed).attempts.rounds.sum())
        taken = perf_counter() - start
        return {PAIRED: rounds / taken, EPISODES: episodes / taken}

    return repeat


def design_job(replications: int, seed: int) -> Job:
    """The thesis's whole design, with training, recalls and their rows, but without the report."""
    from khepera_forage.thesis.compiled_replications import GROUP_SIZE, CompiledReplications

    def replicate(count: int) -> None:
        for first in range(0, count, GROUP_SIZE):
            CompiledReplications(seed, first, min(GROUP_SIZE, count - first)).run()

    def once() -> Values:
        replicate(1)  # compiles
        start = perf_counter()
        replicate(replications)
        measure = Measure(
            SECTION,
            f"{replications:,} replications of the thesis's design",
            "s",
            "ten training episodes and 106 recalls each, as rows; without compilation and report",
            60.0,
        )
        return {measure: perf_counter() - start}

    return once
