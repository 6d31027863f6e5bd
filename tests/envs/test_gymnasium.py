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


def test_version_is_that_of_the_installed_package() -> None:
    from importlib.metadata import version

    assert version("khepera-forage") == khepera_forage.__version__


def test_compiled_worlds_need_no_pymunk() -> None:
    code = (
        "import sys; sys.modules['pymunk'] = None; import gymnasium as gym, khepera_forage; "
        "gym.make_vec('khepera_forage/Corridor-v1', num_envs=2)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_spawned_processes_import_the_package_by_the_name() -> None:
    code = (
        "import gymnasium as gym; env = gym.make_vec('khepera_forage:khepera_forage/Corridor-v1', "
        "vectorization_mode='async', vector_kwargs={'context': 'spawn'}); "
        "print(env.reset(seed=1)[0]['arms_height']); env.close()"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[[215]]"
