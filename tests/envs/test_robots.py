"""Robots without a gripper, in simulation: they push food home, and leave poison where it is."""

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

pytest.importorskip("numba")

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.envs import paired_arenas_v1
from khepera_forage.policies.teacher import Teacher

ROBOTS = ("toio", "e-puck2")
BACKENDS = ("pymunk", "compiled")


def make(arena: str, robot: str, backend: str, **kwargs: Any) -> Any:
    env = gym.make(
        f"khepera_forage/{arena}-v1", disable_env_checker=True, robot=robot, backend=backend, **kwargs
    )
    return env.unwrapped


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize("arena", ["Corridor", "Rectangle"])
def test_teacher_pushes_food_home(arena: str, robot: str, backend: str) -> None:
    env = make(arena, robot, backend, food_types="PUSHABLE", limit=1000)
    teacher, delivered = Teacher.of(env), 0
    for seed in range(20):
        observation, info = env.reset(seed=seed)
        over = False
        while not over:
            observation, _, terminated, truncated, info = env.step(teacher.act(observation))
            over = terminated or truncated
            senses = env.world.robots[0].sense()
            assert (senses.arm, senses.jaw) == (255, 200), "the arm counts as lowered, the jaw as open"
        delivered += info["delivered"]
    assert delivered >= 19


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("robot", ROBOTS)
def test_teacher_leaves_poison_among_pushable_food(robot: str, backend: str) -> None:
    odds = {"PUSHABLE": 0.5, "POISONOUS": 0.5}
    env = make("Rectangle", robot, backend, food_types=odds, foods=3, limit=2500)
    teacher, finished = Teacher.of(env), 0
    for seed in range(4):
        observation, info = env.reset(seed=seed)
        over = False
        while not over:
            observation, _, terminated, truncated, info = env.step(teacher.act(observation))
            over = terminated or truncated
        finished += terminated
        assert info["poison_home"] == 0
    assert finished >= 3


@pytest.mark.parametrize("backend", BACKENDS)
@pytest.mark.parametrize("robot", ROBOTS)
@pytest.mark.parametrize(("food", "delivered"), [("PUSHABLE", 1), ("POISONOUS", 0)])
def test_learners_do_what_they_hear(robot: str, backend: str, food: str, delivered: int) -> None:
    env = paired_arenas_v1.env(num_learners=2, robot=robot, backend=backend, food_types=food)
    teacher = Teacher(env.unwrapped.home_radius, env.unwrapped.decisions)
    env.reset(seed=0)
    infos = {}
    for agent in env.agent_iter():
        observation, _, terminated, truncated, info = env.last()
        if terminated or truncated:
            infos[agent] = info
            env.step(None)
        else:
            env.step(int(teacher.act(observation)) if agent == "teacher_0" else int(observation[5]))
    assert [(info["complete"], info["delivered"]) for info in infos.values()] == [(1, delivered)] * 3


@pytest.mark.parametrize("backend", BACKENDS)
def test_speeds_are_limited_to_what_the_robot_can_do(backend: str) -> None:
    env = make("CorridorWheels", "e-puck2", backend)
    env.reset(seed=0)
    env.step(np.ones(4, np.float32))
    before = env.world.robots[0].sense()
    env.step(np.ones(4, np.float32))
    after = env.world.robots[0].sense()
    assert after.left_pulses - before.left_pulses == 130, "an e-puck2 drives at most 13 speed units"


def test_impossible_arguments_are_refused() -> None:
    with pytest.raises(ValueError, match="robot is 'nao'; allowed: 'khepera', 'e-puck2', 'toio'"):
        make("Corridor", "nao", "pymunk")
    for food in ("PICKABLE", {"PICKABLE": 0.1, "PUSHABLE": 0.9}):
        with pytest.raises(
            ValueError, match=r"PICKABLE.*allowed for robots without a gripper: PUSHABLE and POISONOUS"
        ):
            make("Corridor", "toio", "pymunk", food_types=food)
