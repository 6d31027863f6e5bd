"""What Gymnasium, PettingZoo and their users expect of the environments, on both backends."""

import subprocess
import sys
import warnings
from collections.abc import Callable
from importlib.metadata import version
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import khepera_forage
from khepera_forage.envs import (
    paired_arenas_v1,
    paired_corridors_v0,
    paired_corridors_v1,
    paired_corridors_wheels_v1,
    paired_procedural_v1,
)

with warnings.catch_warnings():
    # PettingZoo's own test module imports one of its deprecated environments.
    warnings.simplefilter("ignore", DeprecationWarning)
    from pettingzoo.test import api_test, max_cycles_test, parallel_api_test, parallel_seed_test, render_test, seed_test

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


# ---------------------------------------------------------------- PettingZoo


@pytest.mark.parametrize(
    ("module", "kwargs"),
    [
        (paired_corridors_v0, {}),
        (paired_corridors_v1, {}),
        (paired_corridors_v1, {"num_learners": 3}),
        (paired_corridors_v1, {"backend": "compiled"}),
        (paired_corridors_wheels_v1, {"num_learners": 2}),
        (paired_arenas_v1, {"arena": "t_maze"}),
        (paired_arenas_v1, {"arena": "mixed_foods"}),
        (paired_procedural_v1, {"num_levels": 3}),
    ],
)
def test_tests_of_pettingzoo_pass(module: Any, kwargs: dict[str, Any]) -> None:
    api_test(module.env(max_cycles=30, **kwargs), num_cycles=100)
    parallel_api_test(module.parallel_env(max_cycles=30, **kwargs), num_cycles=60)
    seed_test(lambda: module.env(max_cycles=50, **kwargs), num_cycles=60)
    parallel_seed_test(lambda: module.parallel_env(max_cycles=20, **kwargs), num_cycles=20)
    max_cycles_test(module)


def test_render_test_passes() -> None:
    def make(**kwargs: Any) -> Any:
        return paired_corridors_v1.env(max_cycles=30, **kwargs)

    modes: dict[str, Callable[[Any], bool]] = {"rgb_array": lambda frame: frame.shape[2] == 3, "human": lambda _: True}
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SDL_VIDEODRIVER", "dummy")
        render_test(make, modes)


@pytest.mark.parametrize("module", [paired_corridors_v1, paired_corridors_wheels_v1])
@pytest.mark.parametrize("form", ["env", "parallel_env"])
def test_state_is_what_all_agents_observe(module: Any, form: str) -> None:
    env = getattr(module, form)(num_learners=2)
    env.reset(seed=1)
    own = env.unwrapped
    np.testing.assert_array_equal(env.state(), np.concatenate([own.observe(a) for a in own.possible_agents]))
    assert env.state_space == own.state_space
    assert env.state_space.contains(env.state())
