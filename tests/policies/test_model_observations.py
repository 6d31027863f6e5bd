"""Models are shown observations in the form of the space that they were trained on."""

from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import spaces
from gymnasium.wrappers import DtypeObservation, FlattenObservation, NormalizeObservation, RescaleObservation

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.policies import as_policy
from khepera_forage.policies.model_observations import flattened

NAMES = ("Corridor", "CorridorWheels", "RectangleWheels")


class Model:
    """A model that notes what it is shown."""

    def __init__(self, space: spaces.Space[Any]) -> None:
        self.observation_space = space
        self.shown: list[Any] = []

    def predict(self, observation: Any, *, deterministic: bool) -> tuple[Any, None]:
        self.shown.append(observation)
        return np.array([0]), None


@pytest.mark.parametrize("name", NAMES)
def test_flattened_observations_are_those_of_gymnasium(name: str) -> None:
    env = gym.make(f"khepera_forage/{name}-v1")
    other = FlattenObservation(gym.make(f"khepera_forage/{name}-v1"))
    env.action_space.seed(0)
    shown, expected = env.reset(seed=3)[0], other.reset(seed=3)[0]
    for _ in range(30):
        row = flattened(shown)
        np.testing.assert_array_equal(row, expected)
        assert other.observation_space.contains(row)
        action = env.action_space.sample()
        shown, expected = env.step(action)[0], other.step(action)[0]


@pytest.mark.filterwarnings("ignore:.*Box (low|high)'s precision lowered")
@pytest.mark.parametrize("name", NAMES)
def test_model_is_shown_the_observations_that_its_space_has(name: str) -> None:
    env = gym.make(f"khepera_forage/{name}-v1")
    shown, _ = env.reset(seed=3)
    flat = FlattenObservation(env)
    for space, expected in (
        (env.observation_space, shown),
        (flat.observation_space, flattened(shown)),
        (DtypeObservation(flat, np.float32).observation_space, flattened(shown)),
    ):
        model = Model(space)
        as_policy(model).act(shown)
        np.testing.assert_equal(model.shown[0], expected)


CORRIDOR: Any = FlattenObservation(gym.make("khepera_forage/Corridor-v1"))
AS_FLOATS = DtypeObservation(CORRIDOR, np.float32)


@pytest.mark.parametrize(
    "space",
    [
        RescaleObservation(AS_FLOATS, np.float32(0), np.float32(1)).observation_space,
        NormalizeObservation(CORRIDOR).observation_space,
        spaces.Box(-np.inf, np.inf, (9,), np.float32),
        spaces.Box(-np.inf, np.inf, (25,), np.float32),
        spaces.Box(0, 138, (9,), np.float32),
        spaces.Box(0, 255, (84, 84, 3), np.uint8),
        spaces.Box(0, 138, (7,), np.int64),
        spaces.Discrete(10),
        spaces.Dict(arms_height=spaces.Box(215, 255, (1,), np.int64)),
        spaces.Dict({**CORRIDOR.unwrapped.observation_space, "more": spaces.Discrete(2)}),
    ],
    ids=str,
)
def test_other_spaces_are_refused(space: spaces.Space[Any]) -> None:
    with pytest.raises(ValueError, match=r"model was trained on observations .*; allowed: .*ModelPolicy\("):
        as_policy(Model(space))
