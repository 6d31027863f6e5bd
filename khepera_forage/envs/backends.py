"""The backends: what simulates the bodies. Entry points of `gym.make` and `gym.make_vec`."""

from collections.abc import Callable, Sequence
from importlib import import_module
from typing import Any

import gymnasium as gym
from gymnasium.vector import VectorEnv

from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.recall import RecallEnv
from khepera_forage.envs.stored_specs import spec_arena, spec_decisions
from khepera_forage.envs.wheels_env import WheelsEnv
from khepera_forage.extras import require
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions

PYMUNK, COMPILED = "pymunk", "compiled"
BACKENDS = (PYMUNK, COMPILED)
"""Rigid bodies of pymunk; or kernels that numba compiles, faster and for many worlds at once."""

VectorWrapping = Callable[[VectorEnv[Any, Any, Any]], VectorEnv[Any, Any, Any]]
"""Wraps a vector environment, such as `khepera_forage.wrappers.HoldVectorAction`."""


class EntryPoint:
    """What `gym.make` calls: makes an environment on one of the backends.

    Args:
        on_pymunk: Class on pymunk.
        compiled: Name of the class in `envs.compiled.single`, which needs numba.
        decisions: Of the environment's version, for users that give none.
    """

    metadata = RecallEnv.metadata

    def __init__(self, on_pymunk: type[gym.Env[Any, Any]], compiled: str, decisions: Decisions) -> None:
        self._on_pymunk = on_pymunk
        self._compiled = compiled
        self._decisions = decisions

    def __call__(self, backend: str = PYMUNK, decisions: Any = None, **kwargs: Any) -> gym.Env[Any, Any]:
        """Make the environment.

        Args:
            backend: One of `BACKENDS`.
            decisions: `Decisions`, or those of a stored spec; by default those of the environment's version.
            kwargs: Other arguments of its class.

        Raises:
            ValueError: Another backend.
            ImportError: The backend "compiled" without numba.
        """
        kwargs["decisions"] = spec_decisions(decisions, self._decisions)
        if "arena" in kwargs:
            kwargs["arena"] = spec_arena(kwargs["arena"])
        if check_backend(backend) == PYMUNK:
            return self._on_pymunk(**kwargs)
        made = getattr(import_module("khepera_forage.envs.compiled.single"), self._compiled)
        env: gym.Env[Any, Any] = made(**kwargs)
        return env


class VectorEntryPoint:
    """What `gym.make_vec` calls: makes compiled worlds, whatever their number.

    Args:
        compiled: Name of the class in `envs.compiled.vector_env`.
        decisions: Of the environment's version, for users that give none.
    """

    def __init__(self, compiled: str, decisions: Decisions) -> None:
        self._compiled = compiled
        self._decisions = decisions

    def __call__(
        self,
        num_envs: int = 1,
        backend: str = COMPILED,
        decisions: Any = None,
        vector_wrappers: Sequence[VectorWrapping] = (),
        **kwargs: Any,
    ) -> VectorEnv[Any, Any, Any]:
        """Make the vector environment.

        Args:
            num_envs: How many worlds.
            backend: Must be "compiled".
            decisions: `Decisions`, or those of a stored spec; by default those of the environment's version.
            vector_wrappers: Wrappers of vector environments, the innermost first. `gym.make_vec` has an argument
                `wrappers` too, but those are for single environments, and Gymnasium refuses them here.
            kwargs: Other arguments of its class.

        Raises:
            ValueError: Another backend, or a wrapper that makes no vector environment.
            ImportError: numba is not installed.
        """
        check_compiled(backend)
        kwargs["decisions"] = spec_decisions(decisions, self._decisions)
        if "arena" in kwargs:
            kwargs["arena"] = spec_arena(kwargs["arena"])
        made = getattr(import_module("khepera_forage.envs.compiled.vector_env"), self._compiled)
        env: VectorEnv[Any, Any, Any] = made(num_envs, **kwargs)
        for wrapper in vector_wrappers:
            env = wrapper(env)
            if not isinstance(env, VectorEnv):
                raise ValueError(
                    f"vector_wrappers has {wrapper!r}, which returns {env!r}; allowed: functions that return a "
                    "gymnasium.vector.VectorEnv"
                )
        return env


def check_backend(backend: Any) -> str:
    """The backend that a user asked for.

    Raises:
        ValueError: Not one of `BACKENDS`.
        ImportError: The backend "compiled" without numba.
    """
    if backend not in BACKENDS:
        raise ValueError(f"backend is {backend!r}; allowed: {', '.join(map(repr, BACKENDS))}")
    if backend == COMPILED:
        instead = "; the backend 'pymunk' works without (in make_vec: vectorization_mode='sync' or 'async')"
        require("the backend 'compiled'", "fast", otherwise=instead)
    return str(backend)


def check_compiled(backend: Any) -> None:
    """Complain about a backend other than "compiled" where worlds are compiled.

    Raises:
        ValueError: Another backend.
        ImportError: numba is not installed.
    """
    if check_backend(backend) != COMPILED:
        raise ValueError(
            f"backend is {backend!r}; allowed here: {COMPILED!r} (make_vec with vectorization_mode='sync' or 'async' "
            "makes worlds of pymunk)"
        )


behaviours = EntryPoint(BehavioursEnv, "CompiledBehavioursEnv", Decisions.v0_1())
wheels = EntryPoint(WheelsEnv, "CompiledWheelsEnv", Decisions.v0_1())
behaviours_vector = VectorEntryPoint("BehavioursVectorEnv", Decisions.v0_1())
wheels_vector = VectorEntryPoint("WheelsVectorEnv", Decisions.v0_1())
"""Of the environments v0. Stored specs contain these names, which therefore stay without a version."""

behaviours_v1 = EntryPoint(BehavioursEnv, "CompiledBehavioursEnv", DEFAULT_DECISIONS)
wheels_v1 = EntryPoint(WheelsEnv, "CompiledWheelsEnv", DEFAULT_DECISIONS)
behaviours_vector_v1 = VectorEntryPoint("BehavioursVectorEnv", DEFAULT_DECISIONS)
wheels_vector_v1 = VectorEntryPoint("WheelsVectorEnv", DEFAULT_DECISIONS)
