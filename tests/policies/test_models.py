"""`ModelPolicy` without stable-baselines3: what models of our own are shown, holding, masks and pickling."""

import pickle
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium import spaces
from gymnasium.wrappers import DtypeObservation, FlattenObservation, NormalizeObservation, RescaleObservation

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.policies import ModelPolicy, as_policy, state_vector_of

OBSERVATION = (0, 60, 0, 215, 40)


class Counter:
    """Returns one behaviour after the other, for a batch of one."""

    def __init__(self) -> None:
        self.shown: list[Any] = []

    def predict(self, observation: Any, *, deterministic: bool) -> tuple[Any, None]:
        self.shown.append(observation)
        return np.array([len(self.shown) % 10]), None


def test_action_holds_for_its_rounds_and_its_generator() -> None:
    policy = ModelPolicy(Counter(), hold=3)
    first, second = np.random.default_rng(0), np.random.default_rng(0)
    assert [int(policy.act(OBSERVATION, first)) for _ in range(5)] == [1, 1, 1, 2, 2]
    assert [int(policy.act(OBSERVATION, second)) for _ in range(2)] == [3, 3]
    assert int(policy.act(OBSERVATION, first)) == 4, "another generator means another episode"


def test_sampling_without_a_generator_is_refused() -> None:
    with pytest.raises(
        TypeError, match=r"rng is None; allowed: a numpy\.random\.Generator, to draw actions from"
    ):
        ModelPolicy(Counter(), sample=True).act(OBSERVATION)


class Recurrent:
    """Counts its own steps in its state, as a recurrent model of sb3-contrib carries its memory."""

    def predict(
        self, observation: Any, state: Any = None, episode_start: Any = None, deterministic: bool = False
    ) -> tuple[Any, Any]:
        assert episode_start.shape == (1,)
        count = 0 if episode_start[0] else state[0] + 1
        return np.array([count]), (count,)


def test_recurrent_model_remembers_within_an_episode_and_forgets_after_it() -> None:
    policy = ModelPolicy(Recurrent())
    first, second = np.random.default_rng(0), np.random.default_rng(0)
    assert [int(policy.act(OBSERVATION, first)) for _ in range(4)] == [0, 1, 2, 3]
    assert [int(policy.act(OBSERVATION, second)) for _ in range(3)] == [0, 1, 2]
    assert int(pickle.loads(pickle.dumps(policy)).act(OBSERVATION, second)) == 0
    with pytest.raises(TypeError, match="rng is None; allowed for a recurrent model"):
        policy.act(OBSERVATION)


class Masked:
    """A model like sb3-contrib's MaskablePPO: it prefers the last behaviour that its mask allows."""

    def predict(
        self, observation: Any, deterministic: bool = False, action_masks: Any = None
    ) -> tuple[Any, None]:
        return np.flatnonzero(action_masks)[-1:], None


@pytest.mark.parametrize(
    ("presence", "food_type", "behaviour"), [(0, 0, 8), (1, 0, 9), (1, 1, 9), (1, 2, 9), (1, 3, 9)]
)
def test_masked_model_gets_the_masks_of_the_environment(
    presence: int, food_type: int, behaviour: int
) -> None:
    assert ModelPolicy(Masked()).act((presence, 90, food_type, 215, 60)) == behaviour


class Model:
    """A model that notes what it is shown."""

    def __init__(self, space: spaces.Space[Any]) -> None:
        self.observation_space = space
        self.shown: list[Any] = []

    def predict(self, observation: Any, *, deterministic: bool) -> tuple[Any, None]:
        self.shown.append(observation)
        return np.array([0]), None


@pytest.mark.filterwarnings("ignore:.*Box (low|high)'s precision lowered")
@pytest.mark.parametrize("name", ["Corridor", "CorridorWheels"])
def test_model_is_shown_the_observations_that_its_space_has(name: str) -> None:
    env = gym.make(f"khepera_forage/{name}-v1")
    flat = FlattenObservation(env)
    shown, _ = env.reset(seed=3)
    row, _ = flat.reset(seed=3)
    for space, expected in (
        (env.observation_space, shown),
        (flat.observation_space, row),
        (DtypeObservation(flat, np.float32).observation_space, row),
    ):
        model = Model(space)
        as_policy(model).act(shown)
        np.testing.assert_equal(model.shown[0], expected)
    if name == "Corridor":
        as_policy(model).act([*state_vector_of(shown), 10, 0])
        np.testing.assert_equal(model.shown[1], row)


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
