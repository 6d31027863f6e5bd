"""Decisions have the same effect on both backends, in single and in vector environments."""

from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from khepera_forage import Decisions
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, JAW_CLOSED, JAW_OPEN, SPEED_UNIT
from khepera_forage.task.states import State
from tests.version_0_1 import V0_1

pytest.importorskip("numba")

FREE = {"start": (200, 150, 0), "foods": [(100, 500), (300, 500)]}
"""Places in the rectangle where a robot can drive ahead for some rounds."""
FORWARD, LOWER, CLOSE = (0.5, 0.5, 1.0, 0.0), (0.0, 0.0, -1.0, 0.0), (0.0, 0.0, 1.0, 1.0)


def _corridor(backend: str, decisions: Decisions) -> Any:
    env = gym.make("khepera_forage/Corridor-v1", backend=backend, noise=Noise.none(), decisions=decisions)
    return env.unwrapped


def _states_ahead_of_food(env: Any) -> list[int]:
    """The states in front of food that lies 16 to 45 pixels straight ahead, beyond the robot's marker."""
    states = []
    for pixels in range(16, 46):
        options = {"start": (100, 115, 0), "foods": [(100 + 5 * pixels, 115)]}
        states.append(env.reset(seed=1, options=options)[1]["state"])
    return states


@pytest.mark.parametrize(
    ("decisions", "next_to", "close_to"),
    [
        (V0_1, 20, 30),
        (replace(V0_1, next_to_food=17), 17, 30),
        (replace(V0_1, close_to_food=40), 20, 40),
        (replace(V0_1, next_to_food=17, close_to_food=40, equal_distance="farther state"), 16, 39),
    ],
)
@pytest.mark.parametrize("backend", ["pymunk", "compiled"])
def test_thresholds_of_the_decisions_bound_the_states(
    backend: str, decisions: Decisions, next_to: int, close_to: int
) -> None:
    states = _states_ahead_of_food(_corridor(backend, decisions))
    assert states.count(State.NEXT_TO_FOOD) == next_to - 15
    assert states.count(State.CLOSE_TO_FOOD) == close_to - next_to


@pytest.mark.parametrize(
    "decisions",
    [
        replace(V0_1, next_to_food=17),
        replace(V0_1, search_speed=7, aimed=10),
        replace(V0_1, equal_distance="farther state", close_to_food=36),
        replace(V0_1, quick_turn_speed=5, astray=30),
    ],
    ids=lambda decisions: "-".join(decisions.differing(V0_1)),
)
def test_teacher_follows_the_decisions_alike_on_both_backends(decisions: Decisions) -> None:
    compiled = _check_alike(decisions)
    assert np.abs(_teacher_run("compiled", V0_1) - compiled).max() > 0.5


def test_teacher_follows_the_default_decisions_alike_on_both_backends() -> None:
    _check_alike(Decisions())


def _check_alike(decisions: Decisions) -> Any:
    """Twenty steps without noise, before contacts differ: the same states, poses within a millimetre."""
    pymunk, compiled = (_teacher_run(backend, decisions) for backend in ("pymunk", "compiled"))
    assert (pymunk[:, :2] == compiled[:, :2]).all()
    assert np.abs(pymunk[:, 2:] - compiled[:, 2:]).max() < 0.2
    return compiled


def _teacher_run(backend: str, decisions: Decisions) -> Any:
    """State, correct decisions and place in every step."""
    env, run = _corridor(backend, decisions), []
    for seed in range(1, 7):
        _, info = env.reset(seed=seed)
        for _ in range(20):
            _, _, _, _, info = env.step(info["correct_behaviour"])
            run.append((info["state"], info["correct"], *info["pose"][:2]))
    return np.array(run)


def _senses_after(backend: str, decisions: Decisions, action: Any, rounds: int) -> Any:
    """x in mm, arm and jaw after some rounds under one action."""
    env: Any = gym.make(
        "khepera_forage/RectangleWheels-v1", backend=backend, noise=Noise.none(), decisions=decisions
    ).unwrapped
    env.reset(seed=1, options=FREE)
    for _ in range(rounds):
        env.step(np.array(action))
    forager = env.forager
    return forager.raw.x * 5.0, forager.senses.arm, forager.senses.jaw


@pytest.mark.parametrize("backend", ["pymunk", "compiled"])
@pytest.mark.parametrize("duration", [0.05, 0.1, 0.25])
def test_round_duration_is_how_long_an_action_lasts(backend: str, duration: float) -> None:
    x, _, _ = _senses_after(backend, Decisions(round_duration=duration), FORWARD, 8)
    assert x - 200 == pytest.approx(10 * SPEED_UNIT * 8 * duration, abs=2.5)


@pytest.mark.parametrize("backend", ["pymunk", "compiled"])
@pytest.mark.parametrize("duration", [0.1, 0.2])
@pytest.mark.parametrize("travel", [0.4, 2.0])
def test_travel_times_are_how_long_arm_and_jaw_take(backend: str, duration: float, travel: float) -> None:
    lowering = Decisions(round_duration=duration, arm_travel_time=travel)
    closing = Decisions(round_duration=duration, jaw_travel_time=travel)
    whole = round(travel / duration)
    for rounds in (1, whole - 1, whole, whole + 1):
        share = min(1.0, rounds * duration / travel)
        _, arm, _ = _senses_after(backend, lowering, LOWER, rounds)
        assert arm == pytest.approx(ARM_RAISED + share * (ARM_DOWN - ARM_RAISED), abs=0.5)
        _, _, jaw = _senses_after(backend, closing, CLOSE, rounds)
        assert jaw == pytest.approx(JAW_OPEN + share * (JAW_CLOSED - JAW_OPEN), abs=0.5)


def test_vector_environments_follow_the_decisions() -> None:
    decisions = Decisions(round_duration=0.2, arm_travel_time=0.5, jaw_travel_time=2.0)
    env: Any = gym.make_vec(
        "khepera_forage/RectangleWheels-v1", num_envs=3, noise=Noise.none(), decisions=decisions
    )
    single: Any = gym.make(
        "khepera_forage/RectangleWheels-v1", backend="compiled", noise=Noise.none(), decisions=decisions
    )
    env.reset(seed=1, options=FREE)
    single.reset(seed=1, options=FREE)
    for _ in range(4):
        observation, *_ = env.step(np.tile((0.5, 0.4, 0.5, 1.0), (3, 1)))
        expected, *_ = single.step(np.array((0.5, 0.4, 0.5, 1.0)))
    for name, values in observation.items():
        assert (values == expected[name]).all(), name
    assert observation["pose"][0, 0] * 5 - 200 > 40
