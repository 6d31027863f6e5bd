"""Each decision changes what its rule does. Decisions about worlds: `tests/envs/test_decisions.py`."""

import math
from collections.abc import Callable
from typing import Any

import pytest

from khepera_forage.robots.khepera import Motors
from khepera_forage.task.behaviours import command
from khepera_forage.task.decisions import Decisions, DecisionValues
from khepera_forage.task.episode import DecisionCounts, count_decision
from khepera_forage.task.pairing import follow, recover, separated
from khepera_forage.task.perception import RawData
from khepera_forage.task.states import Behaviour, State
from tests.task.raw_data import OPEN_FLOOR, placed
from tests.version_0_1 import V0_1

B = Behaviour
ARM_DOWN_RAW = OPEN_FLOOR._replace(arm=255)


def changed_to(**changes: Any) -> DecisionValues:
    """Version 0.1 with some changes: what the others decide matters, too."""
    return Decisions.from_changes(changes, V0_1).values()


def food_at(distance: float, degrees: float = 0.0, **changes: Any) -> RawData:
    """Raw data with food at a distance and bearing, on an open floor."""
    x = OPEN_FLOOR.x + distance * math.cos(math.radians(degrees))
    y = OPEN_FLOOR.y + distance * math.sin(math.radians(degrees))
    return placed(OPEN_FLOOR, food_x=x, food_y=y, **changes)


def check_boundary(
    name: str, values: tuple[float, ...], rule: Callable[[float, DecisionValues], Any]
) -> None:
    """A rule gives one result below the decision's value and another above, wherever the value is."""
    results = set()
    for value in values:
        decisions = changed_to(**{name: value})
        below, above = rule(value - 0.01, decisions), rule(value + 0.01, decisions)
        assert below != above, value
        results.add((below, above))
    assert len(results) == 1


# ---------------------------------------------------------------- states


def test_close_to_food_decides_which_orienting_was_without_food() -> None:
    def without_food(distance: float, decisions: DecisionValues) -> int:
        counts = DecisionCounts()
        count_decision(counts, State.SEARCH, B.ORIENT_WITH_FOOD, distance, decisions)
        return counts.orient_without_food

    check_boundary("close_to_food", (21.0, 40.0), without_food)


# ---------------------------------------------------------------- speeds of behaviours

SPEEDS = {
    "search_speed": (B.SEARCH_FOR_FOOD, OPEN_FLOOR, 1, 1),
    "home_speed": (B.GO_HOME, OPEN_FLOOR._replace(jaw=126), 1, 1),
    "push_speed": (B.PUSH_FOOD, ARM_DOWN_RAW._replace(jaw=126), 1, 1),
    "orient_speed": (B.ORIENT_WITH_FOOD, food_at(19, arm=255), 1, 1),
    "retreat_speed": (B.SEARCH_FOR_FOOD, ARM_DOWN_RAW, -1, -1),
    "turn_speed": (B.SEARCH_FOR_FOOD, food_at(40, degrees=60), -1, 1),
    "quick_turn_speed": (B.SEARCH_FOR_FOOD, food_at(40, degrees=80), -1, 1),
}
"""Behaviour, raw data, and the sign of the speed on the left and right wheel."""


@pytest.mark.parametrize("name", SPEEDS)
@pytest.mark.parametrize("speed", [4.0, 9.5, 12.0])
def test_speed_is_what_the_behaviour_commands(name: str, speed: float) -> None:
    behaviour, raw, left, right = SPEEDS[name]
    motors = command(behaviour, raw, changed_to(**{name: speed}))
    assert motors[:2] == pytest.approx((left * speed, right * speed))


@pytest.mark.parametrize(
    ("behaviour", "raw", "sign"),
    [
        (B.MOVE_SLOWLY, OPEN_FLOOR, 1),
        (B.AVOID_FOOD, OPEN_FLOOR, -1),
        (B.AVOID_HOME, placed(OPEN_FLOOR, orientation=180), 1),
        (B.RELEASE_FOOD, placed(ARM_DOWN_RAW, jaw=126, x=91.0), 1),
    ],
)
def test_slow_speed_is_that_of_four_behaviours(behaviour: Behaviour, raw: RawData, sign: int) -> None:
    for speed in (2.0, 6.5, 12.0):
        assert command(behaviour, raw, changed_to(slow_speed=speed))[:2] == (sign * speed, sign * speed)


@pytest.mark.parametrize(
    ("behaviour", "raw"),
    [
        (B.MOVE_SLOWLY, food_at(5)),
        (B.ORIENT_WITH_FOOD, food_at(5, arm=255)),
        (B.AVOID_HOME, OPEN_FLOOR),
        (B.RELEASE_FOOD, placed(ARM_DOWN_RAW, x=100.0)),
    ],
)
def test_retreat_speed_is_that_of_every_retreat(behaviour: Behaviour, raw: RawData) -> None:
    for speed in (1.0, 7.5, 12.0):
        assert command(behaviour, raw, changed_to(retreat_speed=speed))[:2] == (-speed, -speed)


@pytest.mark.parametrize("speed", [0.0, 3.0, 5.0])
def test_circle_speed_is_the_mean_speed_of_search_without_food(speed: float) -> None:
    motors = command(B.SEARCH_FOR_FOOD, placed(OPEN_FLOOR, food_seen=False), changed_to(circle_speed=speed))
    assert motors[:2] == (speed - 5.0, speed + 5.0)


# ---------------------------------------------------------------- readings of behaviours


def test_search_without_food_may_wander() -> None:
    unseen, wander = placed(OPEN_FLOOR, food_seen=False), changed_to(search_without_food="wander")
    assert command(B.SEARCH_FOR_FOOD, unseen, wander) == Motors(12, 12, 215, 200)
    turn = Motors(-5, 5, 215, 200)
    for sensor in range(1, 5):
        proximity = tuple(200 if k == sensor else 0 for k in range(6))
        assert command(B.SEARCH_FOR_FOOD, unseen._replace(proximity=proximity), wander) == turn  # type: ignore[arg-type]
    ahead = unseen._replace(wall_distance=20.0, wall_bearing=-50.0)
    assert command(B.SEARCH_FOR_FOOD, ahead, wander) == turn
    against = unseen._replace(wall_distance=15.0, wall_bearing=10.0)
    assert command(B.SEARCH_FOR_FOOD, against, wander) == Motors(-8, -8, 215, 200)


@pytest.mark.parametrize("behaviour", [B.SEARCH_FOR_FOOD, B.MOVE_SLOWLY])
def test_robot_beside_food_backs_off_or_turns_away_or_drives_on(behaviour: Behaviour) -> None:
    beside = food_at(11, proximity=(0, 0, 300, 200, 0, 0))

    def wheels(reading: str) -> tuple[float, float]:
        motors = command(behaviour, beside, changed_to(beside_food=reading))
        return motors.left, motors.right

    assert wheels("back off") == (-5, -5)
    left, right = wheels("turn away")
    assert left > right, "the obstacle is further left"
    left, right = wheels("drive on")
    assert left == right > 0


def test_orienting_may_lower_the_arm_over_the_food() -> None:
    over = changed_to(orienting="lowered over food")

    def motors(distance: float, degrees: float = 0.0, **changes: Any) -> Motors:
        return command(B.ORIENT_WITH_FOOD, food_at(distance, degrees, **changes), over)

    assert motors(19) == motors(12) == Motors(0, 0, 255, 200), "down around the food"
    assert motors(15, 40) == Motors(-5, 5, 215, 200), "turns with the arm raised"
    assert motors(15, -10) == Motors(1, -1, 215, 200)
    assert motors(15, arm=255) == Motors(4, 4, 255, 200)
    assert motors(15, -10, arm=255) == Motors(1, -1, 255, 200)
    assert motors(15, 40, arm=255) == Motors(0, 0, 215, 200), "up before it turns that far"
    assert motors(11.5, arm=255, object_presence=255) == Motors(0, 0, 255, 200)
    assert motors(9) == Motors(-5, -5, 215, 200), "too near"


def test_move_slowly_may_leave_the_arm_as_orient_left_it() -> None:
    raw, as_it_is = food_at(25, arm=255), changed_to(arm_after_orienting="as it is")
    assert command(B.MOVE_SLOWLY, raw, changed_to()) == Motors(-5, -5, 215, 200)
    assert command(B.MOVE_SLOWLY, raw, as_it_is) == Motors(8, 8, 255, 200)
    assert command(B.MOVE_SLOWLY, raw._replace(arm=215), as_it_is).arm == 215
    assert command(B.SEARCH_FOR_FOOD, raw, as_it_is).arm == 215


# ---------------------------------------------------------------- distances and angles of behaviours


def test_back_off_distance_moves_where_search_and_move_slowly_retreat() -> None:
    for behaviour in (B.SEARCH_FOR_FOOD, B.MOVE_SLOWLY):

        def retreats(distance: float, decisions: DecisionValues, behaviour: Behaviour = behaviour) -> bool:
            return command(behaviour, food_at(distance), decisions).left < 0

        check_boundary("back_off_distance", (5.0, 13.0, 20.0), retreats)


def test_aimed_moves_the_angle_from_which_orient_turns() -> None:
    def turns(degrees: float, decisions: DecisionValues) -> bool:
        return command(B.ORIENT_WITH_FOOD, food_at(19, degrees, arm=255), decisions).left < 0

    check_boundary("aimed", (1.0, 5.0, 15.0), turns)


def test_astray_moves_the_angle_from_which_orient_raises_the_arm() -> None:
    def arm(degrees: float, decisions: DecisionValues) -> int:
        return command(B.ORIENT_WITH_FOOD, food_at(19, degrees, arm=255), decisions).arm

    check_boundary("astray", (10.0, 20.0, 90.0), arm)


def test_missed_distance_moves_where_orient_gives_up_a_try() -> None:
    def jaw(distance: float, decisions: DecisionValues) -> int:
        return command(B.ORIENT_WITH_FOOD, food_at(distance, arm=255), decisions).jaw

    check_boundary("missed_distance", (5.0, 10.0, 15.0), jaw)


def test_release_depth_moves_the_place_in_the_home_where_food_is_released() -> None:
    def jaw(depth: float, decisions: DecisionValues) -> int:
        x = OPEN_FLOOR.home_x - OPEN_FLOOR.home_radius + depth
        return command(B.RELEASE_FOOD, placed(ARM_DOWN_RAW, jaw=126, x=x), decisions).jaw

    check_boundary("release_depth", (0.0, 7.0, 15.0), jaw)


# ---------------------------------------------------------------- following

AHEAD = Motors(8.0, 8.0, 215, 200)


def test_separation_moves_the_distance_from_which_robots_are_separated() -> None:
    def apart(distance: float, decisions: DecisionValues) -> bool:
        return separated(10, 10, 10, 10 + distance, decisions)

    check_boundary("separation", (5.0, 14.0, 40.0), apart)


def test_same_place_moves_the_distance_from_which_the_learner_follows() -> None:
    def bends(distance: float, decisions: DecisionValues) -> bool:
        return follow(AHEAD, 50, 20, 0, 50, 20 + distance, 40, decisions) != AHEAD

    check_boundary("same_place", (1.0, 2.0, 10.0), bends)


def test_same_heading_moves_the_angle_from_which_the_learner_follows() -> None:
    def bends(degrees: float, decisions: DecisionValues) -> bool:
        return follow(AHEAD, 50, 20, 0, 50, 28, degrees, decisions) != AHEAD

    check_boundary("same_heading", (1.0, 8.0, 45.0), bends)


@pytest.mark.parametrize("gain", [0.01, 0.05, 0.08])
def test_following_gain_is_the_turn_for_each_degree(gain: float) -> None:
    led = follow(AHEAD, 50, 20, 0, 50, 28, 40, changed_to(following_gain=gain))
    assert led[:2] == pytest.approx((8.0 - 90 * gain, 8.0 + 90 * gain))
    recovering = recover(AHEAD, 50, 20, 0, 58, 28, changed_to(following_gain=gain))
    assert recovering[:2] == pytest.approx((6.0 - 45 * gain, 6.0 + 45 * gain))


@pytest.mark.parametrize("speed", [1.0, 6.0, 12.0])
def test_recovery_speed_is_the_mean_speed_of_recovery(speed: float) -> None:
    motors = recover(Motors(0, 0, 255, 0), 50, 20, 0, 58, 28, changed_to(recovery_speed=speed))
    assert (motors.left + motors.right) / 2 == pytest.approx(speed)
