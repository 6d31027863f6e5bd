"""`make_vec` on compiled worlds with wrappers: of vector environments, and of single ones."""

from functools import partial
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.wrappers.vector import RecordEpisodeStatistics

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.wrappers import HoldAction, HoldVectorAction

pytest.importorskip("numba")
NAME, WORLDS, LIMIT = "khepera_forage/Corridor-v1", 4, 40


def made(**kwargs: Any) -> Any:
    return gym.make_vec(NAME, num_envs=WORLDS, limit=LIMIT, **kwargs)


def test_vector_wrappers_are_applied_from_the_innermost() -> None:
    hold = partial(HoldVectorAction, rounds=3)
    env = made(autoreset_mode="SameStep", vector_wrappers=[hold, RecordEpisodeStatistics])
    assert isinstance(env, RecordEpisodeStatistics)
    assert env.unwrapped.backend == "compiled"  # type: ignore[attr-defined]
    plain = HoldVectorAction(made(autoreset_mode="SameStep"), rounds=3)
    actions = np.zeros(WORLDS, np.int64)
    env.reset(seed=3)
    plain.reset(seed=3)
    for _ in range(-(-LIMIT // 3)):
        shown, rewards, _, truncated, info = env.step(actions)
        plain_shown, plain_rewards, *_ = plain.step(actions)
        np.testing.assert_array_equal(rewards, plain_rewards)
        np.testing.assert_array_equal(shown["robot_home_distance"], plain_shown["robot_home_distance"])
    assert truncated.all()
    assert info["episode"]["l"].tolist() == [-(-LIMIT // 3)] * WORLDS


def test_environment_with_vector_wrappers_is_made_again_from_its_spec() -> None:
    env = made(autoreset_mode="SameStep", vector_wrappers=[HoldVectorAction])
    again = gym.make_vec(env.unwrapped.spec)
    assert isinstance(again, HoldVectorAction)
    assert again.num_envs == WORLDS


def test_wrong_vector_wrapper_is_named() -> None:
    with pytest.raises(ValueError, match=r"allowed: a single environment \(HoldVectorAction is for many\)"):
        made(vector_wrappers=[HoldAction])
    with pytest.raises(ValueError, match=r"vector_wrappers has <.*>, which returns None; allowed: functions"):
        made(vector_wrappers=[lambda env: None])
