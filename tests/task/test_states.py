"""The decision tree of figure 4.2 against table 4.2, which is written out here from the thesis."""

from collections.abc import Callable
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.robots.khepera import ARM_RAISED
from khepera_forage.task.decisions import DEFAULT_VALUES, DecisionValues
from khepera_forage.task.states import (
    Behaviour,
    FoodType,
    State,
    StateVector,
    behaviour_for,
    classify,
    is_raised,
)
from tests.version_0_1 import V0_1, VALUES

HOME_RADIUS = 20
NEXT_TO_FOOD, CLOSE_TO_FOOD = int(VALUES.next_to_food), int(VALUES.close_to_food)
HIGHEST_RAISED_ARM = ARM_RAISED + int(VALUES.carry_margin)
FARTHER_STATE = replace(V0_1, equal_distance="farther state").values()

Row = Callable[[StateVector], bool]


def table_4_2(decisions: DecisionValues) -> dict[State, Row]:
    """The rows of the table, with the thresholds of some decisions."""
    next_to_food, close_to_food = decisions.next_to_food, decisions.close_to_food
    highest_raised_arm = ARM_RAISED + decisions.carry_margin
    return {
        State.SEARCH: lambda v: (
            not v.object_presence
            and v.robot_home_distance > HOME_RADIUS
            and v.robot_food_distance > close_to_food
        ),
        State.CLOSE_TO_FOOD: lambda v: (
            not v.object_presence
            and v.robot_home_distance > HOME_RADIUS
            and v.robot_food_distance > next_to_food
            and v.robot_food_distance < close_to_food
        ),
        State.NEXT_TO_FOOD: lambda v: (
            not v.object_presence
            and v.robot_home_distance > HOME_RADIUS
            and v.robot_food_distance < next_to_food
            and v.food_type == FoodType.UNKNOWN
        ),
        State.ORIENTED_WITH_FOOD: lambda v: (
            bool(v.object_presence)
            and v.robot_home_distance > HOME_RADIUS
            and v.food_type == FoodType.UNKNOWN
        ),
        # The table omits the arm here, which alone separates this row from FOOD IN HAND.
        State.READY_TO_PICK_UP_FOOD: lambda v: (
            bool(v.object_presence)
            and v.robot_home_distance > HOME_RADIUS
            and v.food_type == FoodType.PICKABLE
            and v.arms_height > highest_raised_arm
        ),
        State.READY_TO_PUSH_FOOD: lambda v: (
            bool(v.object_presence)
            and v.robot_home_distance > HOME_RADIUS
            and v.food_type == FoodType.PUSHABLE
        ),
        State.MUST_AVOID_FOOD: lambda v: (
            bool(v.object_presence)
            and v.robot_home_distance > HOME_RADIUS
            and v.food_type == FoodType.POISONOUS
        ),
        State.FOOD_IN_HAND: lambda v: (
            bool(v.object_presence)
            and v.robot_home_distance > HOME_RADIUS
            and v.food_type == FoodType.PICKABLE
            and v.arms_height <= highest_raised_arm
        ),
        State.AT_HOME_NO_FOOD: lambda v: not v.object_presence and v.robot_home_distance < HOME_RADIUS,
        State.AT_HOME_WITH_FOOD: lambda v: bool(v.object_presence) and v.robot_home_distance < HOME_RADIUS,
    }


VECTORS = st.builds(
    StateVector,
    object_presence=st.integers(0, 1),
    robot_home_distance=st.integers(0, 60) | st.sampled_from((HOME_RADIUS - 1, HOME_RADIUS, HOME_RADIUS + 1)),
    food_type=st.integers(0, 3),
    arms_height=st.integers(215, 255) | st.sampled_from((HIGHEST_RAISED_ARM, HIGHEST_RAISED_ARM + 1)),
    robot_food_distance=st.integers(0, 60)
    | st.sampled_from((NEXT_TO_FOOD - 1, NEXT_TO_FOOD, NEXT_TO_FOOD + 1, CLOSE_TO_FOOD, CLOSE_TO_FOOD + 1)),
)


def perceivable(vector: StateVector) -> bool:
    """FoodType reads UNKNOWN unless an object is present."""
    return bool(vector.object_presence) or vector.food_type == FoodType.UNKNOWN


@pytest.mark.parametrize("decisions", [VALUES, DEFAULT_VALUES], ids=["v0.1", "default"])
@given(VECTORS.filter(perceivable))
def test_classify_agrees_with_every_row_of_table_4_2_and_rows_exclude_each_other(
    decisions: DecisionValues, vector: StateVector
) -> None:
    rows = [state for state, row in table_4_2(decisions).items() if row(vector)]
    assert len(rows) <= 1
    if rows:
        assert classify(vector, HOME_RADIUS, decisions) == rows[0]


@given(VECTORS.filter(perceivable))
def test_classify_gives_the_nearer_state_where_equal_distances_match_no_row(vector: StateVector) -> None:
    if any(row(vector) for row in table_4_2(VALUES).values()):
        return
    home, food = vector.robot_home_distance, vector.robot_food_distance
    assert home == HOME_RADIUS or food in (NEXT_TO_FOOD, CLOSE_TO_FOOD)
    if home == HOME_RADIUS:
        nearer = vector._replace(robot_home_distance=home - 1)
    else:
        nearer = vector._replace(robot_food_distance=food - 1)
    assert classify(vector, HOME_RADIUS, VALUES) == classify(nearer, HOME_RADIUS, VALUES)


@pytest.mark.parametrize(
    ("vector", "state"),
    [
        (StateVector(0, HOME_RADIUS, 0, 215, 50), State.AT_HOME_NO_FOOD),
        (StateVector(1, HOME_RADIUS, 1, 215, 50), State.AT_HOME_WITH_FOOD),
        (StateVector(0, HOME_RADIUS + 1, 0, 215, NEXT_TO_FOOD), State.NEXT_TO_FOOD),
        (StateVector(0, HOME_RADIUS + 1, 0, 215, NEXT_TO_FOOD + 1), State.CLOSE_TO_FOOD),
        (StateVector(0, HOME_RADIUS + 1, 0, 215, CLOSE_TO_FOOD), State.CLOSE_TO_FOOD),
        (StateVector(0, HOME_RADIUS + 1, 0, 215, CLOSE_TO_FOOD + 1), State.SEARCH),
        (StateVector(1, HOME_RADIUS + 1, 1, HIGHEST_RAISED_ARM, 9), State.FOOD_IN_HAND),
        (StateVector(1, HOME_RADIUS + 1, 1, HIGHEST_RAISED_ARM + 1, 9), State.READY_TO_PICK_UP_FOOD),
    ],
)
def test_classify_gives_the_nearer_state_at_each_threshold(vector: StateVector, state: State) -> None:
    assert classify(vector, HOME_RADIUS, VALUES) == state


@given(VECTORS.filter(perceivable))
def test_classify_with_farther_state_differs_only_at_equal_distances(vector: StateVector) -> None:
    home, food = vector.robot_home_distance, vector.robot_food_distance
    if home == HOME_RADIUS:
        vector = vector._replace(robot_home_distance=home + 1)
    if food in (NEXT_TO_FOOD, CLOSE_TO_FOOD):
        vector = vector._replace(robot_food_distance=food + 1)
    expected = classify(vector, HOME_RADIUS, VALUES)
    original = vector._replace(robot_home_distance=home, robot_food_distance=food)
    assert classify(original, HOME_RADIUS, FARTHER_STATE) == expected


def test_is_raised_holds_up_to_the_carry_margin() -> None:
    assert is_raised(ARM_RAISED, VALUES)
    assert is_raised(HIGHEST_RAISED_ARM, VALUES)
    assert not is_raised(HIGHEST_RAISED_ARM + 1, VALUES)


@given(VECTORS)
def test_classify_never_gives_the_unknown_state(vector: StateVector) -> None:
    assert classify(vector, HOME_RADIUS, DEFAULT_VALUES) != State.UNKNOWN


def test_classify_gives_every_other_state() -> None:
    between = (DEFAULT_VALUES.next_to_food + DEFAULT_VALUES.close_to_food) // 2
    reached = {
        classify(StateVector(presence, home, food_type, arm, food), HOME_RADIUS, DEFAULT_VALUES)
        for presence in (0, 1)
        for home in (5, 50)
        for food_type in range(4)
        for arm in (215, 255)
        for food in (9, int(between), 61)
    }
    assert reached == set(State) - {State.UNKNOWN}


@pytest.mark.parametrize(
    ("state", "behaviour"),
    [
        (State.SEARCH, "SEARCH_FOR_FOOD"),
        (State.CLOSE_TO_FOOD, "MOVE_SLOWLY"),
        (State.NEXT_TO_FOOD, "ORIENT_WITH_FOOD"),
        (State.ORIENTED_WITH_FOOD, "EXPLORE_FOOD"),
        (State.READY_TO_PICK_UP_FOOD, "PICK_UP_FOOD"),
        (State.READY_TO_PUSH_FOOD, "PUSH_FOOD"),
        (State.MUST_AVOID_FOOD, "AVOID_FOOD"),
        (State.FOOD_IN_HAND, "GO_HOME"),
        (State.AT_HOME_NO_FOOD, "AVOID_HOME"),
        (State.AT_HOME_WITH_FOOD, "RELEASE_FOOD"),
    ],
)
def test_behaviour_for_a_state_is_that_of_table_4_1(state: State, behaviour: str) -> None:
    assert behaviour_for(state).name == behaviour
    assert int(state) == int(Behaviour[behaviour])
