"""Gymnasium's vector environments as stable-baselines3 takes them (extra `baselines`)."""

from collections.abc import Callable, Sequence
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import create_empty_array
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv

Features = Callable[[Any], NDArray[np.float32]]


class VectorBridge(VecEnv):  # type: ignore[misc, unused-ignore]  # untyped where stable-baselines3 is not installed
    """Shows the features of what a vector environment shows.

    Args:
        env: Whose environments start again in the very step that ends an episode (`AutoresetMode.SAME_STEP`).
        features: From observations of all environments to one row of numbers each.
        hold: Rounds that a decision holds; what they bring is added up. Above 1 the environment must know the option
            `reset_mask`, as Gymnasium's own do: an episode that ends in between starts again at the end.

    Raises:
        ValueError: A vector environment that starts again in another way.
    """

    def __init__(self, env: gym.vector.VectorEnv[Any, Any, Any], features: Features, hold: int = 1) -> None:
        mode = env.metadata.get("autoreset_mode")
        if mode != AutoresetMode.SAME_STEP:
            raise ValueError(f"autoreset_mode is {mode}; allowed: {AutoresetMode.SAME_STEP}")
        self._env, self._features, self._hold = env, features, hold
        self._next_seed: int | None = None
        self._actions: NDArray[Any] | None = None
        shape = features(create_empty_array(env.single_observation_space)).shape
        space = spaces.Box(-np.inf, np.inf, shape[1:], np.float32)
        super().__init__(env.num_envs, space, env.single_action_space)

    def seed(self, seed: int | None = None) -> list[int | None]:
        """Seed the next reset."""
        self._next_seed = seed
        return [seed] * self.num_envs

    def reset(self) -> NDArray[np.float32]:
        """Start an episode in every environment."""
        shown, _ = self._env.reset(seed=self._next_seed)
        self._next_seed = None
        return self._features(shown)

    def step_async(self, actions: NDArray[Any]) -> None:
        """Take the actions of all environments."""
        self._actions = actions

    def step_wait(
        self,
    ) -> tuple[NDArray[np.float32], NDArray[np.float32], NDArray[np.bool_], list[dict[str, Any]]]:
        """What came of them; what an ended episode showed last is in its info."""
        rewards, ended = np.zeros(self.num_envs), np.zeros(self.num_envs, np.bool_)
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        early = ended
        for _ in range(self._hold):
            early = ended
            shown, more, terminated, truncated, info = self._env.step(self._actions)
            rewards += np.where(ended, 0.0, more)
            for i in (~ended & (terminated | truncated)).nonzero()[0]:
                infos[i] = {
                    "terminal_observation": self._features(info["final_obs"][i])[0],
                    "TimeLimit.truncated": bool(truncated[i] and not terminated[i]),
                }
            ended = ended | terminated | truncated
        if early.any():
            shown, _ = self._env.reset(options={"reset_mask": early})
        return self._features(shown), rewards.astype(np.float32), ended, infos

    def close(self) -> None:
        """Close every environment."""
        self._env.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """An attribute of the vector environment, once for every environment asked for."""
        return [getattr(self._env, attr_name)] * len(self._chosen(indices))

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Not possible: the environments may live elsewhere."""
        raise NotImplementedError(f"{attr_name} cannot be set from outside")

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> list[Any]:
        """Not possible: the environments may live elsewhere."""
        raise NotImplementedError(f"{method_name} cannot be called from outside")

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """No environment is wrapped in anything of stable-baselines3."""
        return [False] * len(self._chosen(indices))

    def _chosen(self, indices: int | Sequence[int] | None) -> list[int]:
        return list(range(self.num_envs)) if indices is None else list(np.atleast_1d(indices))
