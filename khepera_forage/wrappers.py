"""Wrappers for learners: an action that holds for several rounds, in one environment or in many."""

from typing import Any, SupportsFloat

import gymnasium as gym
import numpy as np
from gymnasium.utils import RecordConstructorArgs
from gymnasium.vector import AutoresetMode, VectorEnv, VectorWrapper
from numpy.typing import NDArray

from khepera_forage.deprecation import renamed
from khepera_forage.envs.arguments import whole_number

ROUNDS = 5
"""Rounds that an action holds, by default."""


class ActionRepeat(gym.Wrapper[Any, Any, Any, Any], RecordConstructorArgs):
    """An action that holds for several rounds, or until the episode ends; their rewards are added up.

    A learner that explores at random needs it: a random behaviour in every round delivers almost no food, so that there
    is nothing to learn from.

    ```python
    env = ActionRepeat(gym.make("khepera_forage/Corridor-v1"), rounds=5)
    ```

    Args:
        env: Any environment.
        rounds: That an action holds, at least 1.

    Raises:
        ValueError: `rounds` is no such number, or `env` is a vector environment.
    """

    def __init__(self, env: gym.Env[Any, Any], rounds: int = ROUNDS) -> None:
        if isinstance(env, VectorEnv):
            raise ValueError(f"env is {env!r}; allowed: a single environment (VectorActionRepeat is for many)")
        RecordConstructorArgs.__init__(self, rounds=rounds)
        super().__init__(env)
        self.rounds = whole_number("rounds", rounds, 1)
        self.metadata = _slower(env.metadata, self.rounds)

    def step(self, action: Any) -> tuple[Any, SupportsFloat, bool, bool, dict[str, Any]]:
        """The rounds of one action; observation and info are those after the last of them."""
        total = 0.0
        for _ in range(self.rounds):
            shown, reward, terminated, truncated, info = self.env.step(action)
            total += float(reward)
            if terminated or truncated:
                break
        return shown, total, terminated, truncated, info


class VectorActionRepeat(VectorWrapper):
    """`ActionRepeat` for vector environments that begin a new episode in the step that ends one.

    An episode that begins within the rounds of an action begins again after the last of them, so that every episode has
    its full length. The info holds what was reported last in each environment, in whichever round that was, and
    `held_rounds`: how many rounds of the action each environment has carried out.

    ```python
    env = gym.make_vec("khepera_forage/Corridor-v1", num_envs=64, autoreset_mode="SameStep")
    env = VectorActionRepeat(env, rounds=5)
    ```

    Args:
        env: Has `AutoresetMode.SAME_STEP` and knows the option `reset_mask`, as Gymnasium's own vector environments and
            compiled ones do.
        rounds: That an action holds, at least 1.

    Raises:
        ValueError: Another `AutoresetMode`, or `rounds` is no such number.
    """

    def __init__(self, env: VectorEnv[Any, Any, Any], rounds: int = ROUNDS) -> None:
        check_same_step(env)
        super().__init__(env)
        self.rounds = whole_number("rounds", rounds, 1)
        self.metadata = _slower(env.metadata, self.rounds)

    def step(
        self, actions: Any
    ) -> tuple[Any, NDArray[np.float64], NDArray[np.bool_], NDArray[np.bool_], dict[str, Any]]:
        """The rounds of one action in every environment; final observations and infos are those of each episode."""
        count = self.num_envs
        rewards, held = np.zeros(count), np.zeros(count, np.int64)
        terminated, truncated, early = (np.zeros(count, np.bool_) for _ in range(3))
        info: dict[str, Any] = {}
        for _ in range(self.rounds):
            early = terminated | truncated
            shown, more, now_terminated, now_truncated, report = self.env.step(actions)
            rewards += np.where(early, 0.0, more)
            held += ~early
            terminated |= ~early & now_terminated
            truncated |= ~early & now_truncated
            _put(info, report, ~early)
        if early.any():
            shown, report = self.env.reset(options={"reset_mask": early})
            _put(info, report, early)
        info |= {"held_rounds": held, "_held_rounds": np.ones(count, np.bool_)}
        return shown, rewards, terminated, truncated, info


def check_same_step(env: VectorEnv[Any, Any, Any]) -> None:
    """Check that a vector environment begins a new episode in the step that ends one.

    Raises:
        ValueError: It has another `AutoresetMode`.
    """
    mode = env.metadata.get("autoreset_mode")
    if mode != AutoresetMode.SAME_STEP:
        raise ValueError(
            f"autoreset_mode is {mode}; allowed: {AutoresetMode.SAME_STEP}, as by make_vec(..., "
            'autoreset_mode="SameStep"), or with vectorization_mode="sync" or "async" by make_vec(..., '
            'vector_kwargs={"autoreset_mode": "SameStep"})'
        )


def _slower(metadata: dict[str, Any], rounds: int) -> dict[str, Any]:
    """Metadata of an environment that shows one picture for several rounds: films then have their true speed."""
    fps = metadata.get("render_fps")
    return metadata if fps is None else metadata | {"render_fps": fps / rounds}


def _put(infos: dict[str, Any], others: dict[str, Any], mask: NDArray[np.bool_]) -> None:
    """Take the infos of the environments of a mask from others, where these have them. Arrays are not changed."""
    for name, values in others.items():
        if name.startswith("_") and name[1:] in others:
            infos[name] = infos.get(name, False) | (values & mask)
            continue
        rows = mask & others.get(f"_{name}", True)
        if isinstance(values, dict):
            _put(infos.setdefault(name, {}), values, rows)
        elif name not in infos or rows.all() or not isinstance(values, np.ndarray):
            infos[name] = values
        elif rows.any():
            infos[name] = infos[name].copy()
            infos[name][rows] = values[rows]


def __getattr__(name: str) -> Any:
    """Former names."""
    return renamed(__name__, name, {"HoldAction": ActionRepeat, "HoldVectorAction": VectorActionRepeat})
