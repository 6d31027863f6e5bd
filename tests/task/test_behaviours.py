"""What each behaviour commands, for any raw data."""

import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.geometry.angles import bearing_of, length, turn_to
from khepera_forage.robots.khepera import MAX_SPEED, Motors
from khepera_forage.task.behaviours import command
from khepera_forage.task.perception import RawData
from khepera_forage.task.states import Behaviour

PLACES = st.floats(0.0, 130.0) | st.just(50.0)
RAW = st.builds(
    RawData,
    proximity=st.tuples(*[st.integers(0, 1023)] * 6),
    arm=st.integers(215, 255),
    jaw=st.integers(0, 200),
    object_presence=st.sampled_from((0, 255)),
    x=PLACES,
    y=PLACES,
    orientation=st.integers(0, 359),
    tracked=st.booleans(),
    food_seen=st.booleans(),
    food_x=PLACES,
    food_y=PLACES,
    food_type=st.integers(0, 3),
    home_x=PLACES,
    home_y=PLACES,
    home_radius=st.integers(1, 40),
    home_opening=st.floats(-180.0, 180.0),
    wall_distance=st.floats(0.0, 60.0),
    wall_bearing=st.floats(-180.0, 180.0),
    home_distance=st.just(0.0),
    home_bearing=st.just(0.0),
    food_distance=st.just(0.0),
    food_bearing=st.just(0.0),
).map(lambda raw: placed(raw))
B = Behaviour


def placed(raw: RawData, **changes: Any) -> RawData:
    """Raw data with some of it changed, and the distances and bearings that follow."""
    raw = raw._replace(**changes)
    home = raw.home_x - raw.x, raw.home_y - raw.y
    food = (raw.food_x - raw.x, raw.food_y - raw.y) if raw.food_seen else (0.0, 0.0)
    return raw._replace(
        home_distance=length(*home),
        home_bearing=turn_to(bearing_of(*home), raw.orientation),
        food_distance=length(*food),
        food_bearing=turn_to(bearing_of(*food), raw.orientation) if raw.food_seen else 0.0,
    )


OPEN_FLOOR = placed(
    RawData(
        (0,) * 6, 215, 200, 0, 50.0, 23.0, 0, True, True, 90.0, 23.0, 0, 110.0, 23.0, 20, 180.0, 23.0, 90.0,
        0.0, 0.0, 0.0, 0.0,
    )
)  # fmt: skip


@given(raw=RAW, behaviour=st.sampled_from(list(Behaviour)))
def test_every_command_is_one_that_a_robot_takes_and_a_pure_function(
    raw: RawData, behaviour: Behaviour
) -> None:
    motors = command(behaviour, raw)
    assert all(math.isfinite(value) for value in motors)
    assert max(abs(motors.left), abs(motors.right)) <= MAX_SPEED
    assert 215 <= motors.arm <= 255
    assert motors.jaw in (0, 200)
    assert command(behaviour, raw) == motors


@given(RAW)
def test_explore_commands_exactly_what_identifies(raw: RawData) -> None:
    assert command(B.EXPLORE_FOOD, raw) == Motors(0, 0, 255, 200)


@given(RAW)
def test_the_arm_is_up_where_the_design_says_so_and_down_where_it_must_be(raw: RawData) -> None:
    for behaviour in (B.SEARCH_FOR_FOOD, B.MOVE_SLOWLY, B.AVOID_HOME):
        assert command(behaviour, raw)[2:] == (215, 200)
    carrying = raw._replace(jaw=126)
    assert command(B.GO_HOME, carrying)[2:] == (215, 0)
    assert command(B.PUSH_FOOD, raw)[2:] == (255, 0)
    assert command(B.AVOID_FOOD, raw)[2:] == (255, 200)
    assert command(B.RELEASE_FOOD, raw).arm == 255


@given(RAW)
def test_waiting_is_standing_still_and_keeping_what_one_has(raw: RawData) -> None:
    motors = command(B.WAIT, raw)
    assert motors[:3] == (0, 0, raw.arm)
    assert command(B.WAIT, raw._replace(jaw=126)).jaw == 0
    assert command(B.WAIT, raw._replace(jaw=200)).jaw == 200


@given(RAW)
def test_pick_up_closes_before_it_raises(raw: RawData) -> None:
    held = raw._replace(object_presence=255)
    assert command(B.PICK_UP_FOOD, held._replace(jaw=200)) == Motors(0, 0, 255, 0)
    assert command(B.PICK_UP_FOOD, held._replace(jaw=126)) == Motors(0, 0, 215, 0)


@given(RAW)
def test_pick_up_reaches_for_food_that_is_not_there_with_an_open_jaw(raw: RawData) -> None:
    assert command(B.PICK_UP_FOOD, raw._replace(object_presence=0, jaw=200)) == Motors(2, 2, 255, 200)


def test_search_is_fast_and_straight_towards_food_ahead() -> None:
    assert command(B.SEARCH_FOR_FOOD, OPEN_FLOOR)[:2] == (12.0, 12.0)
    assert command(B.MOVE_SLOWLY, OPEN_FLOOR)[:2] == (8.0, 8.0)


@pytest.mark.parametrize(("orientation", "sign"), [(30, -1), (330, 1), (120, -1), (240, 1)])
def test_search_turns_towards_the_food(orientation: int, sign: int) -> None:
    left, right, _, _ = command(B.SEARCH_FOR_FOOD, placed(OPEN_FLOOR, orientation=orientation))
    assert (right - left) * sign > 0


def test_search_looks_about_when_no_food_is_seen() -> None:
    left, right, _, _ = command(B.SEARCH_FOR_FOOD, placed(OPEN_FLOOR, food_seen=False))
    assert left < 0 < right
    assert 0 < left + right < 0.4 * (right - left), (
        "a small circle, so that it also comes away from where it stands"
    )


def test_search_goes_round_the_home_on_its_open_side() -> None:
    """Food behind the home: the way there is not straight across it."""
    raw = placed(OPEN_FLOOR, home_x=80.0, food_x=120.0)
    left, right, _, _ = command(B.SEARCH_FOR_FOOD, raw)
    assert left != right


def test_search_never_shoves_food_along() -> None:
    left, right, _, _ = command(B.SEARCH_FOR_FOOD, placed(OPEN_FLOOR, food_x=60.0))
    assert left < 0
    assert right < 0


def test_search_turns_off_obstacles_and_backs_off_a_blocked_way() -> None:
    left, right, _, _ = command(B.SEARCH_FOR_FOOD, placed(OPEN_FLOOR, proximity=(0, 400, 0, 0, 0, 0)))
    assert left > right, "an obstacle on the left: turn right"
    left, right, _, _ = command(B.SEARCH_FOR_FOOD, placed(OPEN_FLOOR, proximity=(0, 0, 900, 900, 0, 0)))
    assert left < 0
    assert right < 0


def test_orient_lowers_the_arm_aims_and_creeps_until_the_barrier_is_crossed() -> None:
    next_to = placed(OPEN_FLOOR, food_x=69.5)
    lowering = command(B.ORIENT_WITH_FOOD, next_to)
    assert lowering == Motors(0.0, 0.0, 255, 200)
    down = placed(next_to, arm=255)
    creeping = command(B.ORIENT_WITH_FOOD, down)
    assert creeping[:2] == (4.0, 4.0)
    askew = command(B.ORIENT_WITH_FOOD, placed(down, orientation=350))
    assert askew.left == -askew.right < 0, "the food is on the left"
    assert command(B.ORIENT_WITH_FOOD, placed(down, object_presence=255)) == Motors(0, 0, 255, 200)


def test_orient_backs_off_for_another_try_when_it_has_missed() -> None:
    missed = placed(OPEN_FLOOR, food_x=59.0, arm=255)
    backing = command(B.ORIENT_WITH_FOOD, missed)
    assert backing.left == backing.right < 0
    assert backing.jaw == 0
    still = command(B.ORIENT_WITH_FOOD, placed(missed, food_x=65.0, jaw=100))
    assert still.left < 0, "a closed jaw remembers it"


def test_release_goes_in_then_opens_then_backs_off() -> None:
    at_rim = placed(OPEN_FLOOR, x=91.0, jaw=126, object_presence=255, orientation=0)
    assert command(B.RELEASE_FOOD, at_rim).left > 0
    inside = placed(at_rim, x=100.0)
    assert command(B.RELEASE_FOOD, inside).jaw == 0
    assert command(B.RELEASE_FOOD, placed(inside, arm=255)).jaw == 200
    opened = command(B.RELEASE_FOOD, placed(inside, arm=255, jaw=200))
    assert opened.left == opened.right < 0


def test_a_turn_on_the_spot_does_not_sweep_a_wall() -> None:
    """Home behind, a wall close on the left: the short way is left, but the gripper is swung to the right."""
    raw = placed(
        OPEN_FLOOR, home_x=10.0, home_y=30.0, orientation=0, wall_distance=10.0, wall_bearing=90.0, jaw=126
    )
    left, right, _, _ = command(B.GO_HOME, raw)
    assert left > right
    left, right, _, _ = command(B.GO_HOME, raw._replace(wall_distance=60.0))
    assert left < right
