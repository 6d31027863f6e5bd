"""The recall phase of a policy that commands wheels, arm and jaw: one episode, one row (4.8, 5.4)."""

from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from khepera_forage.envs.wheels_env import WheelsEnv
from khepera_forage.noise import Noise
from khepera_forage.rollouts.recall import RecallCutShort, Watch, unwrapped_env


class MotorPolicy(Protocol):
    """Who decides what the motors do next; `policies.baselines.WheelsPolicy` is one."""

    def act(self, observation: dict[str, Any], rng: np.random.Generator | None = None) -> NDArray[Any]:
        """Left wheel, right wheel, arm and jaw, each -1..1, as `CorridorWheels-v0` takes them.

        Args:
            observation: The raw data that the environment shows.
            rng: Where a policy that decides by chance draws from.
        """
        ...


class WheelsRecall(NamedTuple):
    """What became of one recall.

    Attributes:
        score: Equation 5.1, percent. A step is correct when the motors, as applied, are those that the teacher's
            behaviour commands: whoever forages in another way scores near -penalty or 0.
        steps: How many it took.
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
    arena: str, noise: Noise | None = None, limit: int | None = None, **kwargs: Any
) -> WheelsEnv:
    """The recall environment of one of the thesis' arenas that takes motors.

    Args:
        arena: `corridor` or `rectangle`.
        noise: The laboratory's troubles by default.
        limit: Steps; the thesis' by default.
        **kwargs: Others of the environment.
    """
    return unwrapped_env(WheelsEnv, f"{arena.capitalize()}Wheels-v0", noise, limit, **kwargs)


def recall_wheels(
    env: WheelsEnv, policy: MotorPolicy, seed: int, *, watch: Watch | None = None
) -> WheelsRecall:
    """Forage alone, motors commanded, until all food is home or time runs out.

    Args:
        env: From `recall_wheels_env`.
        policy: Who decides.
        seed: Of the episode: places, noise, and the policy's own draws.
        watch: Called after the reset and after every step.

    Raises:
        RecallCutShort: A real robot or the camera was lost; the robot was stopped.
    """
    draws = np.random.default_rng((seed, 1))
    observation, _ = env.reset(seed=seed)
    over = False
    while not over:
        if watch is not None:
            watch()
        observation, _, terminated, truncated, info = env.step(policy.act(observation, draws))
        over = terminated or truncated
    if watch is not None:
        watch()
    if "robot_lost" in info:
        raise RecallCutShort(f"after {info['steps']} steps: {info['robot_lost']}")
    return WheelsRecall(
        score=info["score"],
        steps=info["steps"],
        delivered=info["delivered"],
        foods=env.foods,
        poison_home=info["poison_home"],
        correct=info["correct"],
    )
