"""Environments under the teacher, made and stepped as users do."""

from collections.abc import Callable
from time import perf_counter
from typing import Any

import gymnasium as gym
import numpy as np

from khepera_forage.envs import paired_corridors_v1
from khepera_forage.envs.training import TEACHER
from khepera_forage.policies import Teacher
from khepera_forage.policies.listener import Listener
from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, JAW_OPEN, MAX_SPEED, applicable
from timing.measures import Job, Measure, Values

SECTION = "Environments"
NOTE = (
    "Made and stepped as users do, under the teacher; simulation, infra-reds, camera, perception, policy and wrappers "
    "included."
)
CORRIDOR = Measure(SECTION, "Corridor-v1, resets included", "steps/s", "gym.make, Teacher", 15_000)
CORRIDOR_STEPS = Measure(SECTION, "Corridor-v1, resets left out", "steps/s", "the same run")
RECTANGLE = Measure(SECTION, "Rectangle-v1, resets included", "steps/s", "gym.make, Teacher")
WHEELS = Measure(
    SECTION, "CorridorWheels-v1, resets included", "steps/s", "gym.make, the teacher's motors as action"
)
PAIRED = Measure(
    SECTION,
    "paired corridors, resets included",
    "rounds/s",
    "paired_corridors_v1.env, both robots: agent_iter, last, Teacher and Listener",
    4_000,
)

Act = Callable[[Any], Any]


def jobs(steps: int, seed: int) -> list[Job]:
    """All environments; `steps` steps or rounds of each in a repeat."""
    return [
        _recall_job("Corridor", steps, seed, _teacher, CORRIDOR, CORRIDOR_STEPS),
        _recall_job("Rectangle", steps, seed, _teacher, RECTANGLE),
        _recall_job("CorridorWheels", steps, seed, _teachers_motors, WHEELS),
        paired_job(steps, seed),
    ]


def paired_job(rounds: int, seed: int) -> Job:
    """Measure the paired corridors."""

    def run() -> Values:
        env = paired_corridors_v1.env()
        teacher, listener = Teacher.of(env), Listener()
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
        env = gym.make(f"khepera_forage/{name}-v1")
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
    return Teacher.of(env).act


def _teachers_motors(env: gym.Env[Any, Any]) -> Act:
    """The motor command of the teacher's behaviour, as an action of the Wheels environments."""
    unwrapped: Any = env.unwrapped

    def act(observation: object) -> Any:
        forager = unwrapped.forager
        left, right, arm, jaw = applicable(forager.motors_for(forager.correct_behaviour))
        raised = (ARM_DOWN + ARM_RAISED - 2 * arm) / (ARM_DOWN - ARM_RAISED)
        shut = 1.0 if jaw < JAW_OPEN / 2 else -1.0
        return np.array((left / MAX_SPEED, right / MAX_SPEED, raised, shut), np.float32)

    return act
