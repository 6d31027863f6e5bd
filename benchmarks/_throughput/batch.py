"""Thousands of worlds at once: the teacher wholly in the kernel, the vector environment, and one world. Needs numba."""

from time import perf_counter
from typing import Any

import gymnasium as gym
import numpy as np

import khepera_forage  # noqa: F401 (registers the environments)
from _throughput.lines import Job, Measure, Values

WORLDS = 4096
SECTION = "Thousands of worlds at once"
NOTE = "Worlds in kernels compiled by numba, the expert deciding; docs/compiled.md says what they share with pymunk's."
KERNEL = Measure(
    SECTION,
    "recall in the corridor under the teacher, in the kernel",
    "steps/s",
    "whole episodes, as few worlds at a time as keep all cores busy",
    15e6,
)
ONE_CORE = Measure(SECTION, "the same on one core", "steps/s", "one thread")
VECTOR = Measure(
    SECTION,
    f"Corridor-v0 of make_vec, {WORLDS:,} worlds",
    "steps/s",
    "behaviours in, observations and infos out, all cores",
    5e6,
)
TIMES = Measure(
    SECTION, "the same beside Corridor-v0 in pymunk", "times", "both in the same repeat, resets included", 300
)
SINGLE = Measure(
    SECTION, 'Corridor-v0 with physics="batch"', "steps/s", "gym.make, one world, resets included", 150_000
)
MEMORY = Measure(SECTION, "memory of a world", "bytes", "one food object", 2_000)


def job(episodes: int, seed: int) -> Job:
    """The main measures of the batch.

    Args:
        episodes: Whole episodes a repeat in the kernel.
        seed: Of all worlds.
    """
    import numba

    from khepera_forage.rollouts.compiled.recalls import run_teacher

    env: Any = gym.make_vec("khepera_forage/Corridor-v0", num_envs=WORLDS)
    _, infos = env.reset(seed=seed)
    state = {"infos": infos}

    def forage() -> float:
        start = perf_counter()
        steps = int(run_teacher(episodes=episodes, seed=seed).steps.sum())
        return steps / (perf_counter() - start)

    def step_all(rounds: int) -> float:
        seconds = []
        for _ in range(rounds):
            actions = state["infos"]["correct_behaviour"]
            start = perf_counter()
            _, _, _, _, state["infos"] = env.step(actions)
            seconds.append(perf_counter() - start)
        return WORLDS / float(np.median(seconds))

    def repeat() -> Values:
        most = numba.get_num_threads()
        values = {KERNEL: forage(), VECTOR: step_all(50), MEMORY: env.unwrapped.batch.bytes_per_world}
        values[TIMES] = values[VECTOR] / alone(2_000, seed)
        values[SINGLE] = alone(20_000, seed, physics="batch")
        numba.set_num_threads(1)
        values[ONE_CORE] = forage()
        numba.set_num_threads(most)
        return values

    return repeat


def alone(steps: int, seed: int, **kwargs: Any) -> float:
    """Steps a second of Corridor-v0 of `gym.make` under the teacher, resets included."""
    env: Any = gym.make("khepera_forage/Corridor-v0", **kwargs)
    _, info = env.reset(seed=seed)
    start = perf_counter()
    for _ in range(steps):
        _, _, terminated, truncated, info = env.step(info["correct_behaviour"])
        if terminated or truncated:
            _, info = env.reset()
    rate = steps / (perf_counter() - start)
    env.close()
    return rate
