"""One case of `throughput.py --beside`, measured on the package that PYTHONPATH names: this version or an older one.

    PYTHONPATH=checkout python -P benchmarks/timing/beside_cases.py CASE SIZE SEED [CORE]

Prints the value and the folder of the package. `_PLACES` lists where each version keeps what the cases use. All
versions run the task of version 0.1, the only one that they share.
"""

import os
import sys
import warnings
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from statistics import median
from time import perf_counter
from typing import Any

WORLDS, EPISODES = 4096, 16_384
"""Worlds of make_vec; episodes of one call of the kernel, which keep all cores busy."""
_CORRIDOR = "khepera_forage:khepera_forage/Corridor-v0"
_PLACES = {
    "run_teacher": (
        "khepera_forage.rollouts.compiled.recalls:run_teacher",
        "khepera_forage.envs.batch.episodes:run_teacher",
    ),
    "train_learners": (
        "khepera_forage.rollouts.compiled.training:train_learners",
        "khepera_forage.envs.batch.pairs:train_learners",
    ),
    "CompiledReplications": (
        "khepera_forage.thesis.compiled_replications:CompiledReplications",
        "khepera_forage.experiments.batch_replications:ReplicationBatch",
    ),
    "GROUP_SIZE": (
        "khepera_forage.thesis.compiled_replications:GROUP_SIZE",
        "khepera_forage.experiments.batch_replications:SIZE",
    ),
}
"""Where a name is: in this version, then in version 0.1 (commit b91f85b)."""


def pymunk(steps: int, seed: int) -> float:
    """Steps a second of Corridor-v0 on pymunk under the teacher, resets included."""
    import gymnasium as gym

    env: Any = _corridor(gym.make)
    policies = import_module("khepera_forage.policies")
    teacher = policies.Teacher
    act = (teacher.of(env) if hasattr(teacher, "of") else teacher(env.unwrapped.home_radius)).act
    return _steps_a_second(env, lambda observation, _: act(observation), steps, seed)


def one_world(steps: int, seed: int) -> float:
    """Steps a second of one compiled Corridor-v0 under the teacher, resets included."""
    import gymnasium as gym

    env: Any
    try:
        env = _corridor(gym.make, backend="compiled")
    except TypeError:
        env = _corridor(gym.make, physics="batch")
    return _steps_a_second(env, lambda _, info: info["correct_behaviour"], steps, seed)


def make_vec(rounds: int, seed: int) -> float:
    """Steps a second of all worlds of make_vec under the teacher, in the median round."""
    import gymnasium as gym

    env: Any = _corridor(gym.make_vec, num_envs=WORLDS)
    _, infos = env.reset(seed=seed)
    seconds = []
    for _ in range(2 * rounds):
        actions = infos["correct_behaviour"]
        start = perf_counter()
        infos = env.step(actions)[4]
        seconds.append(perf_counter() - start)
    return WORLDS / median(seconds[rounds:])  # by then worlds end their episodes in different rounds


def kernel(calls: int, seed: int) -> float:
    """Steps a second of whole episodes under the teacher in the kernel, on at most two threads, in the median call."""
    import numba

    run_teacher, decisions = _find("run_teacher"), _decisions()
    numba.set_num_threads(min(2, numba.get_num_threads()))
    run_teacher(episodes=128, seed=seed, **decisions)
    rates = []
    for call in range(calls):
        start = perf_counter()
        steps = int(run_teacher(episodes=EPISODES, seed=seed + call, **decisions).steps.sum())
        rates.append(steps / (perf_counter() - start))
    return median(rates)


def design(replications: int, seed: int) -> float:
    """Seconds of replications of the thesis's design: training and recalls as rows, without the report."""
    group, size, decisions = _find("CompiledReplications"), _find("GROUP_SIZE"), _decisions()
    group(seed, 0, 1, **decisions).run()  # compiles, or loads the kernels
    start = perf_counter()
    for first in range(0, replications, size):
        group(seed, first, min(size, replications - first), **decisions).run()
    return perf_counter() - start


def first_make_vec(worlds: int, seed: int) -> float:
    """Seconds from the import to the end of the first step of make_vec."""
    start = perf_counter()
    import gymnasium as gym

    env: Any = _corridor(gym.make_vec, num_envs=worlds)
    env.step(env.reset(seed=seed)[1]["correct_behaviour"])
    return perf_counter() - start


def first_run_teacher(episodes: int, seed: int) -> float:
    """Seconds from the import to the end of the first call of run_teacher."""
    start = perf_counter()
    _find("run_teacher")("corridor", episodes, seed=seed, **_decisions())
    return perf_counter() - start


def first_train_learners(learners: int, seed: int) -> float:
    """Seconds from the import to the end of the first call of train_learners."""
    start = perf_counter()
    _find("train_learners")(learners, seed=seed, **_decisions())
    return perf_counter() - start


CASES: dict[str, Callable[[int, int], float]] = {
    case.__name__: case
    for case in (
        pymunk,
        make_vec,
        kernel,
        one_world,
        design,
        first_make_vec,
        first_run_teacher,
        first_train_learners,
    )
}
"""Every case by its name; each takes its size and a seed."""


def _corridor(make: Callable[..., Any], **kwargs: Any) -> Any:
    """Corridor-v0 by one of Gymnasium's functions, without its warning that there is a newer version."""
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", ".*is out of date", DeprecationWarning)
        return make(_CORRIDOR, **kwargs)


def _decisions() -> dict[str, Any]:
    """Arguments for the decisions of version 0.1, which older versions of the package have by default."""
    decisions: Any = getattr(import_module("khepera_forage"), "Decisions", None)
    return {"decisions": decisions.v0_1()} if hasattr(decisions, "v0_1") else {}


def _find(name: str) -> Any:
    """What has this name in `_PLACES`, from the first module that the package has."""
    for place in _PLACES[name]:
        module, _, attribute = place.partition(":")
        try:
            return getattr(import_module(module), attribute)
        except ModuleNotFoundError as error:
            if not (error.name or "").startswith("khepera_forage"):
                raise
    raise ImportError(f"this version of the package has none of {', '.join(_PLACES[name])}")


def _steps_a_second(env: Any, act: Callable[[Any, Any], Any], steps: int, seed: int) -> float:
    """Steps a second with their resets, after a tenth of as many steps."""

    def run(count: int) -> float:
        start = perf_counter()
        observation, info = env.reset(seed=seed)
        for _ in range(count):
            observation, _, terminated, truncated, info = env.step(act(observation, info))
            if terminated or truncated:
                observation, info = env.reset()
        return perf_counter() - start

    run(steps // 10)
    return steps / run(steps)


if __name__ == "__main__":
    case, size, seed, *core = sys.argv[1:]
    if core:
        os.sched_setaffinity(0, map(int, core))
    value = CASES[case](int(size), int(seed))
    print(value, Path(sys.modules["khepera_forage"].__file__ or "").parents[1], sep="\n")
