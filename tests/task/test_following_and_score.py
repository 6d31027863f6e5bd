"""Following, identification, delivery and score."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.robots.khepera import MAX_SPEED, Motors, Senses
from khepera_forage.task.following import (
    NOMINAL_SPEED,
    SAME_HEADING,
    SAME_PLACE,
    SEPARATION,
    follow,
    recover,
    separated,
)
from khepera_forage.task.identification import at_home, drawn_type, explored
from khepera_forage.task.scoring import penalty, score
from khepera_forage.task.states import FoodType
from khepera_forage.thesis import appendix_a

WHEELS = st.floats(-20.0, 20.0)
MOTORS = st.builds(Motors, left=WHEELS, right=WHEELS, arm=st.just(215), jaw=st.just(200))
PLACE = st.floats(0.0, 130.0)
DEGREES = st.integers(0, 359)


@given(motors=MOTORS, x=PLACE, y=PLACE, heading=DEGREES, tx=PLACE, ty=PLACE, teachers=DEGREES)
def test_following_never_changes_the_mean_of_the_wheels(
    motors: Motors, x: float, y: float, heading: int, tx: float, ty: float, teachers: int
) -> None:
    led = follow(motors, x, y, heading, tx, ty, teachers)
    assert led.left + led.right == pytest.approx(motors.left + motors.right)
    assert led[2:] == motors[2:]
    if motors.left + motors.right <= 0 or math.dist((x, y), (tx, ty)) <= SAME_PLACE:
        assert led == motors


@given(motors=MOTORS, x=PLACE, y=PLACE, heading=DEGREES, tx=PLACE, ty=PLACE, teachers=DEGREES)
def test_what_following_asks_for_wheels_can_do(
    motors: Motors, x: float, y: float, heading: int, tx: float, ty: float, teachers: int
) -> None:
    """Otherwise the robot clamps the faster wheel, which alters the speed after all (4.5.2)."""
    led = follow(motors, x, y, heading, tx, ty, teachers)
    assert max(abs(led.left), abs(led.right)) <= MAX_SPEED + 1e-9


@given(speed=st.floats(0.5, 20.0), x=PLACE, y=PLACE, heading=DEGREES, tx=PLACE, ty=PLACE, teachers=DEGREES)
def test_following_turns_to_the_side_on_which_the_teacher_is(
    speed: float, x: float, y: float, heading: int, tx: float, ty: float, teachers: int
) -> None:
    led = follow(Motors(speed, speed, 215, 200), x, y, heading, tx, ty, teachers)
    c, s = math.cos(math.radians(heading)), math.sin(math.radians(heading))
    left_of_it = (ty - y) * c - (tx - x) * s
    if abs(left_of_it) > 1e-6:
        assert (led.right - led.left) * left_of_it >= 0
    apart = abs((teachers - heading + 180) % 360 - 180)
    if math.dist((x, y), (tx, ty)) > SAME_PLACE and apart > SAME_HEADING and abs(left_of_it) > 1e-6:
        assert led.right != led.left or speed == 20.0


def test_following_bends_the_way_towards_the_teacher() -> None:
    ahead = Motors(8.0, 8.0, 215, 200)
    assert follow(ahead, 50, 20, 0, 55, 28, 40).right > 8.0
    assert follow(ahead, 50, 20, 0, 55, 12, 320).left > 8.0
    assert follow(ahead, 50, 20, 0, 55, 28, SAME_HEADING) == ahead, "the same direction: nothing to correct"


@given(x=PLACE, y=PLACE, heading=DEGREES, tx=PLACE, ty=PLACE)
def test_recovery_is_an_arc_at_nominal_speed(x: float, y: float, heading: int, tx: float, ty: float) -> None:
    motors = recover(Motors(0, 0, 255, 0), x, y, heading, tx, ty)
    assert (motors.left + motors.right) / 2 == pytest.approx(NOMINAL_SPEED)
    assert min(motors.left, motors.right) >= 0
    assert motors[2:] == (255, 0)


def test_separation_is_a_distance() -> None:
    assert not separated(10, 10, 10 + SEPARATION, 10)
    assert separated(10, 10, 10, 10 + SEPARATION + 0.1)


def test_the_score_is_equation_5_1_with_the_thesis_penalties() -> None:
    assert score(0, 0, 0, 1) == 0.0
    assert score(75, 100, 1, 1) == 75.0
    assert score(75, 100, 0, 1) == 55.0
    assert (penalty(0, 2), penalty(1, 2), penalty(2, 2)) == (20.0, 5.0, 0.0)
    assert penalty(0, 0) == 0.0, "poison never counts as uncollected"


def test_the_score_agrees_with_every_line_of_the_thesis_that_has_no_slip() -> None:
    agreeing = 0
    for row in appendix_a.recalls():
        share = 100 * row.correct / row.total
        if int(share) == row.percent and row.score == row.percent - row.points:
            foods = 1 if row.arena == "corridor" else 2
            delivered = row.delivered(foods)
            assert int(score(row.correct, row.total, delivered, foods) + 1e-9) == row.score
            agreeing += 1
    assert agreeing > 80


@pytest.mark.parametrize(
    ("draw", "odds", "food_type"),
    [
        (0.0, (1.0, 0.0), FoodType.PICKABLE),
        (0.999, (1.0, 0.0), FoodType.PICKABLE),
        (0.0, (0.0, 1.0), FoodType.PUSHABLE),
        (0.0, (0.0, 0.0), FoodType.POISONOUS),
        (0.49, (0.5, 0.25), FoodType.PICKABLE),
        (0.51, (0.5, 0.25), FoodType.PUSHABLE),
        (0.76, (0.5, 0.25), FoodType.POISONOUS),
    ],
)
def test_types_are_drawn_by_their_odds(draw: float, odds: tuple[float, float], food_type: FoodType) -> None:
    assert drawn_type(draw, *odds) == food_type


def test_food_is_identified_after_one_still_round_in_the_barrier() -> None:
    in_place = Senses((0,) * 8, 0, 0, 255, 200, 255)
    still = Motors(0, 0, 255, 200)
    assert explored(in_place, in_place, still)
    assert not explored(in_place._replace(object_presence=0), in_place, still)
    assert not explored(in_place, in_place._replace(object_presence=0), still)
    assert not explored(in_place._replace(arm=215), in_place, still)
    assert not explored(in_place, in_place._replace(jaw=126), still)
    assert not explored(in_place, in_place._replace(arm=215), still)
    assert not explored(in_place._replace(jaw=126), in_place, still)
    assert not explored(in_place, in_place, still._replace(left=1))
    assert not explored(in_place, in_place, still._replace(right=-1))


def test_home_is_a_disc_with_its_rim() -> None:
    assert at_home(10, 20, 10, 0, 20)
    assert not at_home(10, 20.1, 10, 0, 20)
