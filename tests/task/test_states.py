"""The decision tree of figure 4.2 against table 4.2, which is written out here from the thesis."""

import operator

from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.robots.khepera import ARM_RAISED
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.states import Behaviour, FoodType, State, StateVector, behaviour_for, classify

HOME_RADIUS = 20
DECISIONS = st.sampled_from([Decisions.v0_1(), Decisions()]) | st.builds(
    Decisions,
    next_to_food=st.integers(10, 20),
    close_to_food=st.integers(20, 60),
    carry_margin=st.integers(0, 30),
    equal_distance=st.sampled_from(("nearer state", "farther state")),
)


def rows_of_table_4_2(v: StateVector, decisions: Decisions) -> list[State]:
    """The rows that a state vector matches; equal distances, of which the table says nothing, are as decided."""
    within = operator.le if decisions.equal_distance == "nearer state" else operator.lt
    present, at_home = bool(v.object_presence), within(v.robot_home_distance, HOME_RADIUS)
    next_to = within(v.robot_food_distance, decisions.next_to_food)
    close_to = within(v.robot_food_distance, decisions.close_to_food)
    raised = v.arms_height <= ARM_RAISED + decisions.carry_margin
    rows = {
        State.SEARCH: not present and not at_home and not close_to,
        State.CLOSE_TO_FOOD: not present and not at_home and close_to and not next_to,
        State.NEXT_TO_FOOD: not present and not at_home and next_to,
        State.ORIENTED_WITH_FOOD: present and not at_home and v.food_type == FoodType.UNKNOWN,
        # The table omits the arm here, which alone separates this row from FOOD IN HAND.
        State.READY_TO_PICK_UP_FOOD: present and not at_home and v.food_type == FoodType.PICKABLE and not raised,
        State.READY_TO_PUSH_FOOD: present and not at_home and v.food_type == FoodType.PUSHABLE,
        State.MUST_AVOID_FOOD: present and not at_home and v.food_type == FoodType.POISONOUS,
        State.FOOD_IN_HAND: present and not at_home and v.food_type == FoodType.PICKABLE and raised,
        State.AT_HOME_NO_FOOD: not present and at_home,
        State.AT_HOME_WITH_FOOD: present and at_home,
    }
    return [state for state, matches in rows.items() if matches]


@given(decisions=DECISIONS, data=st.data())
def test_classify_gives_the_one_row_of_table_4_2(decisions: Decisions, data: st.DataObject) -> None:
    thresholds = [int(threshold) for threshold in (decisions.next_to_food, decisions.close_to_food)]
    highest = ARM_RAISED + int(decisions.carry_margin)
    presence = data.draw(st.booleans())
    vector = StateVector(
        int(presence),
        data.draw(st.integers(0, 60) | st.sampled_from([HOME_RADIUS - 1, HOME_RADIUS, HOME_RADIUS + 1])),
        data.draw(st.integers(0, 3)) if presence else 0,
        data.draw(st.integers(215, 255) | st.sampled_from([highest, highest + 1])),
        data.draw(st.integers(0, 70) | st.sampled_from([t + d for t in thresholds for d in (-1, 0, 1)])),
    )
    assert [classify(vector, HOME_RADIUS, decisions.values())] == rows_of_table_4_2(vector, decisions)


def test_states_and_their_behaviours_are_those_of_table_4_1() -> None:
    table = [
        (State.SEARCH, Behaviour.SEARCH_FOR_FOOD),
        (State.CLOSE_TO_FOOD, Behaviour.MOVE_SLOWLY),
        (State.NEXT_TO_FOOD, Behaviour.ORIENT_WITH_FOOD),
        (State.ORIENTED_WITH_FOOD, Behaviour.EXPLORE_FOOD),
        (State.READY_TO_PICK_UP_FOOD, Behaviour.PICK_UP_FOOD),
        (State.READY_TO_PUSH_FOOD, Behaviour.PUSH_FOOD),
        (State.MUST_AVOID_FOOD, Behaviour.AVOID_FOOD),
        (State.FOOD_IN_HAND, Behaviour.GO_HOME),
        (State.AT_HOME_NO_FOOD, Behaviour.AVOID_HOME),
        (State.AT_HOME_WITH_FOOD, Behaviour.RELEASE_FOOD),
    ]
    assert [(State(number), behaviour_for(State(number))) for number in range(10)] == table
    assert [int(behaviour) for _, behaviour in table] == list(range(10))
