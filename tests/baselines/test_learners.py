"""Learners of stable-baselines3: short trainings, what policies act on, the same outcome for the same seed."""

import pickle
import random
import re
import sys
from dataclasses import replace
from functools import partial
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from khepera_forage.policies import state_vector_of
from khepera_forage.policies.learners import LEARNERS, ReinforcementLearner
from khepera_forage.policies.models import algorithm_named
from khepera_forage.rollouts.recall import recall_env
from khepera_forage.rollouts.reinforcement import COMPILED_MODE, TrainedPolicy, recall_envs, reinforce
from khepera_forage.task.states import Behaviour

FROM_STEPS = {name: learner for name, learner in LEARNERS.items() if isinstance(learner, ReinforcementLearner)}
SMALL: dict[str, dict[str, Any]] = {
    "PPO": {"n_steps": 64, "batch_size": 128},
    "DQN": {"learning_starts": 100},
    "SAC": {"learning_starts": 100, "train_freq": 16, "gradient_steps": 2},
}
AMOUNTS = 600, 1_300


def short(name: str, amounts: tuple[int, ...], seed: int = 0) -> list[TrainedPolicy]:
    """A short training with a learner's own settings, except those that need a long one."""
    learner = FROM_STEPS[name]
    learner = replace(learner, settings={**learner.settings, **SMALL[learner.algorithm]})
    return reinforce(learner, amounts, seed, envs=2)


@pytest.fixture(scope="module")
def trained() -> dict[str, list[TrainedPolicy]]:
    return {name: short(name, AMOUNTS) for name in FROM_STEPS}


@pytest.mark.parametrize("name", FROM_STEPS)
def test_policies_are_kept_after_each_amount(name: str, trained: dict[str, list[TrainedPolicy]]) -> None:
    early, late = trained[name]
    a_time = 2 * 64 * FROM_STEPS[name].hold
    assert 600 <= early.steps < min(600 + a_time, late.steps)
    assert 1_300 <= late.steps < 1_300 + a_time
    assert early.steps % FROM_STEPS[name].hold == late.steps % FROM_STEPS[name].hold == 0
    assert 0 < early.seconds < late.seconds
    assert parameters(early) != parameters(late), "the late policy has learned more than the early one"


@pytest.mark.parametrize("name", FROM_STEPS)
def test_same_seed_gives_the_same_policy(name: str, trained: dict[str, list[TrainedPolicy]]) -> None:
    assert parameters(short(name, AMOUNTS)[-1]) == parameters(trained[name][-1])
    if name == "ppo":
        assert parameters(short(name, AMOUNTS, seed=1)[-1]) != parameters(trained[name][-1])


@pytest.mark.parametrize("name", FROM_STEPS)
def test_pickled_policy_acts_the_same(name: str, trained: dict[str, list[TrainedPolicy]]) -> None:
    policy = trained[name][-1].policy
    twin = pickle.loads(pickle.dumps(policy))
    env = gym.make(f"khepera_forage:khepera_forage/Corridor{'Wheels' if FROM_STEPS[name].wheels else ''}-v1")
    observation, _ = env.reset(seed=3)
    rng, other = np.random.default_rng(0), np.random.default_rng(0)
    for _ in range(30):
        action = policy.act(observation, rng)
        shown = observation if FROM_STEPS[name].wheels else state_vector_of(observation)
        np.testing.assert_array_equal(action, twin.act(shown, other))
        assert env.action_space.contains(action if FROM_STEPS[name].wheels else int(np.asarray(action)))
        observation, *_ = env.step(action)
    env.close()


def test_short_training_learns_one_right_behaviour() -> None:
    """An environment with one right behaviour: everything from environment to policy works."""

    class OneRight(gym.Wrapper[Any, int, Any, int]):
        """GO HOME is rewarded, all else is not."""

        def step(self, action: int) -> tuple[Any, float, bool, bool, dict[str, Any]]:
            shown, _, *ended, info = self.env.step(action)
            return shown, float(action == Behaviour.GO_HOME), *ended, info

    def make(count: int) -> gym.vector.VectorEnv[Any, Any, Any]:
        one = partial(OneRight, recall_env("corridor", limit=10))
        return gym.vector.SyncVectorEnv([one] * count, autoreset_mode=AutoresetMode.SAME_STEP)

    learner = replace(FROM_STEPS["ppo"], settings={**FROM_STEPS["ppo"].settings, **SMALL["PPO"]}, sample=False)
    (out,) = reinforce(learner, [3_000], 0, make_env=make, envs=4)
    env, policy = recall_env("corridor"), replace(out.policy, hold=1)
    assert [policy.act(env.reset(seed=seed)[0]) for seed in range(20)].count(Behaviour.GO_HOME) >= 18


def test_global_random_states_stay_unchanged() -> None:
    before = str(np.random.get_state(legacy=False)), random.getstate()  # noqa: NPY002
    short("dqn", (200,))
    assert (str(np.random.get_state(legacy=False)), random.getstate()) == before  # noqa: NPY002


def test_arena_decides_the_environment() -> None:
    env: Any = recall_envs("rectangle", wheels=True, mode=COMPILED_MODE)(1)
    given = env.spec.kwargs
    assert (given["limit"], given["foods"], env.single_action_space.shape) == (700, 2, (4,))


def test_wrong_arguments_and_missing_extras_are_named(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ValueError, match="arena is 'ring'; allowed: corridor, rectangle"):
        reinforce(FROM_STEPS["ppo"], [1], 0, arena="ring")
    amounts: Any
    for amounts in ([], 5, None):
        with pytest.raises(ValueError, match=re.escape(f"amounts are {amounts}; allowed: one or more whole numbers")):
            reinforce(FROM_STEPS["ppo"], amounts, 0)
    for amounts in ([-5, 10], ["a"], [1.5]):
        with pytest.raises(ValueError, match=f"amount is {amounts[0]!r}; allowed: a whole number of at least 1"):
            reinforce(FROM_STEPS["ppo"], amounts, 0)
    wrong: Any
    for wrong in ({"seed": -1}, {"seed": 1.5}, {"seed": 2**32}, {"seed": 0, "envs": 0}):
        with pytest.raises(ValueError, match=r"(seed|envs) is .*; allowed: a whole number"):
            reinforce(FROM_STEPS["ppo"], [1], **wrong)
    imitator: Any = LEARNERS["tree"]
    with pytest.raises(TypeError, match=r"learner is .*; allowed: a ReinforcementLearner"):
        reinforce(imitator, [1], 0)
    with pytest.raises(ValueError, match="algorithm is 'A2C'; allowed: PPO, DQN, SAC"):
        algorithm_named("A2C")
    monkeypatch.setitem(sys.modules, "stable_baselines3", None)
    with pytest.raises(ImportError, match=r"PPO needs stable_baselines3: pip install 'khepera-forage\[baselines\]'"):
        algorithm_named("PPO")


def parameters(trained: TrainedPolicy) -> bytes:
    model: Any = trained.policy.model
    return b"".join(value.numpy().tobytes() for value in model.policy.state_dict().values())
