"""Behaviours learned from the motors behind them (action level, 4.8)."""

import math
from collections.abc import Callable
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from further_experiments.learned_behaviours import LearnedBehaviours, relations
from hypothesis import given
from hypothesis import strategies as st

import khepera_forage  # noqa: F401 - registers the environments
from khepera_forage.robots.khepera import ARM_RAISED, JAW_CLOSED
from khepera_forage.task.behaviours import command
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.perception import RawData
from tests.benchmarks.test_further_work import RAW as SEEN

RAW = SEEN._replace(proximity=(0, 10, 20, 30, 40, 50), food_x=60.0)


def moved(raw: RawData, x: float, y: float, degrees: int) -> RawData:
    """The same scene elsewhere: everything turned about the origin, then shifted."""
    cosine, sine = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))

    def there(px: float, py: float) -> tuple[float, float]:
        return x + px * cosine - py * sine, y + px * sine + py * cosine

    (x1, y1), (x2, y2), (x3, y3) = (there(raw.x, raw.y), there(raw.food_x, raw.food_y), there(raw.home_x, raw.home_y))
    orientation = (raw.orientation + degrees) % 360
    return raw._replace(x=x1, y=y1, food_x=x2, food_y=y2, home_x=x3, home_y=y3, orientation=orientation)


@given(st.floats(-200, 200), st.floats(-200, 200), st.integers(-180, 180))
def test_relations_do_not_depend_on_the_place(x: float, y: float, degrees: int) -> None:
    assert relations(moved(RAW, x, y, degrees)) == pytest.approx(relations(RAW), abs=1e-6)


def forages(env: Any, seeds: range, action: Callable[[int, RawData], Any]) -> int:
    """Food delivered in episodes under an action that may depend on the correct behaviour and the raw data."""
    delivered = 0
    for seed in seeds:
        (_, info), over = env.reset(seed=seed), False
        while not over:
            _, _, terminated, truncated, info = env.step(action(info["correct_behaviour"], env.forager.raw))
            over = terminated or truncated
        delivered += info["delivered"]
    return delivered


def test_behaviours_learned_from_the_teacher_s_motors_forage_at_new_places() -> None:
    raws: list[RawData] = []
    behaviours: list[int] = []

    def shown(behaviour: int, raw: RawData) -> int:
        raws.append(raw)
        behaviours.append(behaviour)
        return behaviour

    def wheels(behaviour: int, raw: RawData) -> Any:
        left, right, arm, jaw = learned.command(behaviour, raw)
        return np.array((left / 20, right / 20, 2.0 * (arm == ARM_RAISED) - 1.0, 2.0 * (jaw == JAW_CLOSED) - 1.0))

    forages(gym.make("khepera_forage/Corridor-v1").unwrapped, range(12), shown)
    motors = [command(*step, Decisions().values()) for step in zip(behaviours, raws, strict=True)]
    learned = LearnedBehaviours().fit(raws, behaviours, motors)
    delivered = forages(gym.make("khepera_forage/CorridorWheels-v1").unwrapped, range(100, 106), wheels)
    assert delivered >= 1, "a robot that stands still, or drives at random, delivers nothing"
