"""What `gym.make_vec` makes: the compiled batch where numba is installed, otherwise plain environments side by side."""

from functools import partial
from importlib.util import find_spec
from typing import Any

import gymnasium as gym
from gymnasium.vector import SyncVectorEnv, VectorEnv

from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.entry_points import check_physics
from khepera_forage.envs.wheels_env import WheelsEnv


def behaviours(num_envs: int = 1, physics: str = "batch", **kwargs: Any) -> VectorEnv[Any, Any, Any]:
    """`BehavioursEnv` in many worlds; arguments as `BehavioursVectorEnv`, and which of `envs.entry_points.PHYSICS`."""
    if _compiled(physics):
        from khepera_forage.envs.compiled.vector_envs import BehavioursVectorEnv

        return BehavioursVectorEnv(num_envs, **kwargs)
    return _side_by_side(BehavioursEnv, num_envs, **kwargs)


def wheels(num_envs: int = 1, physics: str = "batch", **kwargs: Any) -> VectorEnv[Any, Any, Any]:
    """`WheelsEnv` in many worlds; arguments as `WheelsVectorEnv`, and which of `envs.entry_points.PHYSICS`."""
    if _compiled(physics):
        from khepera_forage.envs.compiled.vector_envs import WheelsVectorEnv

        return WheelsVectorEnv(num_envs, **kwargs)
    return _side_by_side(WheelsEnv, num_envs, **kwargs)


def _compiled(physics: str) -> bool:
    """Whether to make the compiled batch; says so where it would be better, but cannot."""
    if check_physics(physics) == "pymunk":
        return False
    if find_spec("numba") is not None:
        return True
    gym.logger.warn(
        "numba is not installed: worlds are simulated one after the other, hundreds of times as slow; "
        "pip install 'khepera-forage[fast]' compiles them"
    )
    return False


def _side_by_side(
    env: Any, num_envs: int, autoreset_mode: Any = "NextStep", **kwargs: Any
) -> VectorEnv[Any, Any, Any]:
    return SyncVectorEnv([partial(env, **kwargs)] * num_envs, autoreset_mode=autoreset_mode)
