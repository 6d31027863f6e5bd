"""Behaviours learned from the motors behind them (action level, 4.8)."""

import math

import gymnasium as gym
import numpy as np
import pytest
from further_experiments.learned_behaviours import LearnedBehaviours, relations
from hypothesis import given
from hypothesis import strategies as st

import khepera_forage  # noqa: F401 - registers the environments
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.robots.khepera import ARM_RAISED, JAW_CLOSED, Motors
from khepera_forage.task.behaviours import command
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.perception import RawData
from tests.benchmarks.test_further_work import RAW as SEEN

RAW = SEEN._replace(proximity=(0, 10, 20, 30, 40, 50), food_x=60.0)
Steps = tuple[list[RawData], list[int], list[Motors]]


def moved(raw: RawData, x: float, y: float, degrees: int) -> RawData:
    """The same scene elsewhere: everything turned about the origin, then shifted."""
    cosine, sine = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))

    def there(px: float, py: float) -> tuple[float, float]:
        return x + px * cosine - py * sine, y + px * sine + py * cosine

    (x1, y1), (x2, y2), (x3, y3) = (
        there(raw.x, raw.y),
        there(raw.food_x, raw.food_y),
        there(raw.home_x, raw.home_y),
    )
    orientation = (raw.orientation + degrees) % 360
    return raw._replace(x=x1, y=y1, food_x=x2, food_y=y2, home_x=x3, home_y=y3, orientation=orientation)


def as_trees_see(raw: RawData) -> tuple[float, ...]:
    """Relations in the single precision of scikit-learn's trees."""
    return tuple(np.array(relations(raw), np.float32).tolist())


@pytest.fixture(scope="module")
def steps() -> Steps:
    """The teacher's forages at random places: raw data, behaviours and motor commands."""
    env = gym.make("khepera_forage/Corridor-v1").unwrapped
    assert isinstance(env, BehavioursEnv)
    raws, behaviours, motors = [], [], []
    for seed in range(12):
        _, info = env.reset(seed=seed)
        over = False
        while not over:
            raws.append(env.forager.raw)
            behaviours.append(info["correct_behaviour"])
            motors.append(command(behaviours[-1], raws[-1], Decisions().values()))
            _, _, terminated, truncated, info = env.step(behaviours[-1])
            over = terminated or truncated
    env.close()
    return raws, behaviours, motors


@pytest.fixture(scope="module")
def learned(steps: Steps) -> LearnedBehaviours:
    return LearnedBehaviours().fit(*steps)


@given(st.floats(-200, 200), st.floats(-200, 200), st.integers(-180, 180))
def test_relations_do_not_depend_on_the_place(x: float, y: float, degrees: int) -> None:
    assert relations(moved(RAW, x, y, degrees)) == pytest.approx(relations(RAW), abs=1e-6)


def test_examples_are_reproduced(steps: Steps, learned: LearnedBehaviours) -> None:
    """Trees without bootstrap reproduce their examples, except equal rows with different commands."""
    commands: dict[tuple[int, tuple[float, ...]], set[Motors]] = {}
    for raw, behaviour, motors in zip(*steps, strict=True):
        commands.setdefault((behaviour, as_trees_see(raw)), set()).add(motors)
    checked = 0
    for raw, behaviour, motors in zip(*steps, strict=True):
        if len(commands[behaviour, as_trees_see(raw)]) == 1:
            predicted = learned.command(behaviour, raw)
            assert predicted[:2] == pytest.approx(motors[:2], abs=1e-4)
            assert predicted[2:] == motors[2:]
            checked += 1
    assert checked > 500


def test_learned_behaviours_forage_at_new_places(learned: LearnedBehaviours) -> None:
    env = gym.make("khepera_forage/CorridorWheels-v1").unwrapped
    delivered = []
    for seed in range(100, 106):
        _, info = env.reset(seed=seed)
        over = False
        while not over:
            left, right, arm, jaw = learned.command(info["correct_behaviour"], env.forager.raw)  # type: ignore[attr-defined]
            raised, closed = (
                2.0 * (commands == then) - 1.0 for commands, then in ((arm, ARM_RAISED), (jaw, JAW_CLOSED))
            )
            action = np.array((left / 20, right / 20, raised, closed), np.float32)
            _, _, terminated, truncated, info = env.step(action)
            over = terminated or truncated
        delivered.append(info["delivered"])
    env.close()
    assert sum(delivered) >= 1, "a robot that stands still, or drives at random, delivers nothing"
