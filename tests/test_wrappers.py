"""An action that holds equals the same action in every round, in one environment and in many."""

from importlib import import_module
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env, data_equivalence
from gymnasium.vector import AutoresetMode
from gymnasium.wrappers.vector import RecordEpisodeStatistics

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.wrappers import ActionRepeat, VectorActionRepeat

NAME, LIMIT, WORLDS = "khepera_forage/Corridor-v1", 40, 3
modes = pytest.mark.parametrize("mode", ["sync", "vector_entry_point"])


def single(**kwargs: Any) -> gym.Env[Any, Any]:
    return gym.make(NAME, limit=LIMIT, **kwargs)


def vector(mode: str) -> gym.vector.VectorEnv[Any, Any, Any]:
    same_step: dict[str, Any] = {"autoreset_mode": AutoresetMode.SAME_STEP}
    kwargs: dict[str, Any] = {"vector_kwargs": same_step} if mode == "sync" else same_step
    return gym.make_vec(NAME, num_envs=WORLDS, vectorization_mode=mode, limit=LIMIT, **kwargs)


def test_held_action_equals_a_repeated_action() -> None:
    held, each = ActionRepeat(single(), rounds=3), single()
    assert data_equivalence(held.reset(seed=4)[0], each.reset(seed=4)[0])
    rng = np.random.default_rng(1)
    for decision in range(1, 15):
        action = int(rng.integers(10))
        shown, reward, terminated, truncated, info = held.step(action)
        parts = [each.step(action) for _ in range(3 if decision < 14 else 1)]  # 13 * 3 + 1 is the limit
        assert reward == pytest.approx(sum(float(part[1]) for part in parts))
        assert data_equivalence(shown, parts[-1][0])
        assert (terminated, truncated) == parts[-1][2:4]
        assert data_equivalence(info, parts[-1][4])
    assert truncated
    assert info["steps"] == LIMIT


def test_environment_with_held_actions_passes_the_check_and_is_made_again() -> None:
    env = ActionRepeat(single(), rounds=2)
    check_env(env.unwrapped, skip_render_check=True)
    assert env.spec is not None
    again: Any = gym.make(env.spec)
    while not isinstance(again, ActionRepeat):
        again = again.env
    assert again.rounds == 2


@modes
def test_every_world_holds_its_action(mode: str) -> None:
    held, each = VectorActionRepeat(vector(mode), rounds=3), vector(mode)
    assert data_equivalence(held.reset(seed=4)[0], each.reset(seed=4)[0])
    rng = np.random.default_rng(1)
    for decision in range(1, 15):
        actions = rng.integers(0, 10, WORLDS)
        shown, rewards, terminated, truncated, info = held.step(actions)
        parts = [each.step(actions) for _ in range(3 if decision < 14 else 1)]
        np.testing.assert_allclose(rewards, np.sum([part[1] for part in parts], axis=0))
        if decision < 14:
            assert data_equivalence(shown, parts[-1][0])
            assert not (terminated | truncated).any()
            assert "final_obs" not in info
            assert info["held_rounds"].tolist() == [3] * WORLDS
    assert truncated.all()
    assert info["held_rounds"].tolist() == [1] * WORLDS
    for i in range(WORLDS):
        assert data_equivalence(info["final_obs"][i], parts[-1][4]["final_obs"][i])
    assert info["final_info"]["steps"].tolist() == [LIMIT] * WORLDS
    # Episodes that ended early begin again at the end of the decision: the next one has its full length.
    assert info["steps"].tolist() == [0] * WORLDS
    lengths = [bool(held.step(rng.integers(0, 10, WORLDS))[3].any()) for _ in range(14)]
    assert lengths == [False] * 13 + [True]


@modes
def test_reports_of_inner_wrappers_are_kept_in_whichever_round_they_come(mode: str) -> None:
    held = VectorActionRepeat(RecordEpisodeStatistics(vector(mode)), rounds=3)
    held.reset(seed=4)
    held.env.step(np.zeros(WORLDS, np.int64))
    held.reset(options={"reset_mask": np.array([True, False, False])})  # the first world is now one round behind
    ends, reported = np.zeros(WORLDS, np.int64), np.zeros(WORLDS, np.int64)
    for _ in range(2 * LIMIT):
        _, _, terminated, truncated, info = held.step(np.zeros(WORLDS, np.int64))
        ended = terminated | truncated
        ends += ended
        assert (info["held_rounds"][~ended] == 3).all()
        np.testing.assert_array_equal(info.get("_episode", np.zeros(WORLDS, np.bool_)), ended)
        if ended.any():
            reported += ended
            assert info["final_info"]["steps"][ended].tolist() == [LIMIT] * ended.sum()
            if mode != "sync":  # whose reset with a mask hides the mask from wrappers (Gymnasium 1.4)
                assert info["episode"]["l"][ended].tolist() == [LIMIT] * ended.sum()
    assert ends.tolist() == reported.tolist() == [5] * WORLDS


def test_wrong_number_of_rounds_and_other_autoreset_modes_are_refused() -> None:
    for rounds in (0, -1, 1.5, "2"):
        with pytest.raises(ValueError, match=f"rounds is {rounds!r}; allowed: a whole number of at least 1"):
            ActionRepeat(single(), rounds=rounds)  # type: ignore[arg-type] # wrong on purpose
    env = gym.make_vec(NAME, num_envs=2, vectorization_mode="sync")
    with pytest.raises(ValueError, match=r"allowed: AutoresetMode.SAME_STEP, as by make_vec\(.*SameStep"):
        VectorActionRepeat(env)


@pytest.mark.parametrize(
    ("module", "old", "new"),
    [
        ("wrappers", "HoldAction", "ActionRepeat"),
        ("wrappers", "HoldVectorAction", "VectorActionRepeat"),
        ("policies.learners", "Needs", "Supervision"),
        ("policies.learners", "FromVectors", "OfflineImitation"),
        ("policies.learners", "FromQueries", "InteractiveImitation"),
        ("policies.learners", "FromSteps", "ReinforcementLearner"),
    ],
)
def test_former_names_still_work(module: str, old: str, new: str) -> None:
    named = import_module(f"khepera_forage.{module}")
    with pytest.warns(DeprecationWarning, match=f"{old} is now {new}"):
        assert getattr(named, old) is getattr(named, new)
