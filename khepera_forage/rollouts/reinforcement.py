"""Reinforcement learning: stable-baselines3 on the recall environments (extra `baselines`)."""

import copy
import logging
import pickle
import random
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import closing, contextmanager
from importlib import import_module
from importlib.util import find_spec
from time import perf_counter
from typing import Any, NamedTuple

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode

import khepera_forage  # noqa: F401 - registers the environments
from khepera_forage.envs.arena_settings import environment_name
from khepera_forage.envs.arguments import whole_number
from khepera_forage.envs.backends import COMPILED, check_backend
from khepera_forage.policies.features import behaviour_features, wheels_features
from khepera_forage.policies.learners import ReinforcementLearner
from khepera_forage.policies.models import ModelPolicy, algorithm_named
from khepera_forage.sim.arenas.named import ARENAS

MakeEnv = Callable[[int], gym.vector.VectorEnv[Any, Any, Any]]
"""From a number of environments to a vector environment that begins new episodes in the step that ends one."""
COMPILED_MODE = "vector_entry_point"
"""Gymnasium's `vectorization_mode` for compiled environments."""
PYMUNK_ENVS = 8
"""Environments that learners train in on pymunk."""
_log = logging.getLogger(__name__)


class TrainedPolicy(NamedTuple):
    """A policy and the training behind it.

    Attributes:
        policy: It learns no further.
        steps: Steps that it has learned from, over all environments.
        seconds: Wall time of the training so far.
    """

    policy: ModelPolicy
    steps: int
    seconds: float


def recall_envs(arena: str = "corridor", wheels: bool = False, mode: str = "sync", **kwargs: Any) -> MakeEnv:
    """A function that makes recall environments.

    Args:
        arena: One of `ARENAS`.
        wheels: Whether actions are motors, and not behaviours.
        mode: Gymnasium's `vectorization_mode`: `sync` or `async` on pymunk, `vector_entry_point` compiled.
        **kwargs: Other arguments of the environment.

    Raises:
        ValueError: Another arena.
    """
    if arena not in ARENAS:
        raise ValueError(f"arena is {arena!r}; allowed: {', '.join(ARENAS)}")
    name = f"{environment_name(arena)}{'Wheels' if wheels else ''}-v1"
    same_step = {"autoreset_mode": AutoresetMode.SAME_STEP}
    kwargs |= same_step if mode == COMPILED_MODE else {"vector_kwargs": same_step}

    def make(count: int) -> gym.vector.VectorEnv[Any, Any, Any]:
        name_and_module = f"khepera_forage:khepera_forage/{name}"
        return gym.make_vec(name_and_module, num_envs=count, vectorization_mode=mode, **kwargs)

    return make


def reinforce(
    learner: ReinforcementLearner,
    amounts: Sequence[int],
    seed: int,
    make_env: MakeEnv | None = None,
    envs: int | None = None,
    arena: str = "corridor",
    backend: str = COMPILED,
) -> list[TrainedPolicy]:
    """Train once, and keep what the learner is after each amount of steps.

    The same seed gives the same policies on the same machine. Where an algorithm plans its exploration over the whole
    training, that is the largest amount.

    Args:
        learner: From `policies.learners.LEARNERS`.
        amounts: Steps over all environments after which to keep the policy, each above 0; reached to within what the
            algorithm takes at a time.
        seed: Of the algorithm and of the environments.
        make_env: Makes the environments, all in one. By default those of `arena` on `backend`.
        envs: How many; by default as many as the learner's settings say if compiled, 8 otherwise.
        arena: One of `ARENAS`.
        backend: `compiled`, or `pymunk`, which needs no numba and takes longer.

    Returns:
        One for each amount, in increasing order.

    Raises:
        TypeError: Another kind of learner.
        ValueError: No amount, or one that is not above 0; a seed or number of environments out of range; another arena
            or backend.
        ImportError: stable-baselines3, or numba for the backend `compiled`, is not installed.
    """
    if not isinstance(learner, ReinforcementLearner):
        raise TypeError(f"learner is {learner!r}; allowed: a ReinforcementLearner, such as LEARNERS['ppo']")
    wanted = sorted({whole_number("amount", one, 1) for one in amounts}) if isinstance(amounts, Iterable) else []
    if not wanted:
        raise ValueError(f"amounts are {amounts!r}; allowed: one or more whole numbers of at least 1")
    seed = whole_number("seed", seed, 0, 2**32 - 1)
    envs = None if envs is None else whole_number("envs", envs, 1)
    algorithm = algorithm_named(learner.algorithm)
    from stable_baselines3.common.callbacks import BaseCallback
    from stable_baselines3.common.logger import Logger

    from khepera_forage.rollouts.sb3_vector_env import VecEnvAdapter

    if make_env is None:
        compiled = check_backend(backend) == COMPILED
        make_env = recall_envs(arena, learner.wheels, COMPILED_MODE if compiled else "sync")
        envs = envs or (learner.worlds if compiled else PYMUNK_ENVS)
        _log.info("%s trains in %d environments on the backend %s", learner.title, envs, backend)
    features = wheels_features if learner.wheels else behaviour_features
    env = VecEnvAdapter(make_env(envs or PYMUNK_ENVS), features, learner.hold)
    # A deep copy, because stable-baselines3 writes into the `policy_kwargs` that it is given.
    settings = copy.deepcopy(dict(learner.settings))
    if "n_steps" in settings:
        # A rollout smaller than a batch is one batch.
        settings["batch_size"] = min(settings["batch_size"], settings["n_steps"] * env.num_envs)
    kept: list[TrainedPolicy] = []
    began = perf_counter()

    class Keeper(BaseCallback):  # type: ignore[misc, unused-ignore]
        """Keeps a copy of the policy after each amount of steps, before more steps are collected."""

        def _on_step(self) -> bool:
            return True

        def _on_rollout_start(self) -> None:
            self.keep(wanted[:-1])

        def keep(self, reached: Sequence[int]) -> None:
            """Keep a copy for each of these amounts that is reached and not kept yet."""
            policy = ModelPolicy(self.model, features, learner.hold, learner.sample)
            for amount in reached[len(kept) :]:
                if self.steps >= amount:
                    copied = pickle.loads(pickle.dumps(policy))
                    kept.append(TrainedPolicy(copied, self.steps, perf_counter() - began))

        @property
        def steps(self) -> int:
            """Steps of the environment: an action counts for all rounds that it holds."""
            return int(self.model.num_timesteps) * learner.hold

    with closing(env), _own_random_state():
        model = algorithm("MlpPolicy", env, seed=seed, device="cpu", **settings)
        # The default logger makes a temporary folder at each training, and leaves it there.
        model.set_logger(Logger(None, []))
        keeper = Keeper()
        model.learn(-(-wanted[-1] // learner.hold), callback=keeper)
        keeper.keep(wanted)
    return kept


@contextmanager
def _own_random_state() -> Iterator[None]:
    """Restore the global random states afterwards, which stable-baselines3 seeds and draws from.

    Training runs on one thread: networks this small are slower on two, and their sums would depend on the number of
    threads; a few hundred compiled worlds wait longer for a second thread than they compute.
    """
    torch = import_module("torch")
    before, python = np.random.get_state(), random.getstate()  # noqa: NPY002
    threads = [(torch.set_num_threads, torch.get_num_threads())]
    if find_spec("numba") is not None:
        numba = import_module("numba")
        threads.append((numba.set_num_threads, numba.get_num_threads()))
    for set_threads, _ in threads:
        set_threads(1)
    try:
        with torch.random.fork_rng(devices=[]):
            yield
    finally:
        for set_threads, number in threads:
            set_threads(number)
        random.setstate(python)
        np.random.set_state(before)  # noqa: NPY002
