"""What each behaviour commands, for any raw data, and what each decision changes in it.

Decisions about worlds: `tests/envs/test_decisions.py`.
"""

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.geometry.plane import bearing_of, heading_of, length, turn_to
from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, JAW_CLOSED, JAW_OPEN, MAX_SPEED, Motors
from khepera_forage.task.arena_map import EVERY_SIDE
from khepera_forage.task.behaviours import command, decode_motors
from khepera_forage.task.decisions import DEFAULT_VALUES, DecisionValues
from khepera_forage.task.perception import RawData
from khepera_forage.task.states import Behaviour
from tests.version_0_1 import V0_1, VALUES, changed_to

B = Behaviour
UNIT = st.floats(-1, 1)
motors_for = partial(command, decisions=DEFAULT_VALUES)


def placed(raw: RawData, **changes: Any) -> RawData:
    """Raw data with some of it changed, and the distances and bearings that follow."""
    raw = raw._replace(**changes)
    home, food = (raw.home_x - raw.x, raw.home_y - raw.y), (raw.food_x - raw.x, raw.food_y - raw.y)
    return raw._replace(
        home_distance=length(*home),
        home_path=length(*home),
        home_bearing=turn_to(bearing_of(*home), raw.orientation),
        food_distance=length(*food) * raw.food_seen,
        food_bearing=turn_to(bearing_of(*food), raw.orientation) * raw.food_seen,
        food_waypoint_x=raw.food_x,
        food_waypoint_y=raw.food_y,
    )


ENV: Any = BehavioursEnv(arena="corridor", foods=1, noise="none", decisions=V0_1)
ENV.reset(seed=0, options={"start": (250, 115, 0), "foods": [(400, 115)]})
OPEN_FLOOR = placed(ENV.forager.raw, food_x=90.0)
"""A robot with its arm up looks along the corridor, at food 40 pixels ahead and the home behind the food."""
LOWERED = OPEN_FLOOR._replace(arm=255)
PLACES = st.floats(0.0, 130.0) | st.just(50.0)
RAW_DATA = st.builds(
    placed,
    st.just(OPEN_FLOOR),
    proximity=st.tuples(*[st.integers(0, 1023)] * 6),
    arm=st.integers(215, 255),
    jaw=st.integers(0, 200),
    object_presence=st.sampled_from((0, 255)),
    x=PLACES,
    y=PLACES,
    orientation=st.integers(0, 359),
    food_seen=st.booleans(),
    food_x=PLACES,
    food_y=PLACES,
    home_x=PLACES,
    home_y=PLACES,
    home_radius=st.integers(1, 40),
    home_opening=st.floats(-180.0, 180.0),
    wall_distance=st.floats(0.0, 60.0),
    wall_bearing=st.floats(-180.0, 180.0),
)


def food_at(distance: float, degrees: float = 0.0, **changes: Any) -> RawData:
    """Raw data with food at a distance and bearing, on an open floor."""
    x = OPEN_FLOOR.x + distance * math.cos(math.radians(degrees))
    y = OPEN_FLOOR.y + distance * math.sin(math.radians(degrees))
    return placed(OPEN_FLOOR, food_x=x, food_y=y, **changes)


@given(raw=RAW_DATA, behaviour=st.sampled_from(list(Behaviour)))
def test_every_command_is_executable(raw: RawData, behaviour: Behaviour) -> None:
    """Robots limit the speeds of the default decisions, whose curves may ask for more."""
    for decisions in (VALUES, DEFAULT_VALUES):
        motors = command(behaviour, raw, decisions)
        assert all(math.isfinite(value) for value in motors)
        assert 215 <= motors.arm <= 255
        assert motors.jaw in (0, 200)
        assert decisions is DEFAULT_VALUES or max(abs(motors.left), abs(motors.right)) <= MAX_SPEED


@given(RAW_DATA)
def test_arm_and_jaw_are_where_each_behaviour_needs_them(raw: RawData) -> None:
    for behaviour in (B.SEARCH_FOR_FOOD, B.MOVE_SLOWLY, B.AVOID_HOME):
        assert motors_for(behaviour, raw)[2:] == (215, 200)
    assert motors_for(B.EXPLORE_FOOD, raw) == Motors(0, 0, 255, 200)
    assert motors_for(B.GO_HOME, raw._replace(jaw=126))[2:] == (215, 0)
    assert motors_for(B.PUSH_FOOD, raw)[2:] == (255, 0)
    assert motors_for(B.AVOID_FOOD, raw)[2:] == (255, 200)
    assert motors_for(B.RELEASE_FOOD, raw).arm == 255
    assert motors_for(B.RELEASE_FOOD, raw._replace(arm=215, jaw=126)).jaw == 0, "opens once the arm is down"
    for jaw, kept in ((126, 0), (200, 200)):
        assert motors_for(B.WAIT, raw._replace(jaw=jaw)) == Motors(0, 0, raw.arm, kept)
    held = raw._replace(object_presence=255)
    assert motors_for(B.PICK_UP_FOOD, held._replace(jaw=200)) == Motors(0, 0, 255, 0), "closes first"
    assert motors_for(B.PICK_UP_FOOD, held._replace(jaw=126)) == Motors(0, 0, 215, 0)
    assert motors_for(B.PICK_UP_FOOD, raw._replace(object_presence=0, jaw=0)) == Motors(0, 0, 215, 0)
    creeping = motors_for(B.PICK_UP_FOOD, raw._replace(object_presence=0, jaw=200))
    assert creeping == Motors(2, 2, 255, 200)


@given(left=UNIT, right=UNIT, arm=UNIT, jaw=UNIT)
def test_actions_of_wheels_environments_reach_the_limits(left: float, right: float, arm: float, jaw: float) -> None:
    motors = decode_motors(left, right, arm, jaw)
    assert (motors.left, motors.right) == (left * MAX_SPEED, right * MAX_SPEED)
    assert ARM_RAISED <= motors.arm <= ARM_DOWN
    assert abs(motors.arm - (235 - 20 * arm)) <= 0.5
    assert motors.jaw == (JAW_CLOSED if jaw > 0 else JAW_OPEN)


FREE_HOME: dict[str, Any] = {"home_x": 200.0, "home_y": 200.0, "home_radius": 16, "home_opening": EVERY_SIDE}


def from_home(distance: float, degrees: int) -> tuple[float, float]:
    """A place in a direction from the free home."""
    cosine, sine = heading_of(degrees)
    return 200.0 + distance * cosine, 200.0 + distance * sine


@pytest.mark.parametrize("around", range(0, 360, 30))
def test_free_home_is_passed_on_the_side_of_the_food_and_left_by_the_shortest_way(around: int) -> None:
    """Whatever the direction: a home against a wall is passed, and left, on its open side."""
    x, y = from_home(-17, around)
    for side in (1, -1):
        food_x, food_y = from_home(83, around + 12 * side)
        raw = placed(OPEN_FLOOR, x=x, y=y, orientation=around, food_x=food_x, food_y=food_y, **FREE_HOME)
        left, right, _, _ = motors_for(B.SEARCH_FOR_FOOD, raw)
        assert (right - left) * side > 0
    x, y = from_home(15, around)
    left, right, _, _ = motors_for(B.AVOID_HOME, placed(OPEN_FLOOR, x=x, y=y, orientation=around, **FREE_HOME))
    assert left == pytest.approx(right), "at the rim and facing out, straight on"
    assert left > 0


# ---------------------------------------------------------------- decisions

SPEEDS = [
    ("search_speed", B.SEARCH_FOR_FOOD, OPEN_FLOOR, 1, 1),
    ("home_speed", B.GO_HOME, OPEN_FLOOR._replace(jaw=126), 1, 1),
    ("push_speed", B.PUSH_FOOD, LOWERED._replace(jaw=126), 1, 1),
    ("orient_speed", B.ORIENT_WITH_FOOD, food_at(19, arm=255), 1, 1),
    ("lowering_speed", B.ORIENT_WITH_FOOD, food_at(14, arm=240), -1, -1),
    ("turn_speed", B.SEARCH_FOR_FOOD, food_at(40, degrees=60), -1, 1),
    ("quick_turn_speed", B.SEARCH_FOR_FOOD, food_at(40, degrees=80), -1, 1),
    ("slow_speed", B.MOVE_SLOWLY, OPEN_FLOOR, 1, 1),
    ("slow_speed", B.AVOID_FOOD, OPEN_FLOOR, -1, -1),
    ("slow_speed", B.AVOID_HOME, placed(OPEN_FLOOR, orientation=180), 1, 1),
    ("slow_speed", B.RELEASE_FOOD, placed(LOWERED, jaw=126, x=91.0), 1, 1),
    ("retreat_speed", B.SEARCH_FOR_FOOD, LOWERED, -1, -1),
    ("retreat_speed", B.ORIENT_WITH_FOOD, food_at(5, arm=255), -1, -1),
    ("retreat_speed", B.AVOID_HOME, OPEN_FLOOR, -1, -1),
    ("retreat_speed", B.RELEASE_FOOD, placed(LOWERED, x=100.0), -1, -1),
]
"""Decision, behaviour, raw data, and the sign of the speed on the left and right wheel."""


@pytest.mark.parametrize(("name", "behaviour", "raw", "left", "right"), SPEEDS)
def test_speed_is_what_the_behaviour_commands(
    name: str, behaviour: Behaviour, raw: RawData, left: int, right: int
) -> None:
    for speed in (4.0, 9.5, 12.0):
        motors = command(behaviour, raw, changed_to(**{name: speed}))
        assert motors[:2] == pytest.approx((left * speed, right * speed))


Rule = Callable[[float, DecisionValues], Any]


def _release(depth: float, decisions: DecisionValues) -> int:
    x = OPEN_FLOOR.home_x - OPEN_FLOOR.home_radius + depth
    return command(B.RELEASE_FOOD, placed(LOWERED, jaw=126, x=x), decisions).jaw


def _orient(distance: float, degrees: float, decisions: DecisionValues) -> Motors:
    return command(B.ORIENT_WITH_FOOD, food_at(distance, degrees, arm=255), decisions)


BOUNDARIES: list[tuple[str, tuple[float, ...], Rule]] = [
    ("back_off_distance", (5, 13, 20), lambda at, d: command(B.SEARCH_FOR_FOOD, food_at(at), d).left < 0),
    ("aimed", (1, 5, 15), lambda degrees, d: _orient(19, degrees, d).left < 0),
    ("astray", (10, 20, 90), lambda degrees, d: _orient(19, degrees, d).arm),
    ("missed_distance", (5, 10, 15), lambda at, d: _orient(at, 0, d).jaw),
    ("release_depth", (0, 7, 15), _release),
]


@pytest.mark.parametrize(("name", "values", "rule"), BOUNDARIES)
def test_decision_moves_the_boundary_of_its_rule(name: str, values: tuple[float, ...], rule: Rule) -> None:
    """One result below the decision's value and another above, wherever the value is."""
    results = set()
    for value in values:
        decisions = changed_to(**{name: value})
        results.add((rule(value - 0.01, decisions), rule(value + 0.01, decisions)))
    ((below, above),) = results
    assert below != above


UNSEEN = placed(OPEN_FLOOR, food_seen=False)
AHEAD: list[Any] = [tuple(200 if k == sensor else 0 for k in range(6)) for sensor in range(1, 5)]
BESIDE_FOOD = food_at(11, proximity=(0, 0, 300, 200, 0, 0))
HOME_BEHIND = placed(OPEN_FLOOR, home_x=10.0, home_y=30.0, jaw=126)
WANDER, OVER = {"search_without_food": "wander"}, {"orienting": "lowered over food"}
AS_IT_IS = {"arm_after_orienting": "as it is"}
COMMANDS: list[tuple[dict[str, Any], Behaviour, RawData, tuple[float, float, int, int]]] = [
    ({}, B.SEARCH_FOR_FOOD, placed(OPEN_FLOOR, proximity=(0, 400, 0, 0, 0, 0)), (16, 0, 215, 200)),  # turns away
    ({}, B.SEARCH_FOR_FOOD, placed(OPEN_FLOOR, proximity=(0, 0, 900, 900, 0, 0)), (-8, -8, 215, 200)),  # is blocked
    *(
        ({"beside_food": how}, behaviour, BESIDE_FOOD, (*wheels, 215, 200))
        for behaviour, speed in ((B.SEARCH_FOR_FOOD, 12), (B.MOVE_SLOWLY, 8))
        for how, wheels in (("back off", (-5, -5)), ("turn away", (16, 0)), ("drive on", (speed, speed)))
    ),
    # Left is the shorter turn, but with a wall there the gripper is kept off it.
    ({}, B.GO_HOME, HOME_BEHIND._replace(wall_distance=60.0, wall_bearing=90.0), (-8, 8, 215, 0)),
    ({}, B.GO_HOME, HOME_BEHIND._replace(wall_distance=10.0, wall_bearing=90.0), (8, -8, 215, 0)),
    *(({"circle_speed": v}, B.SEARCH_FOR_FOOD, UNSEEN, (v - 5, v + 5, 215, 200)) for v in (0.0, 3.0, 5.0)),
    (WANDER, B.SEARCH_FOR_FOOD, UNSEEN, (12, 12, 215, 200)),
    *((WANDER, B.SEARCH_FOR_FOOD, UNSEEN._replace(proximity=near), (-5, 5, 215, 200)) for near in AHEAD),
    (WANDER, B.SEARCH_FOR_FOOD, UNSEEN._replace(wall_distance=20.0, wall_bearing=-50.0), (-5, 5, 215, 200)),
    (WANDER, B.SEARCH_FOR_FOOD, UNSEEN._replace(wall_distance=15.0, wall_bearing=10.0), (-8, -8, 215, 200)),
    ({}, B.ORIENT_WITH_FOOD, food_at(19.5), (0, 0, 255, 200)),  # lowers the arm
    ({}, B.ORIENT_WITH_FOOD, food_at(19.5, arm=255, object_presence=255), (0, 0, 255, 200)),
    ({}, B.ORIENT_WITH_FOOD, food_at(15, arm=255, jaw=100), (-5, -5, 255, 0)),  # a closed jaw marks the missed try
    *((OVER, B.ORIENT_WITH_FOOD, food_at(distance), (0, 0, 255, 200)) for distance in (12, 19)),  # around the food
    (OVER, B.ORIENT_WITH_FOOD, food_at(15, 40), (-5, 5, 215, 200)),  # turns with the arm raised
    (OVER, B.ORIENT_WITH_FOOD, food_at(15, -10), (1, -1, 215, 200)),
    (OVER, B.ORIENT_WITH_FOOD, food_at(15, arm=255), (4, 4, 255, 200)),
    (OVER, B.ORIENT_WITH_FOOD, food_at(15, -10, arm=255), (1, -1, 255, 200)),
    (OVER, B.ORIENT_WITH_FOOD, food_at(15, 40, arm=255), (0, 0, 215, 200)),  # up before it turns that far
    (OVER, B.ORIENT_WITH_FOOD, food_at(11.5, arm=255, object_presence=255), (0, 0, 255, 200)),
    (OVER, B.ORIENT_WITH_FOOD, food_at(9), (-5, -5, 215, 200)),  # too near
    ({}, B.MOVE_SLOWLY, food_at(25, arm=255), (-5, -5, 215, 200)),
    (AS_IT_IS, B.MOVE_SLOWLY, food_at(25, arm=255), (8, 8, 255, 200)),
    (AS_IT_IS, B.MOVE_SLOWLY, food_at(25), (8, 8, 215, 200)),
    (AS_IT_IS, B.SEARCH_FOR_FOOD, food_at(25, arm=255), (-5, -5, 215, 200)),
]


@pytest.mark.parametrize(("changes", "behaviour", "raw", "motors"), COMMANDS)
def test_behaviour_commands_these_motors(
    changes: dict[str, Any], behaviour: Behaviour, raw: RawData, motors: tuple[float, float, int, int]
) -> None:
    assert command(behaviour, raw, changed_to(**changes)) == pytest.approx(motors)
