"""The recall phase of a policy that commands wheels, arm and jaw (4.8, 5.4): one episode, one result."""

from typing import Any, NamedTuple, Protocol

import gymnasium as gym
import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.arena_settings import environment_name
from khepera_forage.envs.wheels_env import WheelsEnv
from khepera_forage.noise import Noise
from khepera_forage.rollouts.recall import Callback, RecallInterruptedError, unwrapped_env


class MotorPolicy(Protocol):
    """Chooses motor commands; `policies.ModelPolicy` can be one."""

    def act(self, observation: dict[str, Any], rng: np.random.Generator | None = None) -> NDArray[Any]:
        """Left wheel, right wheel, arm and jaw, each -1..1, as `CorridorWheels-v1` takes them.

        Args:
            observation: The raw data of the environment.
            rng: Source of a stochastic policy's random choices.
        """
        ...


class WheelsRecall(NamedTuple):
    """The result of one recall.

    Attributes:
        score: Equation 5.1, percent. A step is correct if the applied motor commands are those of the teacher's
            behaviour. A policy that forages in another way has a score near 0 or near -penalty.
        steps: Number of steps.
        delivered: Food brought home that is not poisonous.
        foods: Food objects in the arena.
        poison_home: Poisonous food brought home.
        correct: Steps that were correct.
    """

    score: float
    steps: int
    delivered: int
    foods: int
    poison_home: int
    correct: int


def recall_wheels_env(
    arena: str, noise: Noise | str | None = "laboratory", limit: int | None = None, **kwargs: Any
) -> WheelsEnv:
    """The recall environment of a named arena whose actions are motor commands.

    Args:
        arena: One of `ARENAS`.
        noise: The laboratory's noise by default.
        limit: Time limit in steps; that of the environment by default.
        **kwargs: Further arguments of the environment.
    """
    return unwrapped_env(WheelsEnv, f"{environment_name(arena)}Wheels-v1", noise, limit, **kwargs)


def wheels_env(env: gym.Env[Any, Any]) -> WheelsEnv:
    """An environment of motors without its wrappers.

    Raises:
        TypeError: The environment is of another kind.
    """
    own = env.unwrapped
    if not isinstance(own, WheelsEnv):
        raise TypeError(f"env is {env}; allowed: CorridorWheels-v1, RectangleWheels-v1, or another WheelsEnv")
    return own


def recall_wheels(
    env: gym.Env[Any, Any], policy: MotorPolicy, seed: int, *, callback: Callback | None = None
) -> WheelsRecall:
    """Forage alone until all food is at home or the time limit is reached.

    Args:
        env: From `recall_wheels_env`, or another environment of motors as `gym.make` returns it, with its wrappers.
        policy: Chooses the motor commands.
        seed: Of the episode: places, noise, and random choices of the policy.
        callback: Called before every step and at the end.

    Raises:
        RecallInterruptedError: A real robot or the camera was lost; the robot was stopped.
        TypeError: An environment of another kind.
    """
    own, rng = wheels_env(env), np.random.default_rng((seed, 1))
    observation, _ = env.reset(seed=seed)
    done = False
    while not done:
        if callback is not None:
            callback()
        observation, _, terminated, truncated, info = env.step(policy.act(observation, rng))
        done = terminated or truncated
    if callback is not None:
        callback()
    if "robot_lost" in info:
        raise RecallInterruptedError(f"after {info['steps']} steps: {info['robot_lost']}")
    return WheelsRecall(
        score=info["score"],
        steps=info["steps"],
        delivered=info["delivered"],
        foods=own.foods,
        poison_home=info["poison_home"],
        correct=info["correct"],
    )
