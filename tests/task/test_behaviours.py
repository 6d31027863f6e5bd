"""What each behaviour commands, for any raw data."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.geometry.plane import heading_of, turn_to
from khepera_forage.robots.khepera import MAX_SPEED, Motors
from khepera_forage.task.arena_map import EVERY_SIDE
from khepera_forage.task.behaviours import command, detour, is_home_across
from khepera_forage.task.decisions import DEFAULT_VALUES, DecisionValues
from khepera_forage.task.perception import RawData
from khepera_forage.task.states import Behaviour
from tests.task.raw_data import OPEN_FLOOR, placed, raw_data
from tests.version_0_1 import VALUES

B = Behaviour


def motors_for(behaviour: Behaviour, raw: RawData, decisions: DecisionValues = DEFAULT_VALUES) -> Motors:
    """What a behaviour commands under the default decisions, or others."""
    return command(behaviour, raw, decisions)


def motors_in_0_1(behaviour: Behaviour, raw: RawData) -> Motors:
    """What a behaviour commands under the decisions of version 0.1."""
    return motors_for(behaviour, raw, VALUES)


@pytest.mark.parametrize("decisions", [VALUES, DEFAULT_VALUES], ids=["v0.1", "default"])
@given(raw=raw_data, behaviour=st.sampled_from(list(Behaviour)))
def test_every_command_is_executable_and_repeatable(
    decisions: DecisionValues, raw: RawData, behaviour: Behaviour
) -> None:
    motors = motors_for(behaviour, raw, decisions)
    assert all(math.isfinite(value) for value in motors)
    assert 215 <= motors.arm <= 255
    assert motors.jaw in (0, 200)
    assert motors_for(behaviour, raw, decisions) == motors


@given(raw=raw_data, behaviour=st.sampled_from(list(Behaviour)))
def test_commands_of_version_0_1_are_within_the_limit_of_the_wheels(
    raw: RawData, behaviour: Behaviour
) -> None:
    """Robots limit the speeds of other versions, whose curves may ask for more."""
    motors = motors_in_0_1(behaviour, raw)
    assert max(abs(motors.left), abs(motors.right)) <= MAX_SPEED


@given(raw_data)
def test_explore_stands_still_with_arm_down_and_jaw_open(raw: RawData) -> None:
    assert motors_for(B.EXPLORE_FOOD, raw) == Motors(0, 0, 255, 200)


@given(raw_data)
def test_arm_and_jaw_are_where_each_behaviour_needs_them(raw: RawData) -> None:
    for behaviour in (B.SEARCH_FOR_FOOD, B.MOVE_SLOWLY, B.AVOID_HOME):
        assert motors_for(behaviour, raw)[2:] == (215, 200)
    carrying = raw._replace(jaw=126)
    assert motors_for(B.GO_HOME, carrying)[2:] == (215, 0)
    assert motors_for(B.PUSH_FOOD, raw)[2:] == (255, 0)
    assert motors_for(B.AVOID_FOOD, raw)[2:] == (255, 200)
    assert motors_for(B.RELEASE_FOOD, raw).arm == 255


@given(raw_data)
def test_wait_stands_still_and_keeps_arm_and_jaw(raw: RawData) -> None:
    motors = motors_for(B.WAIT, raw)
    assert motors[:3] == (0, 0, raw.arm)
    assert motors_for(B.WAIT, raw._replace(jaw=126)).jaw == 0
    assert motors_for(B.WAIT, raw._replace(jaw=200)).jaw == 200


@given(raw_data)
def test_pick_up_closes_the_jaw_before_it_raises_the_arm(raw: RawData) -> None:
    held = raw._replace(object_presence=255)
    assert motors_for(B.PICK_UP_FOOD, held._replace(jaw=200)) == Motors(0, 0, 255, 0)
    assert motors_for(B.PICK_UP_FOOD, held._replace(jaw=126)) == Motors(0, 0, 215, 0)


@given(raw_data)
def test_pick_up_without_an_object_creeps_ahead_with_an_open_jaw(raw: RawData) -> None:
    assert motors_for(B.PICK_UP_FOOD, raw._replace(object_presence=0, jaw=200)) == Motors(2, 2, 255, 200)


def test_search_drives_straight_to_food_ahead_faster_than_move_slowly() -> None:
    assert motors_in_0_1(B.SEARCH_FOR_FOOD, OPEN_FLOOR)[:2] == (12.0, 12.0)
    assert motors_in_0_1(B.MOVE_SLOWLY, OPEN_FLOOR)[:2] == (8.0, 8.0)


@pytest.mark.parametrize(("orientation", "sign"), [(30, -1), (330, 1), (120, -1), (240, 1)])
def test_search_turns_towards_the_food(orientation: int, sign: int) -> None:
    left, right, _, _ = motors_for(B.SEARCH_FOR_FOOD, placed(OPEN_FLOOR, orientation=orientation))
    assert (right - left) * sign > 0


def test_search_without_food_drives_a_small_circle() -> None:
    left, right, _, _ = motors_for(B.SEARCH_FOR_FOOD, placed(OPEN_FLOOR, food_seen=False))
    assert left < 0 < right
    assert 0 < left + right < 0.4 * (right - left), "a small circle, so that the robot also leaves its place"


def test_search_drives_around_the_home_to_food_behind_it() -> None:
    """The way to food behind the home does not lead across it."""
    raw = placed(OPEN_FLOOR, home_x=80.0, food_x=120.0)
    left, right, _, _ = motors_for(B.SEARCH_FOR_FOOD, raw)
    assert left != right


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("around", range(0, 360, 30))
def test_search_passes_a_free_home_on_the_side_of_the_food(around: int, side: int) -> None:
    """Whatever the direction: a home against a wall is passed on its open side."""
    home_x, home_y = 200.0 + 17.0 * heading_of(around)[0], 200.0 + 17.0 * heading_of(around)[1]
    beyond = (around + side * 10) % 360
    raw = placed(
        OPEN_FLOOR,
        x=200.0,
        y=200.0,
        orientation=around,
        home_x=home_x,
        home_y=home_y,
        home_radius=16,
        home_opening=EVERY_SIDE,
        food_x=200.0 + 100.0 * heading_of(beyond)[0],
        food_y=200.0 + 100.0 * heading_of(beyond)[1],
    )
    left, right, _, _ = motors_for(B.SEARCH_FOR_FOOD, raw)
    assert (right - left) * side > 0


@pytest.mark.parametrize("behind", [-30, -10, -1, 1, 10, 30])
@pytest.mark.parametrize("start", range(-140, 141, 20))
def test_search_keeps_its_side_of_the_home_on_the_way_to_food_behind_it(start: int, behind: int) -> None:
    """Past the open side, which is to the right here. Robots turned to and fro where two rules met."""
    food = (180 + behind) % 360
    food_x, food_y = 200.0 + 26.0 * heading_of(food)[0], 200.0 + 26.0 * heading_of(food)[1]
    around, steps = start, 0
    while True:
        x, y = 200.0 + 17.0 * heading_of(around % 360)[0], 200.0 + 17.0 * heading_of(around % 360)[1]
        raw = placed(
            OPEN_FLOOR,
            x=x,
            y=y,
            home_x=200.0,
            home_y=200.0,
            home_radius=16,
            home_opening=0.0,
            food_x=food_x,
            food_y=food_y,
        )
        if not is_home_across(raw) or detour(raw) == 0.0:
            break
        # Which way round the home the robot drives: counter-clockwise if it has the home on its left.
        around += 2 if turn_to(raw.food_bearing + detour(raw), raw.home_bearing) < 0.0 else -2
        steps += 2
        assert steps < 360
    assert abs(around) < 180, "not behind the home"


@pytest.mark.parametrize("around", range(0, 360, 30))
def test_avoid_home_leaves_a_free_home_by_the_shortest_way(around: int) -> None:
    """A robot at the rim that faces out drives straight on."""
    raw = placed(
        OPEN_FLOOR,
        x=200.0 + 15.0 * heading_of(around)[0],
        y=200.0 + 15.0 * heading_of(around)[1],
        orientation=around,
        home_x=200.0,
        home_y=200.0,
        home_radius=16,
        home_opening=EVERY_SIDE,
    )
    left, right, _, _ = motors_for(B.AVOID_HOME, raw)
    assert left == pytest.approx(right)
    assert left > 0


def test_search_backs_off_food_that_is_too_near() -> None:
    left, right, _, _ = motors_for(B.SEARCH_FOR_FOOD, placed(OPEN_FLOOR, food_x=60.0))
    assert left < 0
    assert right < 0


def test_search_turns_away_from_obstacles_and_backs_off_when_blocked() -> None:
    left, right, _, _ = motors_for(B.SEARCH_FOR_FOOD, placed(OPEN_FLOOR, proximity=(0, 400, 0, 0, 0, 0)))
    assert left > right, "an obstacle on the left: turn right"
    left, right, _, _ = motors_for(B.SEARCH_FOR_FOOD, placed(OPEN_FLOOR, proximity=(0, 0, 900, 900, 0, 0)))
    assert left < 0
    assert right < 0


def test_orient_lowers_the_arm_aims_and_creeps_until_the_barrier_is_interrupted() -> None:
    next_to = placed(OPEN_FLOOR, food_x=69.5)
    lowering = motors_in_0_1(B.ORIENT_WITH_FOOD, next_to)
    assert lowering == Motors(0.0, 0.0, 255, 200)
    down = placed(next_to, arm=255)
    creeping = motors_in_0_1(B.ORIENT_WITH_FOOD, down)
    assert creeping[:2] == (4.0, 4.0)
    askew = motors_in_0_1(B.ORIENT_WITH_FOOD, placed(down, orientation=350))
    assert askew.left == -askew.right < 0, "the food is on the left"
    assert motors_in_0_1(B.ORIENT_WITH_FOOD, placed(down, object_presence=255)) == Motors(0, 0, 255, 200)


def test_orient_backs_off_after_a_missed_try() -> None:
    missed = placed(OPEN_FLOOR, food_x=59.0, arm=255)
    backing = motors_in_0_1(B.ORIENT_WITH_FOOD, missed)
    assert backing.left == backing.right < 0
    assert backing.jaw == 0
    still = motors_in_0_1(B.ORIENT_WITH_FOOD, placed(missed, food_x=65.0, jaw=100))
    assert still.left < 0, "a closed jaw marks the missed try"


def test_release_drives_in_then_opens_then_backs_off() -> None:
    at_rim = placed(OPEN_FLOOR, x=91.0, jaw=126, object_presence=255, orientation=0)
    assert motors_for(B.RELEASE_FOOD, at_rim).left > 0
    inside = placed(at_rim, x=100.0)
    assert motors_for(B.RELEASE_FOOD, inside).jaw == 0
    assert motors_for(B.RELEASE_FOOD, placed(inside, arm=255)).jaw == 200
    opened = motors_for(B.RELEASE_FOOD, placed(inside, arm=255, jaw=200))
    assert opened.left == opened.right < 0


def test_turn_on_the_spot_keeps_the_gripper_off_a_wall() -> None:
    """Home behind, a wall close on the left: left is the shorter turn, but the robot turns right."""
    raw = placed(
        OPEN_FLOOR, home_x=10.0, home_y=30.0, orientation=0, wall_distance=10.0, wall_bearing=90.0, jaw=126
    )
    left, right, _, _ = motors_for(B.GO_HOME, raw)
    assert left > right
    left, right, _, _ = motors_for(B.GO_HOME, raw._replace(wall_distance=60.0))
    assert left < right
