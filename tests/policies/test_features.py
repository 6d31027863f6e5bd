"""What is found in observations: state vectors, and features of one and of many at a time."""

from types import MappingProxyType
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from khepera_forage.policies import Observation, state_vector_of
from khepera_forage.policies.features import BEHAVIOUR_FEATURES, WHEELS_FEATURES, behaviour_features, wheels_features
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
    "other mapping": MappingProxyType(VECTOR._asdict()),
    "training": np.array([*VECTOR, 10, 0], np.int32),
    "five numbers": list(VECTOR),
    "seven NumPy numbers": tuple(np.array([*VECTOR, 10, 0])),
}


@pytest.mark.parametrize("kind", OBSERVATIONS)
def test_state_vector_is_found_in_every_kind_of_observation(kind: str) -> None:
    vector = state_vector_of(OBSERVATIONS[kind])
    assert vector == VECTOR
    assert isinstance(vector, StateVector)
    assert {type(value) for value in vector} == {int}


BAD: list[tuple[Any, str]] = [
    ({"food_type": 0}, r"observation lacks 'object_presence', it has \['food_type'\]; needed: object_presence, "),
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


@pytest.mark.parametrize(
    ("name", "features", "width"),
    [("Corridor", behaviour_features, BEHAVIOUR_FEATURES), ("CorridorWheels", wheels_features, WHEELS_FEATURES)],
)
def test_features_of_many_equal_features_one_by_one(name: str, features: Any, width: int) -> None:
    env = gym.make_vec(f"khepera_forage:khepera_forage/{name}-v1", num_envs=3, vectorization_mode="sync")
    shown, _ = env.reset(seed=4)
    env.action_space.seed(4)
    for _ in range(20):
        rows = features(shown)
        assert rows.shape == (3, width)
        assert rows.dtype == np.float32
        assert np.abs(rows).max() < 2
        for i, row in enumerate(rows):
            np.testing.assert_array_equal(features({key: values[i] for key, values in shown.items()})[0], row)
        shown, *_ = env.step(env.action_space.sample())
    env.close()


def test_places_are_relative_to_the_robot() -> None:
    env = gym.make("khepera_forage:khepera_forage/CorridorWheels-v1")
    shown, _ = env.reset(seed=1)
    told = {**shown, "pose": np.array((100.0, 50.0, 90.0)), "food": np.array((100.0, 80.0)), "food_seen": np.int64(1)}
    told |= {"home": np.array((90.0, 50.0, 20.0)), "wall": np.array((13.8, 90.0))}
    row = wheels_features(told)[0]
    np.testing.assert_allclose(row[15:18] * 138, (30, 0, 30), atol=1e-4)  # straight ahead
    np.testing.assert_allclose(row[18:21] * 138, (0, 10, 10), atol=1e-4)  # to the left
    np.testing.assert_allclose(row[21:], (0.1, 0, 1, 1), atol=1e-6)
    unseen = wheels_features({**told, "food_seen": np.int64(0)})[0]
    assert not unseen[15:18].any()
    env.close()


def test_missing_part_of_an_observation_is_named() -> None:
    with pytest.raises(ValueError, match=r"observation lacks 'robot_home_distance', it has \['object_presence'\]"):
        behaviour_features({"object_presence": np.int64(0)})
