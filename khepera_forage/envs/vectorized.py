"""What `gym.make_vec` makes: the compiled batch where numba is installed, otherwise plain environments side by side."""

from functools import partial
from importlib.util import find_spec
from typing import Any

import gymnasium as gym
from gymnasium.vector import SyncVectorEnv, VectorEnv

from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.wheels_env import WheelsEnv


def behaviours(num_envs: int = 1, **kwargs: Any) -> VectorEnv[Any, Any, Any]:
    """`BehavioursEnv` in many worlds; arguments as `BehavioursVectorEnv`."""
    if _compiled():
        from khepera_forage.envs.batch.vector_envs import BehavioursVectorEnv

        return BehavioursVectorEnv(num_envs, **kwargs)
    return _side_by_side(BehavioursEnv, num_envs, **kwargs)


def wheels(num_envs: int = 1, **kwargs: Any) -> VectorEnv[Any, Any, Any]:
    """`WheelsEnv` in many worlds; arguments as `WheelsVectorEnv`."""
    if _compiled():
        from khepera_forage.envs.batch.vector_envs import WheelsVectorEnv

        return WheelsVectorEnv(num_envs, **kwargs)
    return _side_by_side(WheelsEnv, num_envs, **kwargs)


def _compiled() -> bool:
    return find_spec("numba") is not None


def _side_by_side(
    env: Any, num_envs: int, autoreset_mode: Any = "NextStep", **kwargs: Any
) -> VectorEnv[Any, Any, Any]:
    gym.logger.warn(
        "numba is not installed: worlds are simulated one after the other, hundreds of times as slow; "
        "pip install 'khepera-forage[fast]' compiles them"
    )
    return SyncVectorEnv([partial(env, **kwargs)] * num_envs, autoreset_mode=autoreset_mode)
