"""What Gymnasium and its users expect of the recall environments, on both backends."""

import copy
import json
import pickle
import subprocess
import sys
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import khepera_forage

pytest.importorskip("numba")

IDS = [f"khepera_forage/{name}-v1" for name in ("Corridor", "Rectangle", "CorridorWheels", "RectangleWheels")]
EVERY = sorted(name for name in gym.registry if name.startswith("khepera_forage/") and name.endswith("v1"))
on_both_backends = pytest.mark.parametrize("backend", ["pymunk", "compiled"])


def rollout(env: Any, seed: int | None, steps: int = 60) -> list[object]:
    """Everything that an environment returns under random actions of its own action space."""
    out: list[object] = []
    if seed is not None:
        env.action_space.seed(seed)
        out += map(plain, env.reset(seed=seed))
    for _ in range(steps):
        observation, reward, terminated, truncated, info = env.step(env.action_space.sample())
        out += [plain(observation), reward, terminated, truncated, plain(info)]
        if terminated or truncated:
            break
    return out


def plain(values: dict[str, object]) -> dict[str, object]:
    return {key: np.asarray(value).tolist() for key, value in values.items()}


@on_both_backends
@pytest.mark.parametrize("env_id", EVERY)
def test_check_env_passes(env_id: str, backend: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    env: Any = gym.make(env_id, render_mode="rgb_array", backend=backend).unwrapped
    assert env.backend == backend
    check_env(env, skip_render_check=env_id not in IDS)
    env.close()


@on_both_backends
@pytest.mark.parametrize("env_id", IDS)
def test_same_seed_gives_the_same_rollout_also_in_copies(env_id: str, backend: str) -> None:
    env = gym.make(env_id, backend=backend)
    new = pickle.loads(pickle.dumps(env))
    run = rollout(env, 5)
    assert rollout(new, 5) == run == rollout(env, 5)
    assert rollout(new, 6) != run
    twins = [pickle.loads(pickle.dumps(env)), copy.deepcopy(env)]
    expected = rollout(env, None, 10)
    for twin in twins:
        assert rollout(twin, None, 10) == expected


def test_same_seed_gives_the_same_rollout_in_another_process() -> None:
    code = (
        "import json, sys; sys.path.insert(0, 'tests/envs'); import test_gymnasium as t; "
        "print(json.dumps([t.rollout(t.gym.make(t.IDS[1], backend=b), 9) for b in ('pymunk', 'compiled')]))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    expected = [rollout(gym.make(IDS[1], backend=backend), 9) for backend in ("pymunk", "compiled")]
    assert json.loads(done.stdout) == json.loads(json.dumps(expected))


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


def test_spawned_processes_import_the_package_by_the_name() -> None:
    code = (
        "import gymnasium as gym; env = gym.make_vec('khepera_forage:khepera_forage/Corridor-v1', "
        "vectorization_mode='async', vector_kwargs={'context': 'spawn'}); "
        "print(env.reset(seed=1)[0]['arms_height']); env.close()"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[[215]]"
