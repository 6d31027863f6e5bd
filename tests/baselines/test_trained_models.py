"""stable-baselines3 in environments as they are, and its models: what they are shown, how long their actions hold."""

from collections.abc import Callable
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode
from gymnasium.wrappers import (
    DtypeObservation,
    FlattenObservation,
    NormalizeObservation,
    NormalizeReward,
    TimeLimit,
    TransformReward,
)
from gymnasium.wrappers.vector import RecordEpisodeStatistics
from stable_baselines3 import PPO
from stable_baselines3.common.env_checker import check_env
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.vec_env import DummyVecEnv, SubprocVecEnv, VecCheckNan, VecFrameStack, VecNormalize

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.policies import ModelPolicy, as_policy
from khepera_forage.policies.features import behaviour_features, wheels_features
from khepera_forage.rollouts.recall import recall, recall_wheels
from khepera_forage.rollouts.sb3_vector_env import VecEnvAdapter
from khepera_forage.wrappers import ActionRepeat, VectorActionRepeat

SMALL: dict[str, Any] = {"n_steps": 8, "batch_size": 8, "n_epochs": 1, "seed": 0, "device": "cpu"}
WRAPPED: list[tuple[Callable[[Any], Any], int]] = [
    (lambda env: env, 1),
    (lambda env: TimeLimit(ActionRepeat(env, 5), 30), 5),
    (lambda env: FlattenObservation(ActionRepeat(env, 3)), 3),
    (lambda env: ActionRepeat(DtypeObservation(FlattenObservation(env), np.float32), 3), 3),
    (lambda env: TransformReward(ActionRepeat(FlattenObservation(env), 2), lambda reward: float(reward) / 2), 2),
    (NormalizeReward, 1),
]


def made(wrap: Callable[[Any], Any] = lambda env: env, wheels: bool = False) -> Any:
    return wrap(gym.make(f"khepera_forage/Corridor{'Wheels' if wheels else ''}-v1", limit=60))


def trained(env: Any) -> Any:
    space = getattr(env, "observation_space", None)
    policy = "MultiInputPolicy" if isinstance(space, gym.spaces.Dict) else "MlpPolicy"
    return PPO(policy, env, **SMALL).learn(16)


def worlds(count: int = 2, **kwargs: Any) -> Any:
    kwargs |= {"autoreset_mode": AutoresetMode.SAME_STEP}
    return gym.make_vec("khepera_forage/Corridor-v1", num_envs=count, limit=60, **kwargs)


def assert_acts_as_in_training(model: Any, hold: int, wheels: bool = False) -> None:
    """The policy of a model commands what the model does behind the wrappers of its training."""
    policy = as_policy(model)
    assert policy.hold == hold  # type: ignore[attr-defined]
    own = made(wheels=wheels).unwrapped
    vec = model.get_env()
    normalized = model.get_vec_normalize_env()
    if normalized is not None:
        normalized.training = False
    vec.seed(3)
    rows, (shown, _), rng = vec.reset(), own.reset(seed=3), np.random.default_rng(0)
    for _ in range(4):
        action = model.predict(rows, deterministic=True)[0]
        for _ in range(hold):
            given = policy.act(shown, rng)
            np.testing.assert_array_equal(given, action[0])
            shown = own.step(given)[0]
        rows = vec.step(action)[0]


@pytest.mark.parametrize(("wrap", "hold"), WRAPPED)
def test_model_of_a_wrapped_environment_acts_as_in_training(wrap: Callable[[Any], Any], hold: int) -> None:
    assert_acts_as_in_training(trained(made(wrap)), hold)


@pytest.mark.parametrize("hold", [1, 5])
@pytest.mark.parametrize("normalize", [False, True])
@pytest.mark.parametrize("wheels", [False, True])
def test_model_of_the_adapter_acts_as_in_training(wheels: bool, normalize: bool, hold: int) -> None:
    name = f"khepera_forage/Corridor{'Wheels' if wheels else ''}-v1"
    kwargs: dict[str, Any] = {"vector_kwargs": {"autoreset_mode": "SameStep"}, "limit": 60}
    envs = gym.make_vec(name, num_envs=1, vectorization_mode="sync", **kwargs)
    env: Any = VecCheckNan(VecEnvAdapter(envs, wheels_features if wheels else behaviour_features, hold))
    assert_acts_as_in_training(trained(VecNormalize(env) if normalize else env), hold, wheels)


def test_model_of_motors_forages_as_its_policy() -> None:
    env, model = made(wheels=True), trained(made(FlattenObservation, wheels=True))
    assert recall_wheels(env, model, 1) == recall_wheels(env, as_policy(model), 1)


def test_action_holds_however_it_was_held() -> None:
    held = VectorActionRepeat(RecordEpisodeStatistics(worlds()), 5)
    assert as_policy(trained(VecEnvAdapter(held, behaviour_features))).hold == 5  # type: ignore[attr-defined]
    asynchronous = SubprocVecEnv([lambda: made(lambda env: ActionRepeat(env, 4))])
    assert as_policy(trained(asynchronous)).hold == 4  # type: ignore[attr-defined]
    asynchronous.close()


def test_model_behind_other_wrappers_is_refused() -> None:
    with pytest.raises(ValueError, match=r"trained behind NormalizeObservation; allowed: .*ModelPolicy\(model, feat"):
        as_policy(trained(made(lambda env: NormalizeObservation(FlattenObservation(env)))))
    stacked = VecFrameStack(DummyVecEnv([lambda: made(FlattenObservation)]), 2)
    with pytest.raises(ValueError, match="PPO was trained behind VecFrameStack; allowed"):
        as_policy(trained(stacked))


def test_loaded_model_needs_its_environments_or_a_policy_of_ones_own(tmp_path: Any) -> None:
    env = VecEnvAdapter(worlds(), behaviour_features, hold=5)
    trained(env).save(tmp_path / "model")
    loaded = PPO.load(tmp_path / "model", device="cpu")
    with pytest.raises(ValueError, match="PPO was loaded without the environments that it was trained in; allowed"):
        as_policy(loaded)
    again = PPO.load(tmp_path / "model", env=env, device="cpu")
    row = recall(made(), as_policy(again), 1)
    assert row == recall(made(), ModelPolicy(loaded, behaviour_features, hold=5), 1)


def test_recall_names_the_wrappers_that_it_leaves_out() -> None:
    env = made(lambda env: TimeLimit(ActionRepeat(env, 5), 3))
    with pytest.warns(UserWarning, match="TimeLimit, ActionRepeat left out: recalls take place in the environment"):
        recall(env, as_policy(trained(made())), 1)


def test_evaluation_counts_rounds_as_training_does() -> None:
    model = trained(VecEnvAdapter(worlds(), behaviour_features, hold=5))
    env = VecEnvAdapter(worlds(), behaviour_features, hold=5)
    _, lengths = evaluate_policy(model, env, n_eval_episodes=2, return_episode_rewards=True)
    assert lengths == [60, 60]


@pytest.mark.parametrize("name", ["Corridor", "Rectangle", "CorridorWheels", "RectangleWheels"])
def test_environments_pass_check_env(name: str) -> None:
    env = gym.make(f"khepera_forage/{name}-v1", render_mode="rgb_array")
    check_env(env.unwrapped, warn=True)
    env.close()
