"""Learning by trial and error: stable-baselines3 on the recall environments (extra `baselines`)."""

import pickle
import random
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from importlib import import_module
from time import perf_counter
from typing import Any, NamedTuple

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode

import khepera_forage  # noqa: F401 - registers the environments
from khepera_forage.policies.baselines import BaselinePolicy, WheelsPolicy, algorithm_named
from khepera_forage.policies.features import behaviour_features, wheels_features
from khepera_forage.policies.learners import FromSteps

MakeEnv = Callable[[int], gym.vector.VectorEnv[Any, Any, Any]]
"""From a number of environments to as many in one, starting again in the step that ends an episode."""
ENVS = 8


class Trained(NamedTuple):
    """A policy and what it took.

    Attributes:
        policy: It learns no further.
        steps: Steps of the environment, over all copies of it, that it has learned from.
        seconds: Wall time of the training so far.
    """

    policy: BaselinePolicy | WheelsPolicy
    steps: int
    seconds: float


def recall_envs(arena: str = "corridor", wheels: bool = False, mode: str = "sync", **kwargs: Any) -> MakeEnv:
    """Makes as many recall environments as are asked for.

    Args:
        arena: `corridor` or `rectangle`.
        wheels: Whether motors are commanded, and not behaviours.
        mode: `sync`, in this process, or `async`, a process each.
        **kwargs: Others of the environment.
    """

    def make(count: int) -> gym.vector.VectorEnv[Any, Any, Any]:
        return gym.make_vec(
            f"khepera_forage:khepera_forage/{arena.capitalize()}{'Wheels' if wheels else ''}-v0",
            num_envs=count,
            vectorization_mode=mode,
            vector_kwargs={"autoreset_mode": AutoresetMode.SAME_STEP},
            **kwargs,
        )

    return make


def reinforce(
    learner: FromSteps,
    amounts: Sequence[int],
    seed: int,
    make_env: MakeEnv | None = None,
    envs: int = ENVS,
    watch: Callable[[int], object] | None = None,
) -> list[Trained]:
    """Train once, and keep what the learner is after each amount of steps.

    The same seed gives the same policies on the same machine. Where an algorithm plans its exploration over the whole
    training, that is the largest amount.

    Args:
        learner: From `policies.learners.LEARNERS`.
        amounts: Steps over all environments after which to keep the policy, each above 0; reached to within what the
            algorithm takes at a time.
        seed: Of the algorithm and of the environments.
        make_env: Makes the environments, all in one; by default those of the corridor.
        envs: How many.
        watch: Called with the steps so far.

    Returns:
        One for each amount, in increasing order.

    Raises:
        ValueError: No amount, or one that is not above 0.
        ImportError: stable-baselines3 is not installed.
    """
    wanted = sorted(set(amounts))
    if not wanted or wanted[0] < 1:
        raise ValueError(f"amounts are {list(amounts)}; allowed: one or more, each above 0")
    algorithm = algorithm_named(learner.algorithm)
    from stable_baselines3.common.callbacks import BaseCallback

    from khepera_forage.experiments.vector_bridge import VectorBridge

    make = make_env if make_env is not None else recall_envs(wheels=learner.wheels)
    env = VectorBridge(make(envs), wheels_features if learner.wheels else behaviour_features)
    kept: list[Trained] = []
    began = perf_counter()

    class Keeper(BaseCallback):  # type: ignore[misc, unused-ignore]
        """Keeps the policy as it is before it collects more steps, after each amount of them."""

        def _on_step(self) -> bool:
            return True

        def _on_rollout_start(self) -> None:
            if watch is not None:
                watch(self.num_timesteps)
            self.keep(wanted[:-1])

        def keep(self, reached: Sequence[int]) -> None:
            """A copy for each of these amounts that is reached and not kept yet."""
            policy = (
                WheelsPolicy(self.model) if learner.wheels else BaselinePolicy(self.model, learner.sample)
            )
            for amount in reached[len(kept) :]:
                if self.model.num_timesteps >= amount:
                    twin = pickle.loads(pickle.dumps(policy))
                    kept.append(Trained(twin, self.model.num_timesteps, perf_counter() - began))

    with closing(env), _chance_of_its_own():
        model = algorithm("MlpPolicy", env, seed=seed, device="cpu", **learner.settings)
        keeper = Keeper()
        model.learn(wanted[-1], callback=keeper)
        keeper.keep(wanted)
    return kept


@contextmanager
def _chance_of_its_own() -> Iterator[None]:
    """Give back the global sources of chance as they were, which stable-baselines3 seeds and draws from.

    On one thread: networks this small are slower on two, and their sums would depend on how many there are.
    """
    torch = import_module("torch")
    before, python, threads = np.random.get_state(), random.getstate(), torch.get_num_threads()  # noqa: NPY002
    torch.set_num_threads(1)
    try:
        with torch.random.fork_rng(devices=[]):
            yield
    finally:
        torch.set_num_threads(threads)
        random.setstate(python)
        np.random.set_state(before)  # noqa: NPY002
