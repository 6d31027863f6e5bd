"""`ModelPolicy` without stable-baselines3: features, holding, motors and pickling, with models of our own."""

import pickle
from typing import Any

import numpy as np
import pytest

from khepera_forage.policies import ModelPolicy

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
