"""Thousands of worlds at once: the teacher wholly in the kernel, and the vector environment. Needs numba."""

from time import perf_counter
from typing import Any

import gymnasium as gym
import numpy as np

import khepera_forage  # noqa: F401 (registers the environments)
from _throughput.lines import Job, Measure, Values

WORLDS = 4096
SECTION = "Thousands of worlds at once"
NOTE = "Worlds in kernels compiled by numba, the expert deciding; docs/batch.md says what they share with pymunk's."
KERNEL = Measure(
    SECTION,
    "recall in the corridor under the teacher, in the kernel",
    "steps/s",
    f"whole episodes of {WORLDS:,} worlds, all cores",
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
MEMORY = Measure(SECTION, "memory of a world", "bytes", "one food object")
OBJECTS = tuple(
    Measure(SECTION, f"in the kernel with {foods} food objects in the rectangle", "steps/s", "all cores")
    for foods in (1, 2, 4, 8)
)


def job(episodes: int, seed: int) -> Job:
    """All measures of the batch.

    Args:
        episodes: Whole episodes a repeat in the kernel.
        seed: Of all worlds.
    """
    import numba

    from khepera_forage.envs.batch.episodes import run_teacher

    env: Any = gym.make_vec("khepera_forage/Corridor-v0", num_envs=WORLDS)
    _, infos = env.reset(seed=seed)
    state = {"infos": infos}

    def forage(**arguments: Any) -> float:
        start = perf_counter()
        steps = int(run_teacher(episodes=episodes, seed=seed, **arguments).steps.sum())
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
        numba.set_num_threads(1)
        values[ONE_CORE] = forage()
        numba.set_num_threads(most)
        for measure, foods in zip(OBJECTS, (1, 2, 4, 8), strict=True):
            values[measure] = forage(arena="rectangle", foods=foods, limit=700)
        return values

    return repeat
