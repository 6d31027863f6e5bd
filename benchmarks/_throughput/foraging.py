"""Environments under the teacher, as a user makes and steps them."""

from collections.abc import Callable
from time import perf_counter
from typing import Any

import gymnasium as gym
import numpy as np

from _throughput.lines import Job, Measure, Values
from khepera_forage.envs import paired_corridors_v0
from khepera_forage.envs.training import TEACHER
from khepera_forage.policies import Teacher
from khepera_forage.policies.listener import Listener
from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, JAW_OPEN, MAX_SPEED, applicable

SECTION = "Environments"
NOTE = (
    "As a user makes and steps them, the expert deciding; physics, infra-reds, camera, perception, policy and wrappers "
    "included."
)
CORRIDOR = Measure(SECTION, "Corridor-v0, resets included", "steps/s", "gym.make, Teacher", 15_000)
CORRIDOR_STEPS = Measure(SECTION, "Corridor-v0, resets left out", "steps/s", "the same run")
RECTANGLE = Measure(SECTION, "Rectangle-v0, resets included", "steps/s", "gym.make, Teacher")
WHEELS = Measure(
    SECTION, "CorridorWheels-v0, resets included", "steps/s", "gym.make, the teacher's motors as action"
)
PAIRED = Measure(
    SECTION,
    "paired corridors, resets included",
    "rounds/s",
    "paired_corridors_v0.env, both robots: agent_iter, last, Teacher and Listener",
    4_000,
)

Act = Callable[[Any], Any]


def corridor_job(steps: int, seed: int) -> Job:
    """Measure Corridor-v0, with resets and without."""
    return _recall_job("Corridor", steps, seed, _teacher, CORRIDOR, CORRIDOR_STEPS)


def rectangle_job(steps: int, seed: int) -> Job:
    """Measure Rectangle-v0."""
    return _recall_job("Rectangle", steps, seed, _teacher, RECTANGLE)


def wheels_job(steps: int, seed: int) -> Job:
    """Measure CorridorWheels-v0."""
    return _recall_job("CorridorWheels", steps, seed, _teachers_motors, WHEELS)


def paired_job(rounds: int, seed: int) -> Job:
    """Measure the paired corridors."""

    def run() -> Values:
        env = paired_corridors_v0.env()
        teacher, listener = Teacher(env.unwrapped.home_radius), Listener()
        done = 0
        start = perf_counter()
        env.reset(seed=seed)
        while done < rounds:
            for agent in env.agent_iter():
                observation, _, terminated, truncated, _ = env.last()
                if terminated or truncated:
                    env.step(None)
                    continue
                if agent == TEACHER:
                    done += 1
                    env.step(int(teacher.act(observation)))
                else:
                    env.step(int(listener.act(observation)))
            env.reset()
        rate = done / (perf_counter() - start)
        env.close()
        return {PAIRED: rate}

    return run


def _recall_job(
    name: str, steps: int, seed: int, policy: Callable[[gym.Env[Any, Any]], Act], *measures: Measure
) -> Job:
    """Measure steps with resets and, as the second measure if there is one, without."""

    def run() -> Values:
        env = gym.make(f"khepera_forage/{name}-v0")
        act = policy(env)
        resetting = 0.0
        start = perf_counter()
        observation, _ = env.reset(seed=seed)
        resetting += perf_counter() - start
        for _ in range(steps):
            observation, _, terminated, truncated, _ = env.step(act(observation))
            if terminated or truncated:
                begun = perf_counter()
                observation, _ = env.reset()
                resetting += perf_counter() - begun
        taken = perf_counter() - start
        env.close()
        return dict(zip(measures, (steps / taken, steps / (taken - resetting)), strict=False))

    return run


def _teacher(env: gym.Env[Any, Any]) -> Act:
    return Teacher(env.unwrapped.home_radius).act  # type: ignore[attr-defined]


def _teachers_motors(env: gym.Env[Any, Any]) -> Act:
    """What the teacher's behaviour commands now, as an action of the Wheels environments."""
    unwrapped: Any = env.unwrapped

    def act(observation: object) -> Any:
        forager = unwrapped.forager
        left, right, arm, jaw = applicable(forager.motors_for(forager.correct_behaviour))
        raised = (ARM_DOWN + ARM_RAISED - 2 * arm) / (ARM_DOWN - ARM_RAISED)
        shut = 1.0 if jaw < JAW_OPEN / 2 else -1.0
        return np.array((left / MAX_SPEED, right / MAX_SPEED, raised, shut), np.float32)

    return act
