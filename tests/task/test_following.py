"""The learner's arc towards the teacher, and when it is separated (4.5.2)."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.robots.khepera import MAX_SPEED, Motors
from khepera_forage.task.decisions import DEFAULT_VALUES, Decisions
from khepera_forage.task.pairing import follow, recover, separated

DEFAULT = Decisions()
SAME_PLACE, SAME_HEADING, SEPARATION = DEFAULT.same_place, DEFAULT.same_heading, DEFAULT.separation
WHEELS = st.floats(-20.0, 20.0)
MOTORS = st.builds(Motors, left=WHEELS, right=WHEELS, arm=st.just(215), jaw=st.just(200))
PLACE = st.floats(0.0, 130.0)
DEGREES = st.integers(0, 359)


@given(motors=MOTORS, x=PLACE, y=PLACE, heading=DEGREES, tx=PLACE, ty=PLACE, teachers=DEGREES)
def test_follow_keeps_the_mean_speed_of_the_wheels(
    motors: Motors, x: float, y: float, heading: int, tx: float, ty: float, teachers: int
) -> None:
    led = follow(motors, x, y, heading, tx, ty, teachers, DEFAULT_VALUES)
    assert led.left + led.right == pytest.approx(motors.left + motors.right)
    assert led[2:] == motors[2:]
    if motors.left + motors.right <= 0 or math.dist((x, y), (tx, ty)) <= SAME_PLACE:
        assert led == motors


@given(motors=MOTORS, x=PLACE, y=PLACE, heading=DEGREES, tx=PLACE, ty=PLACE, teachers=DEGREES)
def test_follow_commands_speeds_within_a_robots_limits(
    motors: Motors, x: float, y: float, heading: int, tx: float, ty: float, teachers: int
) -> None:
    """Otherwise the robot clamps the faster wheel, which alters the speed after all (4.5.2)."""
    led = follow(motors, x, y, heading, tx, ty, teachers, DEFAULT_VALUES)
    assert max(abs(led.left), abs(led.right)) <= MAX_SPEED + 1e-9


@given(speed=st.floats(0.5, 20.0), x=PLACE, y=PLACE, heading=DEGREES, tx=PLACE, ty=PLACE, teachers=DEGREES)
def test_follow_turns_to_the_side_on_which_the_teacher_is(
    speed: float, x: float, y: float, heading: int, tx: float, ty: float, teachers: int
) -> None:
    led = follow(Motors(speed, speed, 215, 200), x, y, heading, tx, ty, teachers, DEFAULT_VALUES)
    c, s = math.cos(math.radians(heading)), math.sin(math.radians(heading))
    left_of_it = (ty - y) * c - (tx - x) * s
    if abs(left_of_it) > 1e-6:
        assert (led.right - led.left) * left_of_it >= 0
    difference = abs((teachers - heading + 180) % 360 - 180)
    if math.dist((x, y), (tx, ty)) > SAME_PLACE and difference > SAME_HEADING and abs(left_of_it) > 1e-6:
        assert led.right != led.left or speed == 20.0


def test_follow_bends_the_path_towards_the_teacher_unless_both_head_the_same_way() -> None:
    ahead = Motors(8.0, 8.0, 215, 200)
    assert follow(ahead, 50, 20, 0, 55, 28, 40, DEFAULT_VALUES).right > 8.0
    assert follow(ahead, 50, 20, 0, 55, 12, 320, DEFAULT_VALUES).left > 8.0
    assert follow(ahead, 50, 20, 0, 55, 28, SAME_HEADING, DEFAULT_VALUES) == ahead, (
        "the same direction: nothing is corrected"
    )


@given(x=PLACE, y=PLACE, heading=DEGREES, tx=PLACE, ty=PLACE)
def test_recover_drives_an_arc_at_recovery_speed(
    x: float, y: float, heading: int, tx: float, ty: float
) -> None:
    motors = recover(Motors(0, 0, 255, 0), x, y, heading, tx, ty, DEFAULT_VALUES)
    assert (motors.left + motors.right) / 2 == pytest.approx(DEFAULT.recovery_speed)
    assert min(motors.left, motors.right) >= 0
    assert motors[2:] == (255, 0)


def test_separated_begins_beyond_the_separation_distance() -> None:
    assert not separated(10, 10, 10 + SEPARATION, 10, DEFAULT_VALUES)
    assert separated(10, 10, 10, 10 + SEPARATION + 0.1, DEFAULT_VALUES)
