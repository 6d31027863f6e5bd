"""Training environments on compiled bodies."""

import warnings
from typing import Any

import numpy as np
import pettingzoo
import pytest

from khepera_forage.envs import paired_arenas_v1, paired_corridors_v1, paired_corridors_wheels_v1
from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, MAX_SPEED, Motors, applicable

with warnings.catch_warnings():
    # PettingZoo's own test module imports one of its deprecated environments.
    warnings.simplefilter("ignore", DeprecationWarning)
    from pettingzoo.test import api_test, parallel_api_test, parallel_seed_test

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


def _action(motors: Motors) -> Any:
    """The action that commands these motors."""
    left, right, arm, jaw = applicable(motors)
    raised = 1 - 2 * (arm - ARM_RAISED) / (ARM_DOWN - ARM_RAISED)
    return np.array((left / MAX_SPEED, right / MAX_SPEED, raised, 1.0 if jaw == 0 else -1.0))


@pytest.mark.parametrize("backend", ["pymunk", "compiled"])
def test_wheels_that_do_what_the_behaviours_command_train_as_the_behaviours_do(backend: str) -> None:
    """Round by round, bit for bit; learners hear the behaviour that the teacher's motors mean."""
    behaviours = paired_corridors_v1.raw_env(backend=backend)
    wheels = paired_corridors_wheels_v1.raw_env(backend=backend)
    behaviours.reset(seed=3)
    wheels.reset(seed=3)
    while not any((*behaviours.terminations.values(), *behaviours.truncations.values())):
        said = (
            10 if behaviours.observe("teacher_0")[6] else behaviours.infos["teacher_0"]["correct_behaviour"]
        )
        for i, agent in enumerate(behaviours.agents):
            assert wheels.observe(agent)[-2:].tolist() == behaviours.observe(agent)[5:].tolist()
            action = _action(wheels.foragers[i].motors_for(said))
            behaviours.step(said)
            wheels.step(action)
        assert wheels.world.poses() == behaviours.world.poses()
        assert wheels.terminations == behaviours.terminations
        assert wheels.truncations == behaviours.truncations
    assert wheels.infos["learner_0"]["delivered"] == behaviours.infos["learner_0"]["delivered"] == 1


def test_wheels_environment_passes_the_checks_and_refuses_other_actions() -> None:
    made: Any = pettingzoo.make("parallel", "khepera_forage/PairedCorridorsWheels-v1", max_cycles=20)
    parallel_api_test(made, num_cycles=60)
    api_test(paired_corridors_wheels_v1.env(max_cycles=20, num_learners=2), num_cycles=60)
    made.reset(seed=0)
    with pytest.raises(ValueError, match=r"allowed: four numbers in -1\.\.1"):
        made.step({agent: np.full(4, 1.5) for agent in made.agents})
