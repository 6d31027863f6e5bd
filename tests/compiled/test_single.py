"""`gym.make(..., backend="compiled")`: one compiled world with the interface of the pymunk environments."""

import copy
import json
import pickle
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.error import ResetNeeded
from gymnasium.utils.env_checker import check_env

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.geometry.plane import bearing_of, turn_to
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import applicable
from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.task.states import NUM_BEHAVIOURS

NAMES = ("Corridor", "Rectangle", "CorridorWheels", "RectangleWheels")
MIXED = {"pickable": 1, "pushable": 1, "poisonous": 1}


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


@pytest.mark.parametrize("name", NAMES)
def test_one_world_is_world_0_of_make_vec_bit_for_bit(name: Any) -> None:
    """Through episodes that end and begin."""
    kwargs: Any = {"limit": 90, "food_types": MIXED}
    one = _make(name, **kwargs)
    many = gym.make_vec(f"khepera_forage/{name}-v1", num_envs=3, **kwargs)
    many.action_space.seed(0)
    (obs, info), (obs_many, infos) = one.reset(seed=5), many.reset(seed=5)
    over, episodes = False, 0
    for _ in range(400):
        assert _same(obs, {key: values[0] for key, values in obs_many.items()})
        assert _same(info, {key: infos[key][0] for key in info})
        actions = infos["correct_behaviour"] if "Wheels" not in name else many.action_space.sample()
        obs_many, rewards, ends, cuts, infos = many.step(actions)
        if over:
            obs, info = one.reset()
            over = False
            episodes += 1
        else:
            obs, reward, terminated, truncated, info = one.step(actions[0])
            assert (reward, terminated, truncated) == (rewards[0], ends[0], cuts[0])
            over = terminated or truncated
    assert episodes >= 3


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


def test_places_are_as_given_and_seeds_repeat_them() -> None:
    env = _make("Rectangle", noise=Noise.none())
    options = {"start": (100, 300, 90), "foods": [(300, 200), (300, 400)]}
    obs, info = env.reset(options=options)
    assert info["pose"].tolist() == [20.0, 60.0, 90.0]
    assert obs["robot_food_distance"].tolist() == [45]
    poses = [env.reset(seed=seed)[1]["pose"].tolist() for seed in (1, 2, 1)] + [
        env.reset()[1]["pose"].tolist()
    ]
    assert poses[0] == poses[2]
    assert len({tuple(pose) for pose in poses}) == 3


def test_world_is_that_of_the_episode() -> None:
    env = _make("Corridor", noise=Noise.none())
    env.reset(seed=4)
    twin = pickle.loads(pickle.dumps(env.unwrapped))
    for _ in range(5):
        info = env.step(0)[4]
    world = env.unwrapped.world
    assert world.poses()[0][:2] == pytest.approx(info["pose"][:2] * 5.0)
    assert world.food_places()[0][:2] == tuple(env.unwrapped.layout.foods[0])
    assert [region.holes for region in world.camera.look().regions] == [2, 0]
    assert twin.world.poses()[0] == tuple(env.unwrapped.layout.starts[0])
    twin.step(0)
    assert twin.world.poses()[0] != tuple(env.unwrapped.layout.starts[0])


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


def test_bad_input_is_quoted() -> None:
    env = _make(limit=2)
    with pytest.raises(ResetNeeded):
        env.unwrapped.step(0)
    with pytest.raises(ResetNeeded):
        env.unwrapped.view()
    env.reset(seed=0)
    with pytest.raises(ValueError, match="action is 10; allowed: a whole number from 0 to 9"):
        env.step(10)
    with pytest.raises(ValueError, match="reset option 'sart' is unknown"):
        env.reset(options={"sart": 1})
    env.step(0)
    assert env.step(0)[3]
    with pytest.raises(ResetNeeded, match="ended after 2 steps"):
        env.step(0)
    wheels = _make("CorridorWheels")
    wheels.reset(seed=0)
    with pytest.raises(ValueError, match=r"allowed: four numbers in -1\.\.1"):
        wheels.step(np.full(4, 1.5))
    with pytest.raises(ValueError, match="render_mode is 'ascii'"):
        BehavioursEnv(render_mode="ascii", backend="compiled")
    with pytest.raises(ValueError, match="foods is 17"):
        _make(foods=17)
    corners = (Point(0, 0), Point(180, 0), Point(180, 180), Point(0, 180))
    box = Arena("box", corners, Point(90, 90), 80, Pose(90, 90, 0), (Point(30, 30),))
    small = _make(arena=box)
    with pytest.raises(ValueError, match="no room for a robot and 1 food"):
        small.reset(seed=0)


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
