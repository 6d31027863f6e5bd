"""`gym.make_vec` on compiled worlds: the episodes of single environments, wrappers, pictures and masks."""

import sys
from functools import partial
from pathlib import Path
from typing import Any
from unittest.mock import MagicMock

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.error import ResetNeeded
from gymnasium.vector import AutoresetMode
from gymnasium.wrappers.vector import RecordEpisodeStatistics, RecordVideo

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage import Decisions
from khepera_forage.noise import Noise
from khepera_forage.wrappers import VectorActionRepeat
from tests.arenas import POOL

MIXED = {"pickable": 1, "pushable": 1, "poisonous": 1}
SLOW = Decisions(round_duration=0.2, arm_travel_time=0.4, jaw_travel_time=2.0)
IN_POOL: dict[str, Any] = {"arena": POOL, "limit": 120, "food_types": MIXED, "foods": 2}


def make(name: str = "Corridor", num_envs: int = 5, **kwargs: Any) -> Any:
    return gym.make_vec(f"khepera_forage/{name}-v1", num_envs=num_envs, **kwargs)


@pytest.mark.parametrize(
    ("name", "kwargs"),
    [
        ("Corridor", {"limit": 20, "max_episode_steps": 7}),
        ("Rectangle", {"limit": 60, "decisions": SLOW}),
        ("Corridor", IN_POOL),
        ("CorridorWheels", IN_POOL),
    ],
    ids=("two limits", "limit", "pool", "wheels in pool"),
)
@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_worlds_have_the_episodes_of_single_environments_bit_for_bit(
    mode: AutoresetMode, name: str, kwargs: dict[str, Any]
) -> None:
    """World i of a reset with seed S is the environment with seed S + i, in the same arena and in every episode."""
    worlds = make(name, autoreset_mode=mode, **kwargs)
    modes: dict[str, Any] = {"vectorization_mode": "sync", "vector_kwargs": {"autoreset_mode": mode}}
    singles = make(name, backend="compiled", **modes, **kwargs)
    both = worlds, singles
    assert worlds.observation_space == singles.observation_space
    assert worlds.action_space == singles.action_space
    assert worlds.metadata["autoreset_mode"] == mode
    worlds.action_space.seed(0)
    ends, arenas = np.zeros(5), set()
    shown = [env.reset(seed=3) for env in both]
    for _ in range(250):
        assert_same(*shown)
        assert shown[0][0] in worlds.observation_space
        arenas |= set(worlds.get_attr("arena"))
        assert worlds.get_attr("arena") == singles.get_attr("arena")
        infos = shown[0][-1]
        actions = infos["correct_behaviour"] if name != "CorridorWheels" else worlds.action_space.sample()
        shown = [env.step(actions) for env in both]
        over = shown[0][2] | shown[0][3]
        ends += over
        if mode == AutoresetMode.DISABLED and over.any():
            assert_same(*shown)
            with pytest.raises(ResetNeeded, match="has ended"):
                worlds.step(actions)
            shown = [env.reset(options={"reset_mask": over}) for env in both]
    assert ends.min() >= 1
    assert name == "Rectangle" or len(arenas) == len(kwargs.get("arena", ["corridor"]))
    assert_same(*(env.reset(seed=[None, 40, None, None, 2**70]) for env in both))


def assert_same(one: Any, other: Any) -> None:
    """Observations, rewards, ends, and the infos that are of every world, with the same types."""
    np.testing.assert_equal(one[:-1], other[:-1])
    mine, theirs = one[-1], other[-1]
    assert set(mine) == set(theirs)
    if "final_info" in mine:
        over = mine["_final_info"]
        for name, values in mine["final_info"].items():
            np.testing.assert_array_equal(values[over], theirs["final_info"][name][over], name)
        for i in np.flatnonzero(over):
            np.testing.assert_equal(mine["final_obs"][i], theirs["final_obs"][i])
    for name in mine:
        if not name.startswith(("final", "_")):
            known = theirs.get(f"_{name}", np.ones(5, np.bool_))
            np.testing.assert_array_equal(mine[name][known], theirs[name][known], name)
            assert (mine[name].shape, mine[name].dtype.kind) == (theirs[name].shape, theirs[name].dtype.kind)


def test_pictures_of_worlds_are_those_of_single_environments() -> None:
    kwargs: Any = {"noise": Noise.none(), "render_mode": "rgb_array"}
    worlds = make("Rectangle", 3, **kwargs)
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
    assert len({frame.tobytes() for frame in frames}) == len(frames) == 3


def test_film_of_a_large_batch_shows_the_first_world(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Gymnasium's `RecordVideo` takes one picture a world; those after the first sixteen are black."""
    for module in ("moviepy", "moviepy.video.io.ImageSequenceClip"):
        monkeypatch.setitem(sys.modules, module, MagicMock())
    worlds = make(num_envs=64, render_mode="rgb_array")
    films = RecordVideo(worlds, str(tmp_path / "films"), record_first_only=True)
    films.reset(seed=0)
    frames = worlds.render()
    assert np.array_equal(films.recorded_frames, frames[:1])
    assert [frame.any() for frame in frames] == [True] * 16 + [False] * 48
    films.close()


def test_batch_tells_what_it_knows_of_each_world() -> None:
    compiled = make(arena=["corridor", "doors"], foods=2)
    plain = make(arena=["corridor", "doors"], foods=2, vectorization_mode="sync", backend="compiled")
    for env in (compiled, plain):
        env.reset(seed=3)
    names = "arena home_radius diagonal foods limit decisions largest_diagonal backend"
    for name in names.split():
        assert compiled.get_attr(name) == compiled.call(name) == plain.get_attr(name), name
    with pytest.raises(AttributeError, match="compiled worlds have no 'forager'; allowed: arena, "):
        compiled.get_attr("forager")
    assert sum(part.nbytes for part in make(num_envs=64).unwrapped.batch.worlds) <= 64 * 2048


def test_masks_hold_what_applies_and_always_what_the_teacher_does() -> None:
    compiled = make(num_envs=64, food_types=MIXED)
    plain = make(num_envs=1, vectorization_mode="sync", backend="compiled")
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


# ---------------------------------------------------------------- wrappers

in_same_step = partial(make, num_envs=4, limit=40, autoreset_mode="SameStep")


def test_vector_wrappers_are_applied_from_the_innermost_and_again_from_the_spec() -> None:
    env = in_same_step(vector_wrappers=[partial(VectorActionRepeat, rounds=3), RecordEpisodeStatistics])
    plain = VectorActionRepeat(in_same_step(), rounds=3)
    env.reset(seed=3)
    plain.reset(seed=3)
    for _ in range(14):
        *shown, info = env.step(np.zeros(4, np.int64))
        *expected, _ = plain.step(np.zeros(4, np.int64))
        np.testing.assert_equal(shown, expected)
    assert shown[3].all()
    assert info["episode"]["l"].tolist() == [14] * 4
    again = gym.make_vec(in_same_step(vector_wrappers=[VectorActionRepeat]).unwrapped.spec)
    assert isinstance(again, VectorActionRepeat)
    assert again.num_envs == 4
