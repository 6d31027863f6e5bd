"""`gym.make(..., backend="compiled")`: one compiled world with the interface of the pymunk environments."""

import copy
import json
import pickle
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.utils.env_checker import check_env

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.geometry.angles import bearing_of, turn_to
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import applicable
from khepera_forage.task.states import NUM_BEHAVIOURS

NAMES = ("Corridor", "Rectangle", "CorridorWheels", "RectangleWheels")


def _make(name: Any = "Corridor", **kwargs: Any) -> Any:
    return gym.make(f"khepera_forage/{name}-v1", backend="compiled", **kwargs)


def _same(one: Any, two: Any) -> bool:
    return set(one) == set(two) and all(np.array_equal(one[key], two[key]) for key in one)


@pytest.mark.parametrize("name", NAMES)
def test_gymnasium_checker_passes(name: Any) -> None:
    env = _make(name)
    assert env.unwrapped.backend == "compiled"
    check_env(env.unwrapped)
    env.close()


@pytest.mark.parametrize("name", NAMES)
def test_spaces_types_and_infos_are_those_on_pymunk(name: Any) -> None:
    env, plain = _make(name), gym.make(f"khepera_forage/{name}-v1")
    assert env.observation_space == plain.observation_space
    assert env.action_space == plain.action_space
    assert env.metadata == plain.metadata
    env.action_space.seed(0)
    (obs, info), (plain_obs, plain_info) = env.reset(seed=1), plain.reset(seed=1)
    for _ in range(5):
        assert list(obs) == list(plain_obs)
        assert list(info) == list(plain_info)
        for got, expected in [(obs[k], plain_obs[k]) for k in obs] + [(info[k], plain_info[k]) for k in info]:
            assert type(got) is type(expected)
            assert np.asarray(got).dtype == np.asarray(expected).dtype
            assert np.shape(got) == np.shape(expected)
        action = env.action_space.sample()
        obs, reward, terminated, truncated, info = env.step(action)
        plain_obs, *rest, plain_info = plain.step(action)
        assert [type(v) for v in (reward, terminated, truncated)] == [type(v) for v in rest]
    plain.close()


@pytest.mark.parametrize("name", ["Corridor", "RectangleWheels"])
def test_an_episode_is_that_on_pymunk_bit_for_bit_until_something_is_touched(name: Any) -> None:
    envs = [gym.make(f"khepera_forage/{name}-v1", backend=backend) for backend in ("pymunk", "compiled")]
    options = {"start": (90, 115, 0), "foods": [(400, 115)]} if name == "Corridor" else None
    for reset in ({"seed": 3, "options": options}, {"options": options}):
        (obs, info), (other, other_info) = (env.reset(**reset) for env in envs)
        for _ in range(15 if options else 1):
            assert _same(obs, other)
            assert _same(info, other_info)
            action = info["correct_behaviour"] if options else np.zeros(4)
            (obs, *_, info), (other, *_, other_info) = (env.step(action) for env in envs)


@pytest.mark.parametrize("name", ["Rectangle", "RectangleWheels"])
def test_rollouts_repeat_in_fresh_arrays_and_in_copies(name: Any) -> None:
    def roll(env: Any, steps: Any) -> Any:
        return [env.step(env.action_space.sample()) for _ in range(steps)]

    env = _make(name)
    assert EnvSpec.from_json(env.spec.to_json()).kwargs == json.loads(env.spec.to_json())["kwargs"]
    runs = []
    for _ in range(2):
        env.reset(seed=2)
        env.action_space.seed(2)
        runs.append(roll(env, 30))
    for a, b in zip(*runs, strict=True):
        assert _same(a[0], b[0])
        assert a[1:4] == b[1:4]
        assert _same(a[4], b[4])
    arrays = [v for step in runs[0][:3] for v in (*step[0].values(), step[4]["pose"]) if v.ndim]
    for i, array in enumerate(arrays):
        assert not any(np.shares_memory(array, other) for other in arrays[:i])
    twins = [pickle.loads(pickle.dumps(env)), copy.deepcopy(env)]
    expected = roll(env, 10)
    for twin in twins:
        for a, b in zip(expected, roll(twin, 10), strict=True):
            assert _same(a[0], b[0])


def test_view_shows_the_true_world() -> None:
    env = _make("Corridor", noise=Noise.none(), render_mode="rgb_array")
    _, info = env.reset(seed=3)
    first = env.render()
    over = False
    pictures, seen = [first], set()
    while not over:
        executed = info["correct_behaviour"]
        _, _, terminated, truncated, info = env.step(executed)
        over = terminated or truncated
        view = env.unwrapped.view()
        (robot,), (food,) = view.robots, view.foods
        assert robot.pose[:2] == pytest.approx(info["pose"][:2] * 5.0)
        assert (view.step, view.delivered) == (info["steps"], info["delivered"])
        assert (robot.state, robot.executed) == (info["state"], executed)
        seen.add((food.lifted, food.delivered))
    pictures.append(env.render())
    assert pictures[0].shape == pictures[1].shape
    assert pictures[0].dtype == np.uint8
    assert not np.array_equal(*pictures)
    assert seen == {(False, False), (True, False), (False, True)}
    env.close()


@pytest.mark.parametrize(
    ("name", "arguments", "least"),
    [("Doors", {}, 200), ("Rectangle", {"foods": 5, "food_types": {"pickable": 1, "poisonous": 1}}, 10)],
    ids=["around walls", "past poison"],
)
def test_robots_that_do_not_go_straight_home_are_commanded_by_the_rules(
    name: str, arguments: dict[str, Any], least: int
) -> None:
    """Kernels look up the way home when a behaviour uses it; the robot of the environment always knows it."""
    env = _make(name, **arguments).unwrapped
    rng, around = np.random.default_rng(2), 0
    for seed in range(6):
        _, info = env.reset(seed=seed)
        for step in range(250):
            behaviour = int(rng.integers(NUM_BEHAVIOURS)) if step % 4 == 0 else info["correct_behaviour"]
            known = env.forager
            straight = bearing_of(known.raw.home_x - known.raw.x, known.raw.home_y - known.raw.y)
            around += abs(turn_to(straight, known.raw.orientation) - known.raw.home_bearing) > 1.0
            motors = applicable(known.motors_for(behaviour))
            _, _, terminated, _, info = env.step(behaviour)
            robot = env._recalls._batch.worlds.robots[0, 0]
            given = [float(robot[name]) for name in ("left", "right", "arm_target", "jaw_target")]
            assert given == pytest.approx(list(motors))
            if terminated:
                break
    assert around > least
