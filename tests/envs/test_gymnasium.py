"""What Gymnasium and its users expect of the recall environments, on both backends."""

import subprocess
import sys
from typing import Any

import gymnasium as gym
import pytest
from gymnasium.utils.env_checker import check_env

import khepera_forage

pytest.importorskip("numba")

IDS = [f"khepera_forage/{name}-v1" for name in ("Corridor", "Rectangle", "CorridorWheels", "RectangleWheels")]
EVERY = sorted(name for name in gym.registry if name.startswith("khepera_forage/") and name.endswith("v1"))


@pytest.mark.parametrize(
    ("env_id", "backend"), [*((env_id, "pymunk") for env_id in EVERY), *((env_id, "compiled") for env_id in IDS)]
)
def test_check_env_passes(env_id: str, backend: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    env: Any = gym.make(env_id, render_mode="rgb_array", backend=backend).unwrapped
    assert env.backend == backend
    check_env(env, skip_render_check=env_id not in IDS)
    env.close()


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


def test_spawned_processes_import_the_package_by_the_name() -> None:
    code = (
        "import gymnasium as gym; env = gym.make_vec('khepera_forage:khepera_forage/Corridor-v1', "
        "vectorization_mode='async', vector_kwargs={'context': 'spawn'}); "
        "print(env.reset(seed=1)[0]['arms_height']); env.close()"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[[215]]"
