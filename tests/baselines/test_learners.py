"""stable-baselines3 as policies: short trainings, the contract of policies, the same outcome for the same seed."""

import copy
import pickle
import random
import re
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.vector import AutoresetMode

from khepera_forage.policies import Policy
from khepera_forage.policies.baselines import BaselinePolicy, WheelsPolicy, algorithm_named
from khepera_forage.policies.features import behaviour_features
from khepera_forage.policies.learners import LEARNERS, FromSteps
from khepera_forage.rollouts.recall import recall, recall_env
from khepera_forage.rollouts.reinforcement import Trained, recall_envs, reinforce, vec_env
from khepera_forage.rollouts.sb3_vector_env import VectorBridge
from khepera_forage.rollouts.wheels_recall import recall_wheels, recall_wheels_env
from tests.contracts.suites import PolicyContract

TRIAL = {name: learner for name, learner in LEARNERS.items() if isinstance(learner, FromSteps)}
SMALL: dict[str, dict[str, Any]] = {
    "PPO": {"n_steps": 64, "batch_size": 128},
    "DQN": {"learning_starts": 100},
    "SAC": {"learning_starts": 100, "train_freq": 16, "gradient_steps": 2},
}
AMOUNTS = 600, 1_300


def short(name: str, amounts: tuple[int, ...], seed: int = 0) -> list[Trained]:
    """A short training with a learner's own settings, but for those that ask for a long one."""
    learner = TRIAL[name]
    learner = replace(learner, settings={**learner.settings, **SMALL[learner.algorithm]})
    return reinforce(learner, amounts, seed, envs=2)


@pytest.fixture(scope="module")
def trained() -> dict[str, list[Trained]]:
    return {name: short(name, AMOUNTS) for name in TRIAL}


class TestBehaviours(PolicyContract):
    @pytest.fixture(params=[name for name, learner in TRIAL.items() if not learner.wheels])
    def policy(self, request: pytest.FixtureRequest, trained: dict[str, list[Trained]]) -> Policy:
        policy = trained[request.param][-1].policy
        assert isinstance(policy, BaselinePolicy)
        return policy


@pytest.mark.parametrize("name", TRIAL)
def test_policies_are_kept_after_each_amount(name: str, trained: dict[str, list[Trained]]) -> None:
    early, late = trained[name]
    a_time = 2 * 64 * TRIAL[name].hold
    assert 600 <= early.steps < min(600 + a_time, late.steps)
    assert 1_300 <= late.steps < 1_300 + a_time
    assert early.steps % TRIAL[name].hold == late.steps % TRIAL[name].hold == 0
    assert 0 < early.seconds < late.seconds
    assert parameters(early) != parameters(late), "it went on learning, and the early one did not"


@pytest.mark.parametrize("name", TRIAL)
def test_same_seed_same_policy(name: str, trained: dict[str, list[Trained]]) -> None:
    assert parameters(short(name, AMOUNTS)[-1]) == parameters(trained[name][-1])
    assert parameters(short(name, AMOUNTS, seed=1)[-1]) != parameters(trained[name][-1])


@pytest.mark.parametrize("name", TRIAL)
def test_a_pickle_decides_the_same(name: str, trained: dict[str, list[Trained]]) -> None:
    policy = trained[name][-1].policy
    twin = pickle.loads(pickle.dumps(policy))
    env = gym.make(f"khepera_forage:khepera_forage/Corridor{'Wheels' if TRIAL[name].wheels else ''}-v0")
    observation, _ = env.reset(seed=3)
    rng, other = np.random.default_rng(0), np.random.default_rng(0)
    for _ in range(30):
        action = policy.act(observation, rng)
        np.testing.assert_array_equal(action, twin.act(observation, other))
        assert env.action_space.contains(action if TRIAL[name].wheels else int(np.asarray(action)))
        observation, *_ = env.step(action)
    env.close()


def test_it_forages_where_the_thesis_learner_does(trained: dict[str, list[Trained]]) -> None:
    policy = trained["ppo"][-1].policy
    assert isinstance(policy, BaselinePolicy)
    env = recall_env("rectangle", limit=58)
    rows = [recall(env, policy, 3, learner="ppo") for _ in range(2)]
    assert rows[0] == rows[1], "also where the last decision of the first recall still held"
    assert rows[0].steps == 58


@pytest.mark.parametrize("name", ["ppo_wheels", "sac_wheels"])
def test_it_forages_with_wheels(name: str, trained: dict[str, list[Trained]]) -> None:
    policy = trained[name][-1].policy
    assert isinstance(policy, WheelsPolicy)
    env = recall_wheels_env("corridor", limit=58)
    rows = [recall_wheels(env, policy, 3) for _ in range(2)]
    assert rows[0] == rows[1]
    assert (rows[0].steps, rows[0].foods) == (58, 1)


@pytest.mark.parametrize("name", ["ppo", "ppo_wheels"])
def test_a_decision_holds(name: str, trained: dict[str, list[Trained]]) -> None:
    policy = replace(trained[name][-1].policy, hold=4)
    env = gym.make(f"khepera_forage:khepera_forage/Corridor{'Wheels' if TRIAL[name].wheels else ''}-v0")
    shown = [env.reset(seed=seed)[0] for seed in range(40)]
    env.close()

    def decisions(rng: np.random.Generator, count: int) -> list[tuple[float, ...]]:
        return [tuple(np.atleast_1d(policy.act(one, rng)).tolist()) for one in shown[:count]]

    first = decisions(np.random.default_rng(0), 40)
    assert all(len(set(first[begin : begin + 4])) == 1 for begin in range(0, 40, 4))
    assert len(set(first)) > 3
    decisions(np.random.default_rng(1), 2)
    assert decisions(np.random.default_rng(0), 40) == first, "another generator, another episode"


def test_what_a_short_training_can_learn_is_learned() -> None:
    """A world with one right behaviour: the machinery from environment to policy works."""

    class OneRight(gym.Env[dict[str, Any], int]):
        """GO HOME is rewarded, all else is not."""

        def __init__(self) -> None:
            self.observation_space = recall_env("corridor").observation_space
            self.action_space = gym.spaces.Discrete(10)  # type: ignore[assignment]

        def reset(
            self, *, seed: int | None = None, options: Any = None
        ) -> tuple[dict[str, Any], dict[str, Any]]:
            super().reset(seed=seed)
            self.left = 10
            if seed is not None:
                self.observation_space.seed(seed)
            return self.observation_space.sample(), {}

        def step(self, action: int) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
            self.left -= 1
            return self.observation_space.sample(), float(action == 7), False, self.left == 0, {}

    def make(count: int) -> gym.vector.VectorEnv[Any, Any, Any]:
        return gym.vector.SyncVectorEnv([OneRight] * count, autoreset_mode=AutoresetMode.SAME_STEP)

    learner = replace(TRIAL["ppo"], settings={**TRIAL["ppo"].settings, **SMALL["PPO"]}, sample=False)
    (out,) = reinforce(learner, [3_000], 0, make_env=make, envs=4)
    assert isinstance(out.policy, BaselinePolicy)
    space, policy = recall_env("corridor").observation_space, replace(out.policy, hold=1)
    assert [int(policy.act(space.sample())) for _ in range(20)].count(7) >= 18


def test_global_chance_is_left_as_it_was() -> None:
    before = str(np.random.get_state(legacy=False)), random.getstate()  # noqa: NPY002
    short("dqn", (200,))
    assert (str(np.random.get_state(legacy=False)), random.getstate()) == before  # noqa: NPY002


@pytest.mark.parametrize("name", TRIAL)
def test_settings_are_left_as_they_were(name: str) -> None:
    before = copy.deepcopy(dict(TRIAL[name].settings))
    short(name, (200,))
    assert dict(TRIAL[name].settings) == before


def test_what_an_episode_showed_last_is_told() -> None:
    make = recall_envs("corridor", limit=5)
    env = VectorBridge(make(2), behaviour_features)
    env.seed(3)
    first = env.reset()
    plain = make(2)
    shown, _ = plain.reset(seed=3)
    np.testing.assert_array_equal(first, behaviour_features(shown))
    for step in range(1, 11):
        env.step_async(np.array([0, 8]))
        rows, _, ended, infos = env.step_wait()
        shown, _, _, _, info = plain.step(np.array([0, 8]))
        np.testing.assert_array_equal(rows, behaviour_features(shown))
        assert ended.tolist() == [step % 5 == 0] * 2
        for i in range(2):
            if ended[i]:
                last = behaviour_features(info["final_obs"][i])[0]
                np.testing.assert_array_equal(infos[i]["terminal_observation"], last)
                assert infos[i]["TimeLimit.truncated"]
            else:
                assert infos[i] == {}
    env.close()
    plain.close()


def test_a_batch_or_side_by_side(monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level("INFO", "khepera_forage")
    short("dqn", (50,))
    monkeypatch.setattr("khepera_forage.rollouts.reinforcement.find_spec", lambda name: None)
    short("dqn", (50,))
    assert [record.message for record in caplog.records] == [
        "DQN on behaviours learns in a batch of 2 worlds",
        "DQN on behaviours learns in 2 environments side by side",
    ]


def test_arenas() -> None:
    env = vec_env(TRIAL["ppo_wheels"], envs=1, arena="rectangle")
    assert (env.get_attr("limit"), env.get_attr("foods"), env.action_space.shape) == ([700], [2], (4,))
    with pytest.raises(ValueError, match="arena is 'ring'; allowed: corridor, rectangle"):
        reinforce(TRIAL["ppo"], [1], 0, arena="ring")


def test_environments_that_start_again_too_late() -> None:
    env = gym.make_vec("khepera_forage:khepera_forage/Corridor-v0", num_envs=2, vectorization_mode="sync")
    with pytest.raises(ValueError, match=r"autoreset_mode is .*; allowed: .*SAME_STEP"):
        VectorBridge(env, behaviour_features)
    env.close()


@pytest.mark.parametrize("amounts", [[], [0], [-5, 10]])
def test_no_steps(amounts: list[int]) -> None:
    with pytest.raises(ValueError, match=r"amounts are \[.*\]; allowed: one or more, each above 0"):
        reinforce(TRIAL["ppo"], amounts, 0)


def test_no_such_algorithm_and_none_at_all(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ValueError, match="algorithm is 'A2C'; allowed: PPO, DQN, SAC"):
        algorithm_named("A2C")
    monkeypatch.setitem(sys.modules, "stable_baselines3", None)
    with pytest.raises(
        ImportError, match=r"PPO needs stable-baselines3: pip install 'khepera-forage\[baselines\]'"
    ):
        algorithm_named("PPO")


def test_who_draws_needs_a_generator(trained: dict[str, list[Trained]]) -> None:
    for name, shown in (("ppo", [0, 60, 0, 215, 40]), ("ppo_wheels", {})):
        with pytest.raises(TypeError, match=r"rng is None; allowed: a numpy\.random\.Generator"):
            trained[name][-1].policy.act(shown)  # type: ignore[arg-type]


def parameters(trained: Trained) -> bytes:
    policy = trained.policy
    assert isinstance(policy, BaselinePolicy | WheelsPolicy)
    return b"".join(value.numpy().tobytes() for value in policy.model.policy.state_dict().values())


def test_the_block_of_the_page_on_learners(capsys: pytest.CaptureFixture[str]) -> None:
    page = (Path(__file__).parents[2] / "docs" / "plug_in_a_learner.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"```python\n(# needs the extra: baselines\n.*?)```", page, flags=re.DOTALL)
    exec(block, {"LEARNERS": LEARNERS, "recall": recall, "corridor": recall_env("corridor", limit=50)})
    assert re.findall(r"after (\d+) steps", capsys.readouterr().out) == ["2560", "5120"]
