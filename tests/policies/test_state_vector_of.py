"""All kinds of observations give the same state vector of five plain integers."""

from types import MappingProxyType
from typing import Any

import numpy as np
import pytest

from khepera_forage.policies import Observation, state_vector_of
from khepera_forage.task.states import StateVector

VECTOR = StateVector(1, 52, 2, 215, 28)

OBSERVATIONS: dict[str, Observation] = {
    "recall": {
        "object_presence": np.int64(1),
        "robot_home_distance": np.array([52], np.int32),
        "food_type": np.int64(2),
        "arms_height": np.array([215], np.int64),
        "robot_food_distance": np.array([28], np.int32),
    },
    "integers": VECTOR._asdict(),
    "0-d arrays": {name: np.array(value) for name, value in VECTOR._asdict().items()},
    "other mapping": MappingProxyType(VECTOR._asdict()),
    "training": np.array([*VECTOR, 10, 0], np.int32),
    "bytes": np.array(VECTOR, np.uint8),
    "five numbers": list(VECTOR),
    "seven NumPy numbers": tuple(np.array([*VECTOR, 10, 0])),
    "state vector": VECTOR,
}


@pytest.mark.parametrize("kind", OBSERVATIONS)
def test_state_vector_is_found_in_every_kind_of_observation(kind: str) -> None:
    vector = state_vector_of(OBSERVATIONS[kind])
    assert vector == VECTOR
    assert isinstance(vector, StateVector)
    assert {type(value) for value in vector} == {int}


WITHOUT_ARM = {name: value for name, value in VECTOR._asdict().items() if name != "arms_height"}

BAD: list[tuple[Any, str]] = [
    (
        WITHOUT_ARM,
        "observation lacks 'arms_height', it has .*'robot_food_distance'.*; needed: object_presence, ",
    ),
    ([1, 52, 2], "observation has 3 values; allowed: at least 5"),
    (np.array([VECTOR]), r"observation has shape \(1, 5\); allowed: one dimension"),
    ([1, 52.5, 2, 215, 28], r"observation has the values \(1, 52.5, .*; allowed: one integer each"),
    ({**VECTOR._asdict(), "food_type": "PUSHABLE"}, "'PUSHABLE'.*; allowed: one integer each"),
    ({**VECTOR._asdict(), "arms_height": np.array([215, 216])}, "215, 216.*; allowed: one integer each"),
    (52, "observation is 52; allowed: a mapping, a sequence or an array"),
]


@pytest.mark.parametrize(("observation", "message"), BAD)
def test_observation_without_a_state_vector_is_refused_with_its_value(observation: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        state_vector_of(observation)
