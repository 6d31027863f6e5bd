"""Every mistake raises one clear error that quotes the value and what is allowed."""

import math
from functools import partial
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded

import khepera_forage  # noqa: F401  (registers the environments)
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.compiled.vector_env import BehavioursVectorEnv
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.envs.wheels_env import WheelsEnv

pytest.importorskip("numba")
BACKENDS = ("pymunk", "compiled")
on_both_backends = pytest.mark.parametrize("backend", BACKENDS)


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
    for backend in BACKENDS:
        with pytest.raises(ValueError, match="allowed") as error:
            BehavioursEnv(backend=backend, **kwargs)
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
@on_both_backends
def test_wrong_behaviour_actions_are_refused(backend: str, action: Any) -> None:
    env = gym.make("khepera_forage/Corridor-v1", disable_env_checker=True, backend=backend)
    env.reset(seed=0)
    with pytest.raises(ValueError, match="allowed: a whole number from 0 to 9") as error:
        env.step(action)
    assert repr(action) in str(error.value)
    _, _, _, _, info = env.step(3)
    assert info["steps"] == 1, "a refused action is no step"


@pytest.mark.parametrize(
    "action", [[0, 0, 0], [2, 0, 0, 0], [math.nan, 0, 0, 0], [math.inf] * 4, "drive", None]
)
@on_both_backends
def test_wrong_wheel_actions_are_refused(backend: str, action: Any) -> None:
    env = WheelsEnv(backend=backend)
    env.reset(seed=0)
    with pytest.raises(ValueError, match=r"allowed: four numbers in -1\.\.1"):
        env.step(action)


@pytest.mark.parametrize("action", [11, -1, None, 0.5])
def test_wrong_training_actions_are_refused(action: Any) -> None:
    env = TrainingEnv()
    env.reset(seed=0)
    with pytest.raises(ValueError, match=r"action of teacher_0 is .*allowed: a whole number from 0 to 10"):
        env.step(action)


@on_both_backends
def test_step_before_reset_and_after_the_end_is_refused(backend: str) -> None:
    env = BehavioursEnv(limit=2, backend=backend)
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


@pytest.mark.parametrize("mode", ["pymunk", "compiled", "vector"])
@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"foods": [(300, 300), (310, 300)]}, r"food at \(310, 300\) mm overlaps food at \(300, 300\) mm"),
        (
            {"start": (300, 300, 0), "foods": [(325, 300), (500, 100)]},
            r"food at \(325, 300\) mm overlaps robot at \(300, 300\) mm; allowed: at least 45 mm apart",
        ),
        ({"start": (10, 300, 0)}, r"start at \(10, 300\) mm is 10 mm from a wall"),
        ({"start": (0, 0, 0)}, "start at .* allowed: on the floor"),
        ({"start": (1, 2)}, "allowed: .x mm, y mm, heading degrees."),
        ({"foods": [(5, 5), (300, 300)]}, "food at .5, 5. mm"),
        ({"foods": [(math.nan, 5), (300, 300)]}, "nan.*finite"),
        ({"foods": [(300, 300)]}, "1 foods given; allowed: 2"),
        ({"food": [(300, 300)]}, "reset option 'food' is unknown; allowed: 'start', 'foods'"),
    ],
)
def test_wrong_reset_options_are_refused(mode: str, options: Any, message: str) -> None:
    name = "khepera_forage/Rectangle-v1"
    env: Any = gym.make_vec(name, num_envs=2) if mode == "vector" else gym.make(name, backend=mode)
    env.reset(seed=1)
    with pytest.raises(ValueError, match=message):
        env.reset(options=options)
    env.step(env.action_space.sample())


@pytest.mark.parametrize("make", [BehavioursEnv, partial(BehavioursVectorEnv, 2)])
def test_arena_without_room_is_refused(make: Any) -> None:
    with pytest.raises(ValueError, match=r"no room for a robot and 16 food objects"):
        make(foods=16).reset(seed=0)
