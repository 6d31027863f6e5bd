"""`gym.make_vec` on compiled worlds: spaces, seeds, resets and errors."""

from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.envs.compiled.vector_env import BehavioursVectorEnv, WheelsVectorEnv
from khepera_forage.noise import Noise

NAMES = ("Corridor", "Rectangle", "CorridorWheels", "RectangleWheels")


def _make(name: Any = "Corridor", num_envs: Any = 5, **kwargs: Any) -> Any:
    return gym.make_vec(f"khepera_forage/{name}-v1", num_envs=num_envs, **kwargs)


@pytest.mark.parametrize("name", NAMES)
def test_spaces_types_and_infos_are_those_of_synchronous_environments(name: Any) -> None:
    compiled, plain = _make(name), _make(name, vectorization_mode="sync")
    assert isinstance(compiled, BehavioursVectorEnv | WheelsVectorEnv)
    assert compiled.observation_space == plain.observation_space
    assert compiled.action_space == plain.action_space
    compiled.action_space.seed(0)
    (obs, infos), (_, plain_infos) = compiled.reset(seed=1), plain.reset(seed=1)
    assert obs in compiled.observation_space
    for _ in range(4):
        actions = compiled.action_space.sample()
        obs, rewards, terminated, truncated, infos = compiled.step(actions)
        _, plain_rewards, plain_terminated, _, plain_infos = plain.step(actions)
        assert obs in compiled.observation_space
        assert rewards.dtype == plain_rewards.dtype
        assert terminated.dtype == truncated.dtype == plain_terminated.dtype
        assert set(infos) == set(plain_infos)
        for key in infos:
            assert infos[key].shape == plain_infos[key].shape, key
            assert infos[key].dtype.kind == plain_infos[key].dtype.kind, key
    assert compiled.metadata["autoreset_mode"] == AutoresetMode.NEXT_STEP
    plain.close()
    compiled.close()


def _roll(env: Any, steps: Any, seed: Any = 3) -> Any:
    _, infos = env.reset(seed=seed)
    out = []
    for _ in range(steps):
        obs, rewards, terminated, truncated, infos = env.step(infos["correct_behaviour"])
        out.append((obs, rewards, terminated, truncated, infos))
    return out


def test_rollouts_repeat_bit_for_bit_in_fresh_arrays_for_any_number_of_worlds() -> None:
    one, two, three = (
        _roll(_make(num_envs=6), 150),
        _roll(_make(num_envs=6), 150),
        _roll(_make(num_envs=200), 150),
    )
    for a, b, c in zip(one, two, three, strict=True):
        for key in a[0]:
            assert np.array_equal(a[0][key], b[0][key])
            assert np.array_equal(a[0][key], c[0][key][:6])
        for part in (1, 2, 3):
            assert np.array_equal(a[part], c[part][:6])
    assert not np.shares_memory(one[0][0]["robot_home_distance"], one[1][0]["robot_home_distance"])
    assert any(a[2].any() for a in one)


def test_disabled_autoreset_waits_for_a_reset_mask() -> None:
    env = _make(num_envs=8, autoreset_mode="Disabled")
    _, infos = env.reset(seed=0)
    over = np.zeros(8, np.bool_)
    while not over.any():
        obs, _, terminated, truncated, infos = env.step(infos["correct_behaviour"])
        over = terminated | truncated
    with pytest.raises(ResetNeeded, match="has ended"):
        env.step(infos["correct_behaviour"])
    again, fresh = env.reset(options={"reset_mask": over})
    assert np.array_equal(fresh["_steps"], over)
    for key in obs:
        assert np.array_equal(obs[key][~over], again[key][~over])
    env.step(np.zeros(8, np.int64))


def test_bad_input_is_quoted() -> None:
    env = _make()
    with pytest.raises(ResetNeeded):
        env.step(np.zeros(5, np.int64))
    with pytest.raises(ResetNeeded, match="reset_mask"):
        env.reset(options={"reset_mask": np.ones(5, np.bool_)})
    env.reset(seed=0)
    for actions in (np.zeros(4, np.int64), np.full(5, 10), np.zeros(5)):
        with pytest.raises(ValueError, match="allowed: 5 whole numbers from 0 to 9"):
            env.step(actions)
    with pytest.raises(ValueError, match="reset_mask is"):
        env.reset(options={"reset_mask": np.zeros(5, np.bool_)})
    with pytest.raises(ValueError, match="reset option 'sart' is unknown"):
        env.reset(options={"sart": 1})
    with pytest.raises(ValueError, match="4 seeds for 5 worlds"):
        env.reset(seed=[1, 2, 3, 4])
    with pytest.raises(ValueError, match="render_mode is 'human'"):
        BehavioursVectorEnv(2, render_mode="human")
    wheels = _make("CorridorWheels", 2)
    wheels.reset(seed=0)
    with pytest.raises(ValueError, match=r"allowed: numbers in -1\.\.1"):
        wheels.step(np.full((2, 4), 1.5))


def test_pictures_of_worlds_are_those_of_single_environments() -> None:
    kwargs: Any = {"noise": Noise.none(), "render_mode": "rgb_array"}
    worlds = _make("Rectangle", 3, **kwargs)
    with pytest.raises(ResetNeeded):
        worlds.render()
    _, infos = worlds.reset(seed=4)
    alone: Any = gym.make("khepera_forage/Rectangle-v1", backend="compiled", **kwargs)
    alone.reset(seed=5)
    assert np.array_equal(worlds.render()[1], alone.render())
    for _ in range(20):
        infos = worlds.step(infos["correct_behaviour"])[4]
    frames = worlds.render()
    assert isinstance(frames, tuple), "what Gymnasium's RecordVideo needs"
    assert len(frames) == 3
    assert len({frame.tobytes() for frame in frames}) == 3


@pytest.mark.parametrize("limits", [{"limit": 20, "max_episode_steps": 7}, {"limit": 60}])
@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_episodes_end_and_begin_as_in_synchronous_environments(
    mode: AutoresetMode, limits: dict[str, int]
) -> None:
    compiled = _make(autoreset_mode=mode, **limits)
    modes: dict[str, Any] = {"vectorization_mode": "sync", "vector_kwargs": {"autoreset_mode": mode}}
    plain = _make(backend="compiled", **modes, **limits)
    actions = compiled.reset(seed=3)[1]["correct_behaviour"]
    plain.reset(seed=3)
    ends = np.zeros(5)
    for _ in range(120):
        one, other = (env.step(actions) for env in (compiled, plain))
        for mine, theirs in zip(one[:4], other[:4], strict=True):
            np.testing.assert_equal(mine, theirs)
        over, actions = one[2] | one[3], one[4]["correct_behaviour"]
        ends += over
        np.testing.assert_array_equal(one[4]["steps"], other[4]["steps"])
        if mode == AutoresetMode.SAME_STEP and over.any():
            np.testing.assert_array_equal(one[4]["_final_info"], over)
            for name, values in one[4]["final_info"].items():
                np.testing.assert_array_equal(values[over], other[4]["final_info"][name][over])
            for i in np.flatnonzero(over):
                np.testing.assert_equal(one[4]["final_obs"][i], other[4]["final_obs"][i])
        if mode == AutoresetMode.DISABLED and over.any():
            fresh = [env.reset(options={"reset_mask": over}) for env in (compiled, plain)]
            np.testing.assert_equal(fresh[0][0], fresh[1][0])
            actions = np.where(over, fresh[0][1]["correct_behaviour"], actions)
    assert ends.min() >= 1


def test_wrong_number_of_steps_is_quoted() -> None:
    with pytest.raises(ValueError, match="max_episode_steps is 0; allowed: a whole number of at least 1"):
        _make(max_episode_steps=0)


def test_batch_tells_what_it_knows_of_each_world() -> None:
    compiled = _make(arena=["corridor", "doors"], foods=2)
    plain = _make(arena=["corridor", "doors"], foods=2, vectorization_mode="sync", backend="compiled")
    for env in (compiled, plain):
        env.reset(seed=3)
    for name in (
        "arena",
        "home_radius",
        "diagonal",
        "foods",
        "limit",
        "decisions",
        "largest_diagonal",
        "backend",
    ):
        assert compiled.get_attr(name) == compiled.call(name) == plain.get_attr(name), name
    with pytest.raises(AttributeError, match="compiled worlds have no 'forager'; allowed: arena, "):
        compiled.get_attr("forager")


def test_masks_hold_what_applies_and_always_what_the_teacher_does() -> None:
    compiled = _make(num_envs=64, food_types={"PICKABLE": 1, "PUSHABLE": 1, "POISONOUS": 1})
    plain = _make(num_envs=1, vectorization_mode="sync", backend="compiled")
    (_, infos), _ = compiled.reset(seed=3), plain.reset(seed=3)
    seen = set()
    for _ in range(300):
        masks = compiled.action_masks()
        right = infos["correct_behaviour"]
        assert masks[np.arange(64), right].all()
        np.testing.assert_array_equal(np.stack(compiled.call("action_masks")), masks)
        seen |= {(int(np.flatnonzero(mask).sum()), int(mask.sum())) for mask in masks}
        infos = compiled.step(right)[4]
    # Search, move slowly, orient, avoid home; or with an object release and explore, pick up and go home, push, avoid.
    assert seen == {(11, 4), (12, 2), (20, 3), (14, 2), (15, 2)}
    assert np.flatnonzero(plain.call("action_masks")[0]).tolist() == [0, 1, 2, 8]


def test_a_world_takes_at_most_2_kb() -> None:
    assert 0 < _make(num_envs=64).unwrapped.batch.bytes_per_world <= 2048
