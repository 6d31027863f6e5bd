"""Teacher and learner beside each other (4.5.2): the learner's arc, separation, silence, and when an attempt ends."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.envs.layouts import arena_map_of
from khepera_forage.robots.khepera import MAX_SPEED, Motors
from khepera_forage.sim.arena import copies
from khepera_forage.task.decisions import DEFAULT_VALUES, Decisions
from khepera_forage.task.pairing import AttemptState, Pairing, end_round, follow, recover, update_pairing
from khepera_forage.task.perception import Marker
from tests.version_0_1 import CORRIDOR, changed_to

TEACHER_ARENA, ARENA = (arena_map_of(arena) for arena in copies(CORRIDOR, 2))
OFFSET = ARENA.home_y - TEACHER_ARENA.home_y
AHEAD = Motors(8.0, 8.0, 215, 200)
DEFAULT = Decisions()
WHEELS = st.floats(-20.0, 20.0)
MOTORS = st.builds(Motors, left=WHEELS, right=WHEELS, arm=st.just(215), jaw=st.just(200))
PLACE = st.floats(0.0, 130.0)
DEGREES = st.integers(0, 359)


def at(x: float, y: float, orientation: int = 0) -> Marker:
    """A robot at this place of the camera's picture."""
    return Marker(x, y, orientation, True)


def teacher_at(x: float, y: float, orientation: float = 0.0) -> Pairing:
    """A learner's pairing with a teacher at this place of the learner's arena."""
    return Pairing(teacher_x=x, teacher_y=y, teacher_orientation=orientation)


HERE = at(50, 20)


@given(motors=MOTORS, x=PLACE, y=PLACE, heading=DEGREES, tx=PLACE, ty=PLACE, teachers=DEGREES)
def test_follow_keeps_the_mean_speed_within_a_robots_limits(
    motors: Motors, x: float, y: float, heading: int, tx: float, ty: float, teachers: int
) -> None:
    """A robot would clamp a faster wheel, which alters the speed."""
    led = follow(teacher_at(tx, ty, teachers), motors, at(x, y, heading), DEFAULT_VALUES)
    assert led.left + led.right == pytest.approx(motors.left + motors.right)
    assert led[2:] == motors[2:]
    assert max(abs(led.left), abs(led.right)) <= MAX_SPEED + 1e-9
    if motors.left + motors.right <= 0 or math.dist((x, y), (tx, ty)) <= DEFAULT.same_place:
        assert led == motors


@given(x=PLACE, y=PLACE, heading=DEGREES, tx=PLACE, ty=PLACE)
def test_recover_drives_an_arc_at_recovery_speed(x: float, y: float, heading: int, tx: float, ty: float) -> None:
    for speed in (1.0, 6.0, 12.0):
        values = Decisions(recovery_speed=speed).values()
        motors = recover(teacher_at(tx, ty), Motors(0, 0, 255, 0), at(x, y, heading), values)
        assert (motors.left + motors.right) / 2 == pytest.approx(speed)
        assert min(motors.left, motors.right) >= 0
        assert motors[2:] == (255, 0)


@pytest.mark.parametrize("value", [1.0, 2.0, 8.0])
def test_decisions_say_from_which_place_and_heading_the_learner_follows(value: float) -> None:
    for beyond, away, degrees in ((False, -0.01, 40.0), (True, 0.01, 40.0)):
        teacher = teacher_at(50, 20 + value + away, degrees)
        near = follow(teacher, AHEAD, HERE, changed_to(same_place=value))
        assert (near != AHEAD) is beyond
        turned = follow(teacher_at(50, 28, value + away), AHEAD, HERE, changed_to(same_heading=value))
        assert (turned != AHEAD) is beyond


@pytest.mark.parametrize("gain", [0.01, 0.05, 0.08])
def test_following_gain_is_the_turn_for_each_degree(gain: float) -> None:
    led = follow(teacher_at(50, 28, 40), AHEAD, HERE, changed_to(following_gain=gain))
    assert led[:2] == pytest.approx((8.0 - 90 * gain, 8.0 + 90 * gain))
    recovering = recover(teacher_at(58, 28), AHEAD, HERE, changed_to(following_gain=gain))
    assert recovering[:2] == pytest.approx((6.0 - 45 * gain, 6.0 + 45 * gain))


@pytest.mark.parametrize("separation", [5.0, 14.0, 40.0])
def test_pairing_counts_separations_and_their_rounds(separation: float) -> None:
    """The teacher's place is moved into the learner's arena, and compared there."""
    pairing, history = Pairing(), []
    for beyond in (-4.0, 0.0, 0.1, 6.0, -1.0, 16.0):
        own = at(50.0 + separation + beyond, 20.0 + OFFSET)
        values = Decisions(separation=separation).values()
        update_pairing(pairing, own, ARENA, at(50.0, 20.0, 30), TEACHER_ARENA, values)
        history.append((pairing.separated, pairing.separated_rounds, pairing.separations))
    assert history == [(False, 0, 0)] * 2 + [(True, 1, 1), (True, 2, 1), (False, 0, 1), (True, 1, 2)]


def test_training_is_complete_some_rounds_after_the_robots_have_done_their_part() -> None:
    for rounds in (0, 3):
        decisions = Decisions(rounds_after_training=rounds).values()
        attempt, complete = AttemptState(), []
        for done in (False, True, False, False, True, True):
            ended = end_round(attempt, done, 0, decisions)
            assert ended == attempt.complete
            complete.append(ended)
        assert complete == [number > rounds for number in range(6)]
