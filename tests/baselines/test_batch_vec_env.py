"""The batch as a `VecEnv`: the same as `gym.make_vec`, and what stable-baselines3 asks of one."""

from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode
from numpy.typing import NDArray
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import VecCheckNan, VecMonitor, VecNormalize

import khepera_forage  # noqa: F401 - registers the environments
from khepera_forage.policies.features import behaviour_features, wheels_features
from khepera_forage.rollouts.sb3_compiled_vec_env import BatchVecEnv
from khepera_forage.rollouts.sb3_vector_env import VectorBridge

WORLDS, LIMIT = 5, 40


def plain(wheels: bool, **kwargs: Any) -> gym.vector.VectorEnv[Any, Any, Any]:
    return gym.make_vec(
        f"khepera_forage/Corridor{'Wheels' if wheels else ''}-v0",
        num_envs=WORLDS,
        vectorization_mode="vector_entry_point",
        autoreset_mode=AutoresetMode.SAME_STEP,
        limit=LIMIT,
        **kwargs,
    )


def drawn(wheels: bool, rng: np.random.Generator) -> NDArray[Any]:
    if wheels:
        return rng.uniform(-1.0, 1.0, (WORLDS, 4)).astype(np.float32)
    return rng.integers(0, 10, WORLDS)


@pytest.mark.parametrize("wheels", [False, True])
def test_it_is_what_make_vec_makes(wheels: bool) -> None:
    features = wheels_features if wheels else behaviour_features
    env: Any = BatchVecEnv(WORLDS, limit=LIMIT, wheels=wheels)
    other = plain(wheels)
    env.seed(3)
    rows = env.reset()
    shown, info = other.reset(seed=3)
    rng, total = np.random.default_rng(0), np.zeros(WORLDS)
    ends = 0
    for _ in range(3 * LIMIT):
        np.testing.assert_array_equal(rows, features(shown))
        assert env.observation_space.contains(rows[0])
        actions = drawn(wheels, rng) if wheels else np.where(rng.random(WORLDS) < 0.1, 0, info["state"])
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
            last = features({name: values[None] for name, values in info["final_obs"][i].items()})[0]
            np.testing.assert_array_equal(infos[i]["terminal_observation"], last)
            assert infos[i]["TimeLimit.truncated"] == truncated[i]
            for name in ("score", "correct", "steps", "delivered", "poison_home"):
                assert infos[i][name] == info["final_info"][name][i]
            assert infos[i]["is_success"] == terminated[i] == (infos[i]["delivered"] == 1)
            assert infos[i]["episode"]["r"] == pytest.approx(total[i])
            assert infos[i]["episode"]["l"] == infos[i]["steps"]
            total[i] = 0.0
    assert ends >= 3 * WORLDS


@pytest.mark.parametrize("bridge", [False, True])
def test_a_decision_that_holds_is_a_decision_repeated(bridge: bool) -> None:
    made: dict[bool, Any] = {
        False: lambda: BatchVecEnv(WORLDS, limit=LIMIT, hold=3),
        True: lambda: VectorBridge(plain(False), behaviour_features, hold=3),
    }
    env, each = made[bridge](), BatchVecEnv(WORLDS, limit=LIMIT)
    rng = np.random.default_rng(1)
    for vec in (env, each):
        vec.seed(4)
    np.testing.assert_array_equal(env.reset(), each.reset())
    for decision in range(1, 15):
        actions = drawn(False, rng)
        rows, rewards, ended, infos = env.step(actions)
        parts = [each.step(actions) for _ in range(3 if decision < 14 else 1)]  # 13 * 3 + 1 is the limit
        np.testing.assert_allclose(rewards, np.sum([part[1] for part in parts], axis=0), rtol=1e-6)
        if decision < 14:
            np.testing.assert_array_equal(rows, parts[-1][0])
            assert not ended.any()
    assert ended.all()
    for i in range(WORLDS):
        last = parts[-1][3][i]["terminal_observation"]
        np.testing.assert_array_equal(infos[i]["terminal_observation"], last)
    # The next episode has not begun yet for those that ended early: it lasts as long as any.
    lengths = [bool(env.step(drawn(False, rng))[2].any()) for _ in range(14)]
    assert lengths == [False] * 13 + [True]


def test_what_wraps_others_wraps_it() -> None:
    env: Any = VecNormalize(VecCheckNan(VecMonitor(BatchVecEnv(WORLDS, limit=LIMIT)), raise_exception=True))
    env.seed(0)
    rows, rng = env.reset(), np.random.default_rng(0)
    for step in range(1, LIMIT + 1):
        rows, rewards, ended, infos = env.step(drawn(False, rng))
        assert (rows.shape, rewards.shape, rows.dtype) == ((WORLDS, 9), (WORLDS,), np.float32)
        assert ended.all() == (step == LIMIT)
    assert all(info["episode"]["l"] == LIMIT for info in infos)


def test_infos_and_arrays_are_fresh() -> None:
    env: Any = BatchVecEnv(2)
    first = env.reset()
    kept = first.copy()
    for _ in range(2):
        rows, _, _, infos = env.step(np.zeros(2, int))
        assert infos == [{}, {}]
        infos[0]["mine"] = 1
        rows[:] = 7.0
    np.testing.assert_array_equal(first, kept)


def test_places_asked_for_and_seeds() -> None:
    env = BatchVecEnv(2)
    env.set_options([{"start": (100.0, 100.0, 0.0)}, {}])
    env.seed(5)
    one = env.reset()
    env.seed(5)
    two = env.reset()
    assert not np.array_equal(one[0], two[0])
    np.testing.assert_array_equal(one[1], two[1])
    env.seed(5)
    np.testing.assert_array_equal(env.reset(), two)
    assert not np.array_equal(env.reset(), two), "without a seed worlds go on with their numbers"
    assert not np.array_equal(BatchVecEnv(2).reset(), BatchVecEnv(2).reset()), "never seeded: at random"


def test_attributes() -> None:
    env = BatchVecEnv(3, limit=LIMIT)
    assert env.get_attr("limit") == [LIMIT] * 3
    assert env.get_attr("render_mode", 1) == [None]
    env.set_attr("difficulty", 2, [0, 2])
    assert env.get_attr("difficulty", [0, 2]) == [2, 2]
    with pytest.raises(AttributeError, match="difficulty"):
        env.get_attr("difficulty")
    with pytest.raises(AttributeError, match="'limit' is the same in all worlds"):
        env.set_attr("limit", 3)
    with pytest.raises(AttributeError, match="no method 'jump'"):
        env.env_method("jump")
    assert env.env_is_wrapped(Monitor, [0, 1]) == [False, False]
    env.close()


@pytest.mark.parametrize(
    ("wheels", "actions"),
    [
        (False, [0, 10]),
        (False, [-1, 0]),
        (False, [[1, 2]]),
        (True, [[0, 0, 0, 1.5]] * 2),
        (True, [[np.nan] * 4] * 2),
    ],
)
def test_actions_that_are_none(wheels: bool, actions: Any) -> None:
    env = BatchVecEnv(2, wheels=wheels)
    env.reset()
    with pytest.raises(ValueError, match=r"actions are array(.|\n)*; allowed: "):
        env.step(np.array(actions))


def test_a_step_before_the_first_reset() -> None:
    env = BatchVecEnv(2)
    with pytest.raises(ResetNeeded, match="not reset yet"):
        env.step(np.array([0, 0]))


def test_no_rounds_to_hold() -> None:
    with pytest.raises(ValueError, match="hold is 0; allowed: a whole number of at least 1"):
        BatchVecEnv(2, hold=0)
