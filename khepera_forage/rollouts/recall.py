"""The recall phase (4.6, 5.4): one episode of a policy that chooses behaviours, or motors (4.8)."""

import math
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any, NamedTuple, TypeVar

import gymnasium as gym
import numpy as np
from gymnasium import spaces
from gymnasium.wrappers import OrderEnforcing, PassiveEnvChecker

from khepera_forage.envs.arena_settings import environment_name, settings_of
from khepera_forage.envs.arguments import whole_number
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.recall import RecallEnv
from khepera_forage.envs.wheels_env import WheelsEnv
from khepera_forage.noise import Noise
from khepera_forage.policies import Neighbours
from khepera_forage.policies.models import as_policy, completed
from khepera_forage.rollouts.rows import IMITATOR, STATES, RecallRow
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.simulation import Simulation
from khepera_forage.sim.world import World
from khepera_forage.task.decisions import decisions_text
from khepera_forage.task.episode import DecisionCounts, count_decision
from khepera_forage.task.food_tracking import is_collected
from khepera_forage.task.states import Behaviour, behaviour_number
from khepera_forage.vision.scene import MM_PER_PIXEL

Callback = Callable[[], object]
_Env = TypeVar("_Env", bound=RecallEnv[Any])


class RecallInterruptedError(ConnectionError):
    """A real robot or the camera was lost, so that the episode has no result."""


@contextmanager
def stopping(env: Any) -> Iterator[None]:
    """A block after whose errors and interrupts the robots of an environment stop: nobody commands them any more."""
    try:
        yield
    except BaseException:
        env.world.stop()
        raise


def noise_of_world(world: World) -> str:
    """The noise condition that rows of a world name: "laboratory", "none", or "other"; real robots are "laboratory"."""
    if not isinstance(world, Simulation):
        return "laboratory"
    return {Noise.laboratory(): "laboratory", Noise.none(): "none"}.get(world.noise, "other")


def recall_env(
    arena: str | Arena, noise: Noise | str | None = "laboratory", limit: int | None = None, **kwargs: Any
) -> BehavioursEnv:
    """The recall environment of an arena.

    Args:
        arena: One of `ARENAS`, or an arena of your own.
        noise: The laboratory's noise by default.
        limit: Time limit in steps; that of the environment by default.
        **kwargs: Further arguments of the environment.
    """
    return _env_of(BehavioursEnv, "", arena, noise, limit, **kwargs)


def _env_of(
    kind: type[_Env], suffix: str, arena: str | Arena, noise: Noise | str | None, limit: int | None, **kwargs: Any
) -> _Env:
    """A recall environment without wrappers; the suffix is that of its kind in names of environments."""
    settings = settings_of(arena)
    if limit is not None:
        kwargs["limit"] = limit
    if isinstance(arena, Arena):
        return kind(noise=noise, **settings | kwargs)
    name = f"khepera_forage/{environment_name(arena)}{suffix}-v1"
    env = gym.make(name, noise=noise, disable_env_checker=True, **kwargs).unwrapped
    assert isinstance(env, kind)
    return env


def behaviours_env(env: gym.Env[Any, Any]) -> Any:
    """An environment of behaviours without its wrappers, on either backend.

    Warns:
        UserWarning: Wrappers that `gym.make` does not always add are left out.

    Raises:
        TypeError: The environment is of another kind.
    """
    own, given, left_out = getattr(env, "unwrapped", env), env, []
    if not hasattr(type(own), "forager") or not isinstance(own.action_space, spaces.Discrete):
        raise TypeError(
            f"env is {env}; allowed: Corridor-v1, Rectangle-v1, or another BehavioursEnv; "
            "recall_wheels takes CorridorWheels-v1 and other environments of motors"
        )
    while isinstance(given, gym.Wrapper):
        if not isinstance(given, PassiveEnvChecker | OrderEnforcing):
            left_out.append(type(given).__name__)
        given = given.env
    if left_out:
        warnings.warn(
            f"{', '.join(left_out)} left out: recalls take place in the environment without its wrappers; use its "
            "argument limit instead of TimeLimit, and ModelPolicy(model, features, hold) instead of ActionRepeat and "
            "wrappers of observations; recall(env.unwrapped, ...) does not warn",
            stacklevel=3,
        )
    return own


def recall(
    env: gym.Env[Any, Any],
    policy: Any,
    seed: int,
    *,
    learner: str = IMITATOR,
    noise: str | None = None,
    replication: int = 0,
    episodes: int = 0,
    file_id: str = "-",
    number: int = 0,
    experience_size: int = 0,
    callback: Callback | None = None,
) -> RecallRow:
    """Forage alone until all food is at home or the time limit is reached.

    Args:
        env: From `recall_env`, or another environment of behaviours as `gym.make` returns it. Wrappers are left out:
            the policy sees the environment's own observations. A warning names wrappers of yours.
        policy: Chooses the behaviours, or is something that `as_policy` makes a policy of; the ties of a
            nearest-neighbour imitator are counted. `Teacher()` becomes the teacher of `env`.
        seed: Of the episode: places, noise, and random choices of the policy.
        learner: Name of the policy, for the row.
        noise: Name of the noise condition, for the row; by default that of the environment (`noise_of_world`).
        replication: For the row.
        episodes: Training episodes of the policy, for the row.
        file_id: The thesis's name of its training files, for the row.
        number: Of the recall with these files, for the row.
        experience_size: Number of the policy's experience vectors, for the row.
        callback: Called after every decision and at the end. It may render the environment, which then shows an
            imitator's confidence levels.

    Raises:
        RecallInterruptedError: A real robot or the camera was lost; the robot was stopped.
        TypeError: An environment of another kind, or no policy.
        ValueError: The seed is no whole number, or an action no behaviour.
    """
    own, seed = behaviours_env(env), whole_number("seed", seed, 0)
    rng = np.random.default_rng((seed, 1))
    observation, info = own.reset(seed=seed)
    own.confidence = None  # that of an earlier policy
    policy = completed(policy, own)
    find_neighbours = getattr(policy, "neighbours", None)
    decisions, counts = own.decisions.values(), DecisionCounts()
    ties = conflicts = 0
    done = False
    with stopping(own):
        while not done:
            if find_neighbours is not None:
                neighbours: Neighbours = find_neighbours(observation)
                ties += neighbours.tie
                conflicts += neighbours.conflict
                action = neighbours.draw(rng)
                if callback is not None:
                    levels = neighbours.confidence_levels()
                    own.confidence = tuple(levels.get(b, 0.0) for b in list(Behaviour)[:STATES])
            else:
                action = Behaviour(behaviour_number(policy.act(observation, rng), STATES, type(policy).__name__))
            if callback is not None:
                callback()
            food_distance = observation["robot_food_distance"].item()
            count_decision(counts, info["state"], action, food_distance, decisions)
            observation, _, terminated, truncated, info = own.step(action)
            done = terminated or truncated
    if callback is not None:
        callback()
    if "robot_lost" in info:
        raise RecallInterruptedError(f"after {info['steps']} steps: {info['robot_lost']}")
    start = own.layout.starts[0]
    x, y, heading = _in_arena(own.arena, start.x, start.y, start.heading)
    foods = [_in_arena(own.arena, food.x, food.y) for food in own.layout.foods]
    return RecallRow(
        replication=replication,
        arena=own.arena.name,
        episodes=episodes,
        file_id=file_id,
        recall=number,
        seed=seed,
        learner=learner,
        noise=noise_of_world(own.world) if noise is None else noise,
        correct=info["correct"],
        steps=info["steps"],
        limit=own.limit,
        penalty=int(info["penalty"]),
        score=info["score"],
        delivered=info["delivered"],
        foods=own.foods,
        poison_home=info["poison_home"],
        food_x=tuple(food[0] for food in foods),
        food_y=tuple(food[1] for food in foods),
        food_delivered=tuple(is_collected(food) for food in own.forager.food.objects),
        start_x=x,
        start_y=y,
        start_heading=heading,
        rounds_by_state=tuple(counts.by_state),
        wrong_by_state=tuple(counts.wrong_by_state),
        orient_without_food=counts.orient_without_food,
        ties=ties,
        conflicts=conflicts,
        experience_size=experience_size,
        decisions=decisions_text(own.decisions),
    )


def _in_arena(arena: Arena, x: float, y: float, heading: float = 0.0) -> tuple[float, float, float]:
    """A pose relative to the home: x along the arena and y across it, in pixels, and the heading in degrees."""
    return (
        round((x - arena.home.x) / MM_PER_PIXEL, 2),
        round((y - arena.home.y) / MM_PER_PIXEL, 2),
        round(math.degrees(heading), 1),
    )


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
    arena: str | Arena, noise: Noise | str | None = "laboratory", limit: int | None = None, **kwargs: Any
) -> WheelsEnv:
    """The recall environment of an arena whose actions are motor commands; arguments as of `recall_env`."""
    return _env_of(WheelsEnv, "Wheels", arena, noise, limit, **kwargs)


def recall_wheels(env: gym.Env[Any, Any], policy: Any, seed: int, *, callback: Callback | None = None) -> WheelsRecall:
    """Forage alone until all food is at home or the time limit is reached.

    Args:
        env: From `recall_wheels_env`, or another environment of motors as `gym.make` returns it, with its wrappers.
        policy: Its `act(observation, rng)` gives motors for raw data: left wheel, right wheel, arm and jaw, each -1..1,
            as `CorridorWheels-v1` takes them. Or a trained model, of which `as_policy` makes such a policy.
        seed: Of the episode: places, noise, and random choices of the policy.
        callback: Called before every step and at the end.

    Raises:
        RecallInterruptedError: A real robot or the camera was lost; the robot was stopped.
        TypeError: An environment of another kind.
    """
    own, seed = env.unwrapped, whole_number("seed", seed, 0)
    rng = np.random.default_rng((seed, 1))
    if not isinstance(own, WheelsEnv):
        raise TypeError(f"env is {env}; allowed: CorridorWheels-v1, RectangleWheels-v1, or another WheelsEnv")
    if not callable(getattr(policy, "act", None)):
        policy = as_policy(policy)
    observation, _ = env.reset(seed=seed)
    done = False
    with stopping(own):
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
