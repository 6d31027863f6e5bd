"""The time of a step of Corridor-v1, part by part, under a stopwatch.

During the measurement, the methods that make up a step run under a stopwatch, so that every moment of a step counts for
exactly one part.
"""

from contextlib import ExitStack
from time import perf_counter
from typing import Any
from unittest.mock import patch

import gymnasium as gym
import pymunk

from khepera_forage.envs.forager import Forager
from khepera_forage.policies import Teacher
from khepera_forage.sim.camera import SimulatedCamera
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.simulation import SimulatedKhepera
from timing.measures import Job, Measure, Values
from timing.stopwatch import Method, Sheet, Stopwatch

_WRAPPERS, _OUTCOME, _DECISION = "Gymnasium's wrappers", "observation, reward, info", "the teacher's decision"
_BODIES = "wheels, gripper and rounds, in Python"
_METHODS: tuple[tuple[str, type, str], ...] = (
    ("pymunk's own step", pymunk.Space, "step"),
    (_BODIES, PymunkWorld, "advance"),
    (_BODIES, Forager, "drive"),
    ("infra-reds and optical barrier", SimulatedKhepera, "sense"),
    ("camera and tracking", SimulatedCamera, "look"),
    ("perception, state, food tracking", Forager, "perceive"),
    ("behaviour: raw data to motors", Forager, "motors_for"),
)
"""A part's name, and a method whose time it is, without the parts that the method calls."""

SECTION = "A step of Corridor-v1, part by part"
NOTE = (
    "Exclusive times: a clock is switched at every call between parts, and the measured cost of the switching is "
    "subtracted. What remains of this cost, and the effect on the processor's caches, is the difference of the last "
    "two lines. Resets are left out."
)
UNIT = "µs a step"
_PARTS = (*dict.fromkeys(part for part, _, _ in _METHODS), _OUTCOME, _WRAPPERS, _DECISION)
PARTS = {part: Measure(SECTION, part, UNIT) for part in _PARTS}
SUM = Measure(SECTION, "sum of the parts", UNIT)
WHOLE = Measure(SECTION, "the same steps without stopwatch", UNIT)


def job(steps: int, seed: int) -> Job:
    """Measure `steps` steps part by part, and the same steps as a whole."""

    def run() -> Values:
        env = gym.make("khepera_forage/Corridor-v1")
        teacher = Teacher.of(env)
        whole, _ = _drive(env, env.step, teacher.act, steps, seed)
        watch = Stopwatch()
        with ExitStack() as replaced:
            for part, owner, name in (*_METHODS, (_OUTCOME, type(env.unwrapped), "step")):
                timed = watch.timed(getattr(owner, name), part)
                replaced.enter_context(patch.object(owner, name, timed))
            step, act = watch.timed(env.step, _WRAPPERS), watch.timed(teacher.act, _DECISION)
            _, watch.sheet = _drive(env, step, act, steps, seed, watch)
        env.close()
        values = {measure: 1e6 * watch.exclusive(part) / steps for part, measure in PARTS.items()}
        return {**values, SUM: sum(values.values()), WHOLE: 1e6 * whole / steps}

    return run


def _drive(
    env: gym.Env[Any, Any], step: Method, act: Method, steps: int, seed: int, watch: Stopwatch | None = None
) -> tuple[float, Sheet]:
    """Seconds of that many steps without their resets, and the notes of a stopwatch."""
    noted = Sheet()
    seconds = 0.0
    observation, _ = env.reset(seed=seed)
    done = 0
    while done < steps:
        if watch is not None:
            watch.sheet = noted
        over = False
        start = perf_counter()
        while not over and done < steps:
            observation, _, terminated, truncated, _ = step(act(observation))
            over = terminated or truncated
            done += 1
        seconds += perf_counter() - start
        if watch is not None:
            watch.sheet = Sheet()  # resets do not count
        observation, _ = env.reset()
    return seconds, noted
