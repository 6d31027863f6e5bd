"""Training environments on compiled bodies."""

from typing import Any

import numpy as np
import pettingzoo
import pytest
from pettingzoo.test import api_test, parallel_api_test, parallel_seed_test

from khepera_forage.envs import paired_arenas_v1, paired_corridors_v1

pytest.importorskip("numba")


def _attempt(env: Any, seed: int) -> dict[str, Any]:
    """One attempt in which everybody does what the teacher says; returns the infos of its end."""
    env.reset(seed=seed)
    said = 10
    for agent in env.agent_iter():
        observation, _, terminated, truncated, _ = env.last()
        if terminated or truncated:
            return dict(env.infos)
        if agent == "teacher_0":
            said = 10 if observation[6] else env.infos[agent]["correct_behaviour"]
        env.step(said)
    raise AssertionError("the attempt has no end")


def test_pettingzoo_checks_pass_on_compiled_bodies() -> None:
    api_test(paired_corridors_v1.env(backend="compiled", max_cycles=20), num_cycles=60)
    parallel_api_test(paired_corridors_v1.parallel_env(backend="compiled", max_cycles=20), num_cycles=60)
    parallel_seed_test(
        lambda: paired_corridors_v1.parallel_env(backend="compiled", max_cycles=20), num_cycles=20
    )


@pytest.mark.parametrize("learners", [1, 3])
def test_attempts_are_complete_about_as_often_as_on_pymunk(learners: int) -> None:
    complete = {}
    for backend in ("pymunk", "compiled"):
        env = paired_corridors_v1.env(backend=backend, num_learners=learners)
        assert env.unwrapped.backend == backend
        ends = [_attempt(env, seed) for seed in range(8)]
        complete[backend] = sum(end["teacher_0"]["complete"] for end in ends)
        if learners == 1:
            delivered = sum(end["learner_0"]["delivered"] for end in ends)
            assert delivered >= 6
    assert abs(complete["pymunk"] - complete["compiled"]) <= 4


def test_attempts_begin_alike_on_both_backends() -> None:
    layouts = []
    for backend in ("pymunk", "compiled"):
        env: Any = paired_arenas_v1.env(arena="t_maze", backend=backend, noise="none")
        env.reset(seed=4)
        world = env.unwrapped.world
        layouts.append([*(pose[:2] for pose in world.poses()), *(food[:2] for food in world.food_places())])
    assert np.allclose(layouts[0], layouts[1])


def test_backend_is_an_argument_of_the_registered_environments_and_checked() -> None:
    env: Any = pettingzoo.make("parallel", "khepera_forage/PairedCorridors-v1", backend="compiled")
    env.reset(seed=0)
    assert env.unwrapped.backend == "compiled"
    with pytest.raises(ValueError, match="backend is 'mujoco'; allowed: 'pymunk', 'compiled'"):
        paired_corridors_v1.env(backend="mujoco")
