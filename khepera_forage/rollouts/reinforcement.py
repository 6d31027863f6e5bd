"""Learning by trial and error: stable-baselines3 on the recall environments (extra `baselines`)."""

import copy
import logging
import pickle
import random
from collections.abc import Callable, Iterator, Sequence
from contextlib import closing, contextmanager
from importlib import import_module
from importlib.util import find_spec
from time import perf_counter
from typing import Any, NamedTuple

import gymnasium as gym
import numpy as np
from gymnasium.vector import AutoresetMode

import khepera_forage  # noqa: F401 - registers the environments
from khepera_forage.policies.baselines import BaselinePolicy, WheelsPolicy, algorithm_named
from khepera_forage.policies.features import behaviour_features, wheels_features
from khepera_forage.policies.learners import FromSteps
from khepera_forage.sim.arena import ARENAS

MakeEnv = Callable[[int], gym.vector.VectorEnv[Any, Any, Any]]
"""From a number of environments to as many in one, starting again in the step that ends an episode."""
ENVS = 8
"""How many where they are not batched."""
_log = logging.getLogger(__name__)


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
            f"khepera_forage:{_name(arena, wheels)}",
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
    envs: int | None = None,
    watch: Callable[[int], object] | None = None,
    arena: str = "corridor",
) -> list[Trained]:
    """Train once, and keep what the learner is after each amount of steps.

    The same seed gives the same policies on the same machine. Where an algorithm plans its exploration over the whole
    training, that is the largest amount.

    Args:
        learner: From `policies.learners.LEARNERS`.
        amounts: Steps over all environments after which to keep the policy, each above 0; reached to within what the
            algorithm takes at a time.
        seed: Of the algorithm and of the environments.
        make_env: Makes the environments, all in one. By default those of `arena`: a batch of worlds where numba is
            installed, plain environments side by side otherwise; the log says which, at level INFO.
        envs: How many; by default as many as the learner's settings say in a batch, 8 otherwise.
        watch: Called with the steps so far.
        arena: `corridor` or `rectangle`.

    Returns:
        One for each amount, in increasing order.

    Raises:
        ValueError: No amount, or one that is not above 0; another arena.
        ImportError: stable-baselines3 is not installed.
    """
    wanted = sorted(set(amounts))
    if not wanted or wanted[0] < 1:
        raise ValueError(f"amounts are {list(amounts)}; allowed: one or more, each above 0")
    algorithm = algorithm_named(learner.algorithm)
    from stable_baselines3.common.callbacks import BaseCallback
    from stable_baselines3.common.logger import Logger

    env = vec_env(learner, make_env, envs, arena)
    # All of it a copy: stable-baselines3 writes into the `policy_kwargs` that it is given.
    settings = copy.deepcopy(dict(learner.settings))
    if "n_steps" in settings:
        # A rollout smaller than a batch is one batch.
        settings["batch_size"] = min(settings["batch_size"], settings["n_steps"] * env.num_envs)
    kept: list[Trained] = []
    began = perf_counter()

    class Keeper(BaseCallback):  # type: ignore[misc, unused-ignore]
        """Keeps the policy as it is before it collects more steps, after each amount of them."""

        def _on_step(self) -> bool:
            return True

        def _on_rollout_start(self) -> None:
            if watch is not None:
                watch(self.steps)
            self.keep(wanted[:-1])

        def keep(self, reached: Sequence[int]) -> None:
            """A copy for each of these amounts that is reached and not kept yet."""
            kind = WheelsPolicy if learner.wheels else BaselinePolicy
            policy = kind(self.model, learner.hold, learner.sample)
            for amount in reached[len(kept) :]:
                if self.steps >= amount:
                    twin = pickle.loads(pickle.dumps(policy))
                    kept.append(Trained(twin, self.steps, perf_counter() - began))

        @property
        def steps(self) -> int:
            """Of the environment: a decision counts as many as it holds."""
            return int(self.model.num_timesteps) * learner.hold

    with closing(env), _chance_of_its_own():
        model = algorithm("MlpPolicy", env, seed=seed, device="cpu", **settings)
        # The logger of its own makes a temporary folder at each training, and leaves it there.
        model.set_logger(Logger(None, []))
        keeper = Keeper()
        model.learn(-(-wanted[-1] // learner.hold), callback=keeper)
        keeper.keep(wanted)
    return kept


def vec_env(
    learner: FromSteps, make_env: MakeEnv | None = None, envs: int | None = None, arena: str = "corridor"
) -> Any:
    """The environments that a learner learns in, as stable-baselines3 takes them.

    Args:
        learner: What it commands, for how long, and in how many worlds it learns.
        make_env: As for `reinforce`; so are the next two.
        envs: How many.
        arena: `corridor` or `rectangle`.

    Raises:
        ValueError: Another arena.
    """
    if make_env is None and find_spec("numba") is not None:
        from khepera_forage.rollouts.sb3_compiled_vec_env import BatchVecEnv

        count = learner.worlds if envs is None else envs
        _log.info("%s learns in a batch of %d worlds", learner.title, count)
        kwargs = gym.spec(_name(arena, learner.wheels)).kwargs
        return BatchVecEnv(count, **kwargs, wheels=learner.wheels, hold=learner.hold)
    from khepera_forage.rollouts.sb3_vector_env import VectorBridge

    count = ENVS if envs is None else envs
    _log.info("%s learns in %d environments side by side", learner.title, count)
    make = recall_envs(arena, learner.wheels) if make_env is None else make_env
    return VectorBridge(make(count), wheels_features if learner.wheels else behaviour_features, learner.hold)


def _name(arena: str, wheels: bool) -> str:
    if arena not in ARENAS:
        raise ValueError(f"arena is {arena!r}; allowed: {', '.join(ARENAS)}")
    return f"khepera_forage/{arena.capitalize()}{'Wheels' if wheels else ''}-v0"


@contextmanager
def _chance_of_its_own() -> Iterator[None]:
    """Give back the global sources of chance as they were, which stable-baselines3 seeds and draws from.

    On one thread: networks this small are slower on two, and their sums would depend on how many there are; a batch of
    a few hundred worlds spends longer waiting for a second thread than computing.
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
