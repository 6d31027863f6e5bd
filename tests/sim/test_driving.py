"""Wheels: the equations of a differential drive, encoders, and slip.

A command reaches the body one physics step later, which is 20 ms far from obstacles: from rest that costs
20 ms of the way, and on an arc it turns the path by what the robot turns in that time.
"""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from khepera_forage.robots.khepera import CONTROL_PERIOD, MAX_SPEED, PULSE, RADIUS, SPEED_UNIT, WHEEL_BASE
from khepera_forage.robots.model import MODELS
from khepera_forage.sim.arena import Pose
from tests.sim.worlds import NONE, Kind, apart, make_world, of_both_kinds, run
from tests.version_0_1 import TIMING

PROPERTY = settings(max_examples=60)
CENTRE = Pose(1000, 1000, 0)
OUT_OF_THE_WAY = (100.0, 100.0)
speeds = st.integers(-MAX_SPEED, MAX_SPEED)


def chord_of_arc(turn: float) -> float:
    """The chord as a share of the arc."""
    return float(np.sinc(turn / 2 / math.pi))


def arc(pose: Pose, left: float, right: float, rounds: int) -> Pose:
    """The pose that a differential drive reaches in that time."""
    forward = (left + right) / 2 * SPEED_UNIT * CONTROL_PERIOD * rounds
    turn = (right - left) * SPEED_UNIT / WHEEL_BASE * CONTROL_PERIOD * rounds
    x, y, heading = pose
    chord, middle = forward * chord_of_arc(turn), heading + turn / 2
    return Pose(x + chord * math.cos(middle), y + chord * math.sin(middle), heading + turn)


@given(speeds, speeds, st.floats(-math.pi, math.pi))
@PROPERTY
def test_motion_follows_the_equations_of_a_differential_drive(left: int, right: int, heading: float) -> None:
    world = make_world(CENTRE._replace(heading=heading), OUT_OF_THE_WAY)
    run(world, 2, left, right)
    start = world.poses()[0]
    expected = arc(start, left, right, 25)
    run(world, 25, left, right)
    reached = world.poses()[0]
    # The chord of a round is as long as its arc should be, by up to 1.6 % too long.
    turn = (right - left) * SPEED_UNIT / WHEEL_BASE * CONTROL_PERIOD
    assert apart(reached, expected) < 1e-6 + turn * turn / 23 * apart(start, expected)
    assert reached.heading == pytest.approx(expected.heading, abs=1e-6)


@given(st.lists(st.tuples(speeds, speeds, st.integers(1, 5)), min_size=1, max_size=6))
@PROPERTY
def test_encoders_count_the_commanded_travel_without_slip(legs: list[tuple[int, int, int]]) -> None:
    world = make_world(CENTRE, OUT_OF_THE_WAY, noise=replace(NONE, wheel_slip=0.2, wheel_bias=0.1))
    for left, right, rounds in legs:
        run(world, rounds, left, right)
    senses = world.robots[0].sense()
    travelled = [sum(leg[i] * leg[2] for leg in legs) * SPEED_UNIT * CONTROL_PERIOD for i in (0, 1)]
    assert senses.left_pulses == pytest.approx(travelled[0] / PULSE, abs=1)
    assert senses.right_pulses == pytest.approx(travelled[1] / PULSE, abs=1)


def shares(worlds: int, rounds: int, **noise: float) -> Any:
    """Travel of both wheels in each round of each world, as shares of the commanded travel."""
    found, commanded = np.zeros((worlds, rounds, 2)), 10 * SPEED_UNIT * CONTROL_PERIOD
    for seed in range(worlds):
        world = make_world(CENTRE, OUT_OF_THE_WAY, noise=replace(NONE, **noise), seed=seed)
        run(world, 2, 10, 10)
        for number in range(rounds):
            before = world.poses()[0]
            run(world, 1, 10, 10)
            after = world.poses()[0]
            turn = after.heading - before.heading
            forward, half = apart(after, before) / chord_of_arc(turn), turn * WHEEL_BASE / 2
            found[seed, number] = (forward - half) / commanded, (forward + half) / commanded
    return found


def check_wheels(drawn: Any, deviation: float) -> None:
    """Both wheels have this deviation from 1, without mean or correlation; bounds are 3.5 standard errors."""
    error = 3.5 / math.sqrt(len(drawn))
    assert drawn.mean(axis=0) == pytest.approx([1, 1], abs=error * deviation)
    assert drawn.std(axis=0) == pytest.approx([deviation] * 2, rel=error / math.sqrt(2))
    assert abs(np.corrcoef(drawn.T)[0, 1]) < error


def test_wheel_slip_is_drawn_each_round_for_each_wheel() -> None:
    found = shares(8, 75, wheel_slip=0.05)
    check_wheels(found.reshape(-1, 2), 0.05)
    assert abs(np.corrcoef(found[:, 1:].ravel(), found[:, :-1].ravel())[0, 1]) < 0.14


def test_wheel_bias_is_constant_until_the_next_reset() -> None:
    found = shares(200, 3, wheel_bias=0.02)
    assert np.ptp(found, axis=1).max() < 1e-3
    check_wheels(found.mean(axis=1), 0.02)


@of_both_kinds
@pytest.mark.parametrize("name", ["khepera", "toio"])
@pytest.mark.parametrize("seconds", [0.5, 2.0])
def test_long_rounds_lead_no_robot_through_a_wall(kind: Kind, name: str, seconds: float) -> None:
    timing, start = TIMING._replace(round_duration=seconds), Pose(RADIUS + 20, 1000, 0)
    world = make_world(start, OUT_OF_THE_WAY, kind=kind, timing=timing, model=MODELS[name])
    run(world, 1, -MAX_SPEED, -MAX_SPEED)
    assert world.poses()[0].x == pytest.approx(RADIUS, abs=1)
