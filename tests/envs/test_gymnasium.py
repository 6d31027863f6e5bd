"""What Gymnasium and its users expect of the recall environments."""

import json
import pickle
import subprocess
import sys

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import khepera_forage

IDS = [f"khepera_forage/{name}-v1" for name in ("Corridor", "Rectangle", "CorridorWheels", "RectangleWheels")]


def rollout(env_id: str, seed: int, steps: int = 60) -> list[object]:
    """Everything that an environment returns under random actions of its own action space."""
    env = gym.make(env_id)
    env.action_space.seed(seed)
    observation, info = env.reset(seed=seed)
    out: list[object] = [plain(observation), plain(info)]
    for _ in range(steps):
        observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
        out += [plain(observation), reward, terminated, truncated, plain(info)]
        if terminated or truncated:
            break
    env.close()
    return out


def plain(values: dict[str, object]) -> dict[str, object]:
    return {key: np.asarray(value).tolist() for key, value in values.items()}


@pytest.mark.parametrize("env_id", IDS)
def test_check_env_passes(env_id: str) -> None:
    env = gym.make(env_id, render_mode="rgb_array")
    check_env(env.unwrapped)
    env.close()


@pytest.mark.parametrize("env_id", IDS)
def test_same_seed_gives_the_same_rollout_bit_for_bit(env_id: str) -> None:
    assert rollout(env_id, 5) == rollout(env_id, 5)
    assert rollout(env_id, 5) != rollout(env_id, 6)


def test_same_seed_gives_the_same_rollout_in_another_process() -> None:
    code = (
        "import json, sys; sys.path.insert(0, 'tests/envs'); import test_gymnasium as t; "
        "print(json.dumps(t.rollout(t.IDS[1], 9)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert json.loads(done.stdout) == json.loads(json.dumps(rollout(IDS[1], 9)))


@pytest.mark.parametrize("env_id", IDS)
def test_spec_survives_json(env_id: str) -> None:
    spec = gym.make(env_id).spec
    assert spec is not None
    assert gym.envs.registration.EnvSpec.from_json(spec.to_json()).kwargs == spec.kwargs
    assert gym.make(gym.envs.registration.EnvSpec.from_json(spec.to_json())).reset(seed=0)


@pytest.mark.parametrize("env_id", IDS)
def test_environment_survives_pickling_before_reset(env_id: str) -> None:
    env = pickle.loads(pickle.dumps(gym.make(env_id)))
    first, _ = env.reset(seed=3)
    second, _ = gym.make(env_id).reset(seed=3)
    assert plain(first) == plain(second)


@pytest.mark.parametrize("mode", ["sync", "async"])
def test_make_vec_steps_copies_of_the_environment(mode: str) -> None:
    envs = gym.make_vec(IDS[0], num_envs=2, vectorization_mode=mode)
    observations, _ = envs.reset(seed=4)
    alone, _ = gym.make(IDS[0]).reset(seed=5)
    assert observations["robot_food_distance"][1].tolist() == alone["robot_food_distance"].tolist()
    _, rewards, _, _, infos = envs.step(envs.action_space.sample())
    assert rewards.shape == (2,)
    assert infos["steps"].tolist() == [1, 1]
    envs.close()


def test_make_works_in_a_new_process_without_an_import() -> None:
    code = "import gymnasium; print(gymnasium.make('khepera_forage:khepera_forage/Corridor-v1').reset(seed=1)[0])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "robot_home_distance" in done.stdout


def test_import_loads_no_heavy_package() -> None:
    code = "import khepera_forage, sys; print([m for m in sys.modules if m.split('.')[0] in %r])"
    heavy = {"pymunk", "sklearn", "scipy", "shapely", "matplotlib", "pygame", "cv2", "numba"}
    done = subprocess.run([sys.executable, "-c", code % heavy], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_version_is_that_of_the_installed_package() -> None:
    from importlib.metadata import version

    assert version("khepera-forage") == khepera_forage.__version__


@pytest.mark.parametrize("env_id", IDS)
def test_observations_and_infos_share_no_memory(env_id: str) -> None:
    env = gym.make(env_id)
    first, info = env.reset(seed=0)
    kept = {key: np.array(value, copy=True) for key, value in first.items()}
    second, _, _, _, later = env.step(env.action_space.sample())
    for key, value in second.items():
        if isinstance(value, np.ndarray):
            value[...] = 0
            assert not np.shares_memory(value, first[key])
    for key, value in kept.items():
        assert np.array_equal(first[key], value)
    assert not np.shares_memory(info["pose"], later["pose"])


@pytest.mark.parametrize(
    "make",
    [
        "gym.vector.AsyncVectorEnv([lambda: gym.make('khepera_forage:khepera_forage/Corridor-v1')], context='spawn')",
        "gym.make_vec('khepera_forage:khepera_forage/Corridor-v1', vectorization_mode='async',"
        " vector_kwargs={'context': 'spawn'})",
    ],
)
def test_spawned_processes_import_the_package_by_the_name(make: str) -> None:
    code = f"import gymnasium as gym; env = {make}; print(env.reset(seed=1)[0]['arms_height']); env.close()"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[[215]]"
