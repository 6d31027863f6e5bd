"""Every mistake raises one clear error that quotes the value and what is allowed."""

import math
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded

import khepera_forage  # noqa: F401  (registers the environments)
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.envs.wheels_env import WheelsEnv


@pytest.mark.parametrize(
    ("kwargs", "quoted", "allowed"),
    [
        ({"food_types": "CHEESE"}, "'CHEESE'", "PICKABLE, PUSHABLE, POISONOUS"),
        ({"food_types": {"PICKABLE": -1}}, "-1.0", "a number >= 0"),
        ({"food_types": {"PICKABLE": math.nan}}, "nan", "a number >= 0"),
        ({"food_types": {"PICKABLE": 0}}, "{'PICKABLE': 0}", "at least one above 0"),
        ({"foods": 0}, "0", "a whole number from 1 to 16"),
        ({"foods": 17}, "17", "a whole number from 1 to 16"),
        ({"foods": 1.5}, "1.5", "a whole number"),
        ({"limit": -3}, "-3", "at least 1"),
        ({"arena": "circle"}, "'circle'", "'corridor', 'rectangle'"),
        ({"render_mode": "ansi"}, "'ansi'", "rgb_array"),
    ],
)
def test_wrong_arguments_are_refused(kwargs: dict[str, Any], quoted: str, allowed: str) -> None:
    with pytest.raises(ValueError, match="allowed") as error:
        BehavioursEnv(**kwargs)
    assert quoted in str(error.value)
    assert allowed in str(error.value)


@pytest.mark.parametrize(
    ("kwargs", "quoted"),
    [
        ({"num_learners": 0}, "0"),
        ({"max_cycles": 0}, "0"),
        ({"patience": -1}, "-1"),
        ({"num_learners": 99}, "camera"),
    ],
)
def test_wrong_training_arguments_are_refused(kwargs: dict[str, Any], quoted: str) -> None:
    with pytest.raises(ValueError, match="allowed") as error:
        TrainingEnv(**kwargs)
    assert quoted in str(error.value)


@pytest.mark.parametrize("action", [10, -1, 2.5, math.nan, None, "3", True, np.array([1, 2])])
def test_wrong_behaviour_actions_are_refused(action: Any) -> None:
    env = gym.make("khepera_forage/Corridor-v1", disable_env_checker=True)
    env.reset(seed=0)
    with pytest.raises(ValueError, match="allowed: a whole number from 0 to 9") as error:
        env.step(action)
    assert repr(action) in str(error.value)
    _, _, _, _, info = env.step(3)
    assert info["steps"] == 1, "a refused action is no step"


@pytest.mark.parametrize(
    "action", [[0, 0, 0], [2, 0, 0, 0], [math.nan, 0, 0, 0], [math.inf] * 4, "drive", None]
)
def test_wrong_wheel_actions_are_refused(action: Any) -> None:
    env = WheelsEnv()
    env.reset(seed=0)
    with pytest.raises(ValueError, match=r"allowed: four numbers in -1\.\.1"):
        env.step(action)


@pytest.mark.parametrize("action", [11, -1, None, 0.5])
def test_wrong_training_actions_are_refused(action: Any) -> None:
    env = TrainingEnv()
    env.reset(seed=0)
    with pytest.raises(ValueError, match=r"action of teacher_0 is .*allowed: a whole number from 0 to 10"):
        env.step(action)


def test_step_before_reset_and_after_the_end_is_refused() -> None:
    env = BehavioursEnv(limit=2)
    with pytest.raises(ResetNeeded, match="not reset"):
        env.step(0)
    with pytest.raises(ResetNeeded, match="not reset"):
        TrainingEnv().step(0)
    env.reset(seed=0)
    env.step(0)
    _, _, _, truncated, _ = env.step(0)
    assert truncated
    with pytest.raises(ResetNeeded, match="ended after 2 steps"):
        env.step(0)


def test_training_step_after_the_end_is_refused() -> None:
    env = TrainingEnv(max_cycles=1)
    env.reset(seed=0)
    env.step(10)
    env.step(10)
    for _ in range(2):
        env.step(None)
    with pytest.raises(ResetNeeded, match="ended after 1 rounds"):
        env.step(0)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"begin": 1}, "'begin' is unknown; allowed: 'start', 'foods'"),
        ({"start": (0, 0, 0)}, "start at .* allowed: on the floor"),
        ({"start": (1, 2)}, "allowed: .x mm, y mm, heading degrees."),
        ({"foods": [(5, 5)]}, "food at .5, 5. mm"),
        ({"foods": [(math.nan, 5)]}, "nan.*finite"),
        ({"foods": []}, "0 foods given; allowed: 1"),
        ({"start": (300, 115, 0), "foods": [(320, 115)]}, "overlaps"),
    ],
)
def test_wrong_reset_options_are_refused(options: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        BehavioursEnv().reset(seed=0, options=options)


def test_arena_without_room_is_refused() -> None:
    with pytest.raises(ValueError, match=r"no room for a robot and 16 food objects"):
        BehavioursEnv(foods=16).reset(seed=0)
