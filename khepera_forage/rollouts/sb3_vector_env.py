"""Gymnasium's vector environments as vector environments of stable-baselines3 (extra `baselines`)."""

from collections.abc import Callable, Iterable, Sequence
from time import perf_counter
from typing import Any

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.vector.utils import create_empty_array
from numpy.typing import NDArray

from khepera_forage.envs.arguments import whole_number
from khepera_forage.extras import require
from khepera_forage.wrappers import VectorActionRepeat, check_same_step

require("VecEnvAdapter", "baselines")
from stable_baselines3.common.monitor import Monitor  # noqa: E402 (after the check)
from stable_baselines3.common.vec_env import VecEnv  # noqa: E402

Features = Callable[[Any], NDArray[np.float32]]
Shown = NDArray[np.float32] | dict[str, NDArray[Any]]
"""Features of all environments, one row each; or their observations as they are."""
Indices = int | Iterable[int] | None


class VecEnvAdapter(VecEnv):  # type: ignore[misc, unused-ignore]  # untyped where stable-baselines3 is not installed
    """A `VecEnv` made of a Gymnasium vector environment.

    ```python
    envs = gym.make_vec("khepera_forage/Corridor-v1", num_envs=64, autoreset_mode="SameStep")
    PPO("MlpPolicy", VecEnvAdapter(envs, behaviour_features, hold=5)).learn(200_000)
    ```

    The info of an ended episode holds the environment's final info and, as stable-baselines3 has it,
    `terminal_observation`, `TimeLimit.truncated`, `is_success` (whether the episode terminated) and `episode` with its
    return `r`, its length `l` in rounds and the time `t` since the adapter was made, in seconds. All other infos are
    empty.

    Args:
        env: Its environments begin a new episode in the step that ends one (`AutoresetMode.SAME_STEP`).
        features: From the observations of all environments to one row of numbers each, as `policies.features` has
            them. By default observations stay as they are: dicts, for a `MultiInputPolicy`.
        hold: Rounds that an action holds, as in `VectorActionRepeat`.

    Attributes:
        env: The vector environment, whose actions hold.
        features: As given.

    Raises:
        ValueError: Another `AutoresetMode`, or `hold` out of range.
    """

    def __init__(
        self, env: gym.vector.VectorEnv[Any, Any, Any], features: Features | None = None, hold: int = 1
    ) -> None:
        check_same_step(env)
        self.env = env if whole_number("hold", hold, 1) == 1 else VectorActionRepeat(env, hold)
        self.features = features
        self._next_seed: int | None = None
        self._actions: NDArray[Any] | None = None
        self._returns, self._lengths = np.zeros(env.num_envs), np.zeros(env.num_envs, np.int64)
        self._made = perf_counter()
        space: gym.Space[Any] = env.single_observation_space
        if features is not None:
            shape = features(create_empty_array(space)).shape
            space = spaces.Box(-np.inf, np.inf, shape[1:], np.float32)
        super().__init__(env.num_envs, space, env.single_action_space)
        self.metadata |= {"render_fps": self.env.metadata.get("render_fps", 30)}

    def seed(self, seed: int | None = None) -> list[int | None]:
        """Seed the next reset: environment i with `seed` + i."""
        self._next_seed = seed
        return [None if seed is None else seed + i for i in range(self.num_envs)]

    def reset(self) -> Shown:
        """Begin an episode in every environment, with the options of `set_options`."""
        shared = self._options[0] if all(options == self._options[0] for options in self._options) else {}
        shown, _ = self.env.reset(seed=self._next_seed, options=dict(shared))
        seeds: Any = None if self._next_seed is None else self.seed(self._next_seed)
        for i, options in enumerate(self._options):
            if options != shared:
                mask = np.arange(self.num_envs) == i
                shown, _ = self.env.reset(seed=seeds, options={**options, "reset_mask": mask})
        self._next_seed = None
        self._reset_options()
        self._returns[:], self._lengths[:] = 0.0, 0
        start: Shown = self._shown(shown)
        return start

    def step_async(self, actions: NDArray[Any]) -> None:
        """Note the actions of all environments."""
        self._actions = actions

    def step_wait(self) -> tuple[Shown, NDArray[np.float32], NDArray[np.bool_], list[dict[str, Any]]]:
        """Carry out the actions; returns observations, rewards, ends and infos."""
        shown, rewards, terminated, truncated, info = self.env.step(self._actions)
        ended = terminated | truncated
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        self._returns += rewards
        self._lengths += info.get("held_rounds", 1)
        for i in ended.nonzero()[0].tolist():
            infos[i] = self._final_info(info, i, bool(terminated[i]), bool(truncated[i]))
            seconds = perf_counter() - self._made
            infos[i]["episode"] = {"r": float(self._returns[i]), "l": int(self._lengths[i]), "t": seconds}
        self._returns[ended], self._lengths[ended] = 0.0, 0
        return self._shown(shown), rewards.astype(np.float32), ended, infos

    def close(self) -> None:
        """Close every environment."""
        self.env.close()

    def get_attr(self, attr_name: str, indices: Indices = None) -> list[Any]:
        """An attribute of the vector environment, or else of each of its environments.

        Raises:
            AttributeError: There is no such attribute.
        """
        chosen, base = self._get_indices(indices), self.env.unwrapped
        if hasattr(self.env, attr_name) or not hasattr(base, "get_attr"):
            return [getattr(self.env, attr_name) for _ in chosen]
        values = base.get_attr(attr_name)
        return [values[i] for i in chosen]

    def get_images(self) -> Sequence[NDArray[np.uint8] | None]:
        """A picture of each environment, for `render` and `VecVideoRecorder`."""
        pictures: Any = self.env.render()
        return pictures or [None] * self.num_envs

    def set_attr(self, attr_name: str, value: Any, indices: Indices = None) -> None:
        """Not possible: compiled environments are no objects, and others may be in another process.

        Raises:
            AttributeError: Always.
        """
        raise AttributeError(f"{attr_name!r} cannot be set in the environments of a vector environment")

    def env_method(self, method_name: str, *args: Any, indices: Indices = None, **kwargs: Any) -> list[Any]:
        """The result of a method in each environment, such as `action_masks`.

        Raises:
            AttributeError: There is no such method.
        """
        results = self.env.unwrapped.call(method_name, *args, **kwargs)  # type: ignore[attr-defined]
        return [results[i] for i in self._get_indices(indices)]

    def env_is_wrapped(self, wrapper_class: Any, indices: Indices = None) -> list[bool]:
        """Whether infos have what a wrapper reports: those of `Monitor`, the `episode` with its rounds."""
        return [wrapper_class is Monitor for _ in self._get_indices(indices)]

    def _shown(self, observations: Any) -> Any:
        return observations if self.features is None else self.features(observations)

    def _final_info(self, info: dict[str, Any], i: int, terminated: bool, truncated: bool) -> dict[str, Any]:
        """What is known of an episode that has just ended in environment i, but for `episode`."""
        final, final_obs = info.get("final_info", {}), info["final_obs"][i]
        known = {name: values[i] for name, values in final.items() if f"_{name}" in final and final[f"_{name}"][i]}
        return {
            **known,
            "terminal_observation": final_obs if self.features is None else self.features(final_obs)[0],
            "TimeLimit.truncated": truncated and not terminated,
            "is_success": terminated,
        }
