"""The named readings of `Decisions` as numbers: what rules compare a decision with."""

from dataclasses import fields
from typing import Any

from khepera_forage.task.decision_fields import Field
from khepera_forage.task.decisions import Decisions


def _numbers_of(name: str) -> Any:
    """The numbers of all readings that a decision allows, in their order."""
    (choices,) = (Field.of(field).choices for field in fields(Decisions) if field.name == name)
    return tuple(float(number) for number in range(len(choices)))


NEARER_STATE, FARTHER_STATE = _numbers_of("equal_distance")
SEEN_AT_LAST_PLACE, UNSEEN, UNSEEN_UNTIL_ARM_DOWN = _numbers_of("food_beside_robot")
STRAIGHT, ALONG_PATH = _numbers_of("distances")
DIAGONAL, LAST_DISTANCE = _numbers_of("no_food_distance")
AT_LAST_PLACE, NO_CANDIDATE, IN_GRIPPER, HIDES_ALL_FOOD = _numbers_of("held_food")
SMALL_CIRCLE, WANDER = _numbers_of("search_without_food")
BACK_OFF, TURN_AWAY, DRIVE_ON = _numbers_of("beside_food")
LOWERED_BEFORE_FOOD, LOWERED_OVER_FOOD = _numbers_of("orienting")
RAISED, AS_IT_IS = _numbers_of("arm_after_orienting")
EXACT, FLOATS_32, FLOATS_64 = _numbers_of("distance_arithmetic")
