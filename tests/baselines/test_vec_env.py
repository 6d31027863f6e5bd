"""The adapter for vector environments: the same as the environment behind it, in the form of stable-baselines3."""

from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from stable_baselines3 import PPO
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import VecNormalize

from khepera_forage.policies import ModelPolicy
from khepera_forage.policies.features import behaviour_features, wheels_features
from khepera_forage.rollouts.recall import recall, recall_env
from khepera_forage.rollouts.reinforcement import COMPILED_MODE, recall_envs
from khepera_forage.rollouts.sb3_vector_env import VecEnvAdapter
from khepera_forage.wrappers import VectorActionRepeat

WORLDS, LIMIT = 5, 40
MODES = ["sync", COMPILED_MODE]


def vector_env(mode: str, wheels: bool = False, worlds: int = WORLDS) -> gym.vector.VectorEnv[Any, Any, Any]:
    return recall_envs("corridor", wheels, mode, limit=LIMIT)(worlds)


def adapter(mode: str, wheels: bool = False, worlds: int = WORLDS, hold: int = 1) -> Any:
    features = wheels_features if wheels else behaviour_features
    return VecEnvAdapter(vector_env(mode, wheels, worlds), features, hold)


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize(("wheels", "hold"), [(False, 1), (True, 1), (False, 3)])
def test_adapter_equals_the_vector_environment(mode: str, wheels: bool, hold: int) -> None:
    features = wheels_features if wheels else behaviour_features
    env, other = adapter(mode, wheels, hold=hold), vector_env(mode, wheels)
    other = VectorActionRepeat(other, hold) if hold > 1 else other
    assert env.seed(3) == [3, 4, 5, 6, 7]
    rows = env.reset()
    shown, info = other.reset(seed=3)
    rng, total = np.random.default_rng(0), np.zeros(WORLDS)
    ends = 0
    for _ in range(3 * LIMIT):
        np.testing.assert_array_equal(rows, features(shown))
        assert env.observation_space.contains(rows[0])
        if wheels:
            actions = rng.uniform(-1.0, 1.0, (WORLDS, 4)).astype(np.float32)
        else:
            actions = np.where(rng.random(WORLDS) < 0.1, 0, info["state"])
        rows, rewards, ended, infos = env.step(actions)
        shown, more, terminated, truncated, info = other.step(actions)
        np.testing.assert_array_equal(rewards, more.astype(np.float32))
        np.testing.assert_array_equal(ended, terminated | truncated)
        total += more
        for i in range(WORLDS):
            if not ended[i]:
                assert infos[i] == {}
                continue
            ends += 1
            last = features(info["final_obs"][i])[0]
            np.testing.assert_array_equal(infos[i]["terminal_observation"], last)
            assert infos[i]["TimeLimit.truncated"] == truncated[i]
            for name in ("score", "correct", "steps", "delivered", "poison_home"):
                assert infos[i][name] == info["final_info"][name][i]
            assert infos[i]["is_success"] == terminated[i] == (infos[i]["delivered"] == 1)
            assert infos[i]["episode"]["r"] == pytest.approx(total[i])
            assert infos[i]["episode"]["l"] == infos[i]["steps"]
            total[i] = 0.0
    assert ends >= 3 * WORLDS
    env.close()
    other.close()


def test_make_vec_is_one_line_from_a_trained_and_recalled_model() -> None:
    envs = gym.make_vec("khepera_forage:khepera_forage/Corridor-v1", num_envs=8, limit=LIMIT, autoreset_mode="SameStep")
    settings: dict[str, Any] = {"n_steps": 32, "batch_size": 64, "n_epochs": 1, "seed": 0, "device": "cpu"}
    model = PPO("MultiInputPolicy", VecEnvAdapter(envs, hold=5), **settings).learn(512)
    assert model.num_timesteps == 512
    assert model.ep_info_buffer is not None
    assert {episode["l"] for episode in model.ep_info_buffer} == {LIMIT}
    row = recall(recall_env("corridor", limit=20), ModelPolicy(model, hold=5), seed=1)
    assert 1 <= row.steps <= 20


@pytest.mark.parametrize("mode", MODES)
def test_options_and_seeds_decide_the_start(mode: str) -> None:
    env = adapter(mode, worlds=2)
    env.set_options([{"start": (100.0, 100.0, 0.0)}, {}])
    env.seed(5)
    one = env.reset()
    env.seed(5)
    two = env.reset()
    assert not np.array_equal(one[0], two[0])
    np.testing.assert_array_equal(one[1], two[1])
    env.set_options({"start": (100.0, 100.0, 0.0)})
    env.seed(5)
    np.testing.assert_array_equal(env.reset()[0], one[0])
    env.seed(5)
    np.testing.assert_array_equal(env.reset(), two)
    assert not np.array_equal(env.reset(), two), "without a seed the random numbers go on"
    assert env.seed(None) == [None, None]
    first, second = adapter(mode, worlds=2).reset(), adapter(mode, worlds=2).reset()
    assert not np.array_equal(first, second), "never seeded: at random"


@pytest.mark.parametrize("mode", MODES)
def test_attributes_are_those_of_the_vector_environment(mode: str) -> None:
    env = adapter(mode, worlds=3)
    assert env.get_attr("num_envs") == [3] * 3
    assert env.get_attr("render_mode", 1) == [None]
    with pytest.raises(AttributeError, match="difficulty"):
        env.get_attr("difficulty")
    with pytest.raises(AttributeError, match="'limit' cannot be set"):
        env.set_attr("limit", 3)
    with pytest.raises(AttributeError, match="jump"):
        env.env_method("jump")
    assert env.get_attr("limit", [0, 2]) == [LIMIT] * 2
    assert {arena.name for arena in env.get_attr("arena")} == {"corridor"}
    assert env.env_is_wrapped(Monitor, [0, 1]) == [True, True], "infos have the episode, as those of Monitor"
    env.reset()
    masks = [mask.tolist() for mask in env.env_method("action_masks")]
    assert masks == [[behaviour in (0, 1, 2, 8) for behaviour in range(10)]] * 3
    assert env.has_attr("action_masks")
    assert env.env_is_wrapped(VecNormalize) == [False] * 3
    env.close()


def test_environments_that_begin_again_a_step_later_are_refused() -> None:
    env = gym.make_vec("khepera_forage:khepera_forage/Corridor-v1", num_envs=2, vectorization_mode="sync")
    with pytest.raises(ValueError, match=r"autoreset_mode is .*; allowed: .*SAME_STEP"):
        VecEnvAdapter(env, behaviour_features)
    env.close()
