"""Teacher and learner beside each other (4.5.2): the learner's arc, separation, silence, and when an attempt ends."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.envs.layouts import arena_map_of
from khepera_forage.robots.khepera import MAX_SPEED, Motors
from khepera_forage.sim.arena import copies
from khepera_forage.task.decisions import DEFAULT_VALUES, Decisions, DecisionValues
from khepera_forage.task.pairing import (
    Pairing,
    follow,
    is_complete,
    recover,
    rounds_since_done,
    update_pairing,
)
from tests.version_0_1 import CORRIDOR, V0_1

TEACHER_ARENA, ARENA = (arena_map_of(arena) for arena in copies(CORRIDOR, 2))
OFFSET = ARENA.home_y - TEACHER_ARENA.home_y
AHEAD = Motors(8.0, 8.0, 215, 200)
DEFAULT = Decisions()
WHEELS = st.floats(-20.0, 20.0)
MOTORS = st.builds(Motors, left=WHEELS, right=WHEELS, arm=st.just(215), jaw=st.just(200))
PLACE = st.floats(0.0, 130.0)
DEGREES = st.integers(0, 359)


@given(motors=MOTORS, x=PLACE, y=PLACE, heading=DEGREES, tx=PLACE, ty=PLACE, teachers=DEGREES)
def test_follow_keeps_the_mean_speed_within_a_robots_limits(
    motors: Motors, x: float, y: float, heading: int, tx: float, ty: float, teachers: int
) -> None:
    """A robot would clamp a faster wheel, which alters the speed."""
    led = follow(motors, x, y, heading, tx, ty, teachers, DEFAULT_VALUES)
    assert led.left + led.right == pytest.approx(motors.left + motors.right)
    assert led[2:] == motors[2:]
    assert max(abs(led.left), abs(led.right)) <= MAX_SPEED + 1e-9
    if motors.left + motors.right <= 0 or math.dist((x, y), (tx, ty)) <= DEFAULT.same_place:
        assert led == motors


@given(x=PLACE, y=PLACE, heading=DEGREES, tx=PLACE, ty=PLACE)
def test_recover_drives_an_arc_at_recovery_speed(
    x: float, y: float, heading: int, tx: float, ty: float
) -> None:
    for speed in (1.0, 6.0, 12.0):
        values = Decisions(recovery_speed=speed).values()
        motors = recover(Motors(0, 0, 255, 0), x, y, heading, tx, ty, values)
        assert (motors.left + motors.right) / 2 == pytest.approx(speed)
        assert min(motors.left, motors.right) >= 0
        assert motors[2:] == (255, 0)


def changed_to(**changes: float) -> DecisionValues:
    return Decisions.from_changes(changes, V0_1).values()


@pytest.mark.parametrize("value", [1.0, 2.0, 8.0])
def test_decisions_say_from_which_place_and_heading_the_learner_follows(value: float) -> None:
    for beyond, away, degrees in ((False, -0.01, 40.0), (True, 0.01, 40.0)):
        near = follow(AHEAD, 50, 20, 0, 50, 20 + value + away, degrees, changed_to(same_place=value))
        assert (near != AHEAD) is beyond
        turned = follow(AHEAD, 50, 20, 0, 50, 28, value + away, changed_to(same_heading=value))
        assert (turned != AHEAD) is beyond


@pytest.mark.parametrize("gain", [0.01, 0.05, 0.08])
def test_following_gain_is_the_turn_for_each_degree(gain: float) -> None:
    led = follow(AHEAD, 50, 20, 0, 50, 28, 40, changed_to(following_gain=gain))
    assert led[:2] == pytest.approx((8.0 - 90 * gain, 8.0 + 90 * gain))
    recovering = recover(AHEAD, 50, 20, 0, 58, 28, changed_to(following_gain=gain))
    assert recovering[:2] == pytest.approx((6.0 - 45 * gain, 6.0 + 45 * gain))


@pytest.mark.parametrize("separation", [5.0, 14.0, 40.0])
def test_pairing_counts_separations_and_their_rounds(separation: float) -> None:
    """The teacher's place is moved into the learner's arena, and compared there."""
    pairing, history = Pairing(), []
    for beyond in (-4.0, 0.0, 0.1, 6.0, -1.0, 16.0):
        x, y = 50.0 + separation + beyond, 20.0 + OFFSET
        values = Decisions(separation=separation).values()
        update_pairing(pairing, x, y, ARENA, 50.0, 20.0, 30.0, TEACHER_ARENA, values)
        history.append((pairing.separated, pairing.separated_rounds, pairing.separations))
    assert history == [(False, 0, 0)] * 2 + [(True, 1, 1), (True, 2, 1), (False, 0, 1), (True, 1, 2)]


def test_training_is_complete_some_rounds_after_the_robots_have_done_their_part() -> None:
    for rounds in (0, 3):
        decisions = Decisions(rounds_after_training=rounds).values()
        since, complete = 0, []
        for done in (False, True, False, False, True, True):
            since = rounds_since_done(since, done)
            complete.append(is_complete(since, decisions))
        assert complete == [number > rounds for number in range(6)]
