"""State vectors, states and behaviours, and the teacher's decision tree (sections 4.2.1, 4.3, 4.4)."""

from enum import IntEnum
from numbers import Integral
from typing import Any, NamedTuple

from khepera_forage.robots.khepera import ARM_RAISED
from khepera_forage.task.decisions import FARTHER_STATE, DecisionValues


class FoodType(IntEnum):
    """What a food object turns out to be (4.2.3)."""

    UNKNOWN = 0
    PICKABLE = 1
    PUSHABLE = 2
    POISONOUS = 3


class State(IntEnum):
    """The ten states, in the order of table 4.1, and the one that never occurs (4.4)."""

    SEARCH = 0
    CLOSE_TO_FOOD = 1
    NEXT_TO_FOOD = 2
    ORIENTED_WITH_FOOD = 3
    READY_TO_PICK_UP_FOOD = 4
    READY_TO_PUSH_FOOD = 5
    MUST_AVOID_FOOD = 6
    FOOD_IN_HAND = 7
    AT_HOME_NO_FOOD = 8
    AT_HOME_WITH_FOOD = 9
    UNKNOWN = 10


class Behaviour(IntEnum):
    """The ten behaviours, in the order of table 4.1, and standing still (which heard means silence)."""

    SEARCH_FOR_FOOD = 0
    MOVE_SLOWLY = 1
    ORIENT_WITH_FOOD = 2
    EXPLORE_FOOD = 3
    PICK_UP_FOOD = 4
    PUSH_FOOD = 5
    AVOID_FOOD = 6
    GO_HOME = 7
    AVOID_HOME = 8
    RELEASE_FOOD = 9
    WAIT = 10


_LESS = 1e-6  # pixels
# Members of the enums that the tree looks up at every step: looking them up in an enum takes half its time.
_UNIDENTIFIED, _PICKABLE, _PUSHABLE, _POISONOUS = (food_type.value for food_type in FoodType)
(
    _SEARCH,
    _CLOSE_TO_FOOD,
    _NEXT_TO_FOOD,
    _ORIENTED_WITH_FOOD,
    _READY_TO_PICK_UP_FOOD,
    _READY_TO_PUSH_FOOD,
    _MUST_AVOID_FOOD,
    _FOOD_IN_HAND,
    _AT_HOME_NO_FOOD,
    _AT_HOME_WITH_FOOD,
    _UNKNOWN,
) = State
NUM_STATES = State.UNKNOWN.value
"""How many states there are that occur."""
NUM_BEHAVIOURS = Behaviour.WAIT.value
"""How many behaviours there are but WAIT."""
BEHAVIOURS = tuple(Behaviour)
"""Behaviours by number: this lookup is ten times as fast as calling the enum."""


class StateVector(NamedTuple):
    """The five attributes of section 4.3; distances in whole pixels of 5 mm.

    Attributes:
        object_presence: 1 while the optical barrier is interrupted, otherwise 0.
        robot_home_distance: From the robot to the centre of its home.
        food_type: A `FoodType`; UNKNOWN unless an object is present.
        arms_height: 255 (down) to 215 (raised).
        robot_food_distance: To the nearest candidate food; if there is none, see `Decisions.no_food_distance`.
    """

    object_presence: int
    robot_home_distance: int
    food_type: int
    arms_height: int
    robot_food_distance: int


def classify(vector: StateVector, home_radius: float, decisions: DecisionValues) -> State:
    """The state that a state vector stands for: the tree of figure 4.2.

    Args:
        vector: What is perceived now.
        home_radius: In pixels.
        decisions: `DecisionValues`.
    """
    presence, home, food_type, arm, food = vector
    # Distances are whole pixels: just below a threshold, those equal to it belong to the farther state.
    less = _LESS if decisions.equal_distance == FARTHER_STATE else 0.0
    at_home = home <= home_radius - less
    if presence:
        if at_home:
            return _AT_HOME_WITH_FOOD
        if food_type == _UNIDENTIFIED:
            return _ORIENTED_WITH_FOOD
        if food_type == _POISONOUS:
            return _MUST_AVOID_FOOD
        if food_type == _PUSHABLE:
            return _READY_TO_PUSH_FOOD
        if food_type == _PICKABLE:
            return _FOOD_IN_HAND if is_raised(arm, decisions) else _READY_TO_PICK_UP_FOOD
        return _UNKNOWN
    if at_home:
        return _AT_HOME_NO_FOOD
    if food <= decisions.next_to_food - less:
        return _NEXT_TO_FOOD
    if food <= decisions.close_to_food - less:
        return _CLOSE_TO_FOOD
    return _SEARCH


def is_raised(arm: int, decisions: DecisionValues) -> bool:
    """Whether an arm counts as raised (figure 4.2: up to PickUpHeight + 10)."""
    raised: bool = arm <= ARM_RAISED + decisions.carry_margin
    return raised


def behaviour_for(state: State) -> Behaviour:
    """The IF-THEN rules of 4.4.1: states and behaviours correspond one to one, in the order of table 4.1."""
    return BEHAVIOURS[state]


def behaviour_number(action: Any, count: int = NUM_BEHAVIOURS + 1, who: str = "") -> int:
    """An action as a behaviour number.

    Args:
        action: A whole number of Python or NumPy, or an array that holds one.
        count: Of behaviours allowed, 10 without WAIT.
        who: Whose action, for the message.

    Raises:
        ValueError: Not a whole number in 0..count-1.
    """
    if type(action) in (int, Behaviour) and 0 <= action < count:  # nearly always, and the quickest to tell
        return int(action)
    value = action.item() if getattr(action, "size", 0) == 1 else action
    if isinstance(value, Integral) and not isinstance(value, bool) and 0 <= int(value) < count:
        return int(value)
    of_whom = f" of {who}" if who else ""
    raise ValueError(
        f"action{of_whom} is {action!r}; allowed: a whole number from 0 to {count - 1}, one behaviour each"
    )
