"""What `gym.make` makes: the same environment in one of two physics."""

from importlib import import_module
from importlib.util import find_spec
from typing import Any

import gymnasium as gym

from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.recall import RecallEnv
from khepera_forage.envs.wheels_env import WheelsEnv

PHYSICS = ("pymunk", "batch")
"""Rigid bodies of pymunk; or the kernels of `make_vec`, for one world, some ten times as fast."""


class Choice:
    """An environment's entry point.

    Args:
        plain: Its class in pymunk's physics.
        compiled: Name of its class in `envs.compiled.single`, which needs numba.
    """

    metadata = RecallEnv.metadata

    def __init__(self, plain: type[gym.Env[Any, Any]], compiled: str) -> None:
        self._plain = plain
        self._compiled = compiled

    def __call__(self, physics: str = "pymunk", **kwargs: Any) -> gym.Env[Any, Any]:
        """Make the environment.

        Args:
            physics: One of `PHYSICS`.
            kwargs: As its class has them.

        Raises:
            ValueError: Another physics.
            ImportError: Physics that need numba, which is not installed.
        """
        if check_physics(physics) == "pymunk":
            return self._plain(**kwargs)
        if find_spec("numba") is None:
            raise ImportError(
                "physics is 'batch', which needs numba: pip install 'khepera-forage[fast]'; "
                "'pymunk' does without"
            )
        made = getattr(import_module("khepera_forage.envs.compiled.single"), self._compiled)
        env: gym.Env[Any, Any] = made(**kwargs)
        return env


def check_physics(physics: Any) -> str:
    """The physics that a user asked for.

    Raises:
        ValueError: Not one of `PHYSICS`.
    """
    if physics not in PHYSICS:
        raise ValueError(f"physics is {physics!r}; allowed: {', '.join(map(repr, PHYSICS))}")
    return str(physics)


behaviours = Choice(BehavioursEnv, "CompiledBehavioursEnv")
wheels = Choice(WheelsEnv, "CompiledWheelsEnv")
