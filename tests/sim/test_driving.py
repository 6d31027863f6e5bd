"""Wheels: the equations of a differential drive, encoders, and slip.

A command reaches the body one physics step later, which is 20 ms far from obstacles: from rest that costs
20 ms of the way, and on an arc it turns the path by what the robot turns in that time.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from khepera_forage.robots.khepera import CONTROL_PERIOD, MAX_SPEED, PULSE, SPEED_UNIT, WHEEL_BASE
from khepera_forage.sim.arena import Pose
from khepera_forage.sim.pymunk.world import PymunkWorld
from tests.sim.worlds import NONE, apart, make_world, run

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


def shares(world: PymunkWorld, rounds: int, speed: int = 10) -> list[tuple[float, float]]:
    """Travel of the left and the right wheel in each round, as shares of the commanded travel."""
    run(world, 2, speed, speed)
    found = []
    commanded = speed * SPEED_UNIT * CONTROL_PERIOD
    for _ in range(rounds):
        before = world.poses()[0]
        run(world, 1, speed, speed)
        after = world.poses()[0]
        turn = after.heading - before.heading
        forward = apart(after, before) / chord_of_arc(turn)
        half = turn * WHEEL_BASE / 2
        found.append(((forward - half) / commanded, (forward + half) / commanded))
    return found


def test_wheel_slip_is_drawn_each_round_for_each_wheel() -> None:
    noise = replace(NONE, wheel_slip=0.05)
    found = [
        share for seed in range(8) for share in shares(make_world(CENTRE, OUT_OF_THE_WAY, noise=noise, seed=seed), 75)
    ]
    left, right = np.array(found).T
    for wheel in (left, right):
        assert wheel.mean() == pytest.approx(1, abs=0.007)  # 3.4 standard errors
        assert wheel.std() == pytest.approx(0.05, rel=0.1)
        assert abs(np.corrcoef(wheel[1:], wheel[:-1])[0, 1]) < 0.14
    assert abs(np.corrcoef(left, right)[0, 1]) < 0.14


def test_wheel_bias_is_constant_until_the_next_reset() -> None:
    noise = replace(NONE, wheel_bias=0.02)
    found = []
    for seed in range(200):
        rounds = np.array(shares(make_world(CENTRE, OUT_OF_THE_WAY, noise=noise, seed=seed), 3))
        assert np.ptp(rounds, axis=0) == pytest.approx([0, 0], abs=1e-3)
        found.append(rounds.mean(axis=0))
    left, right = np.array(found).T
    for wheel in (left, right):
        assert wheel.mean() == pytest.approx(1, abs=0.005)  # 3.5 standard errors
        assert wheel.std() == pytest.approx(0.02, rel=0.17)
    assert abs(np.corrcoef(left, right)[0, 1]) < 0.25
