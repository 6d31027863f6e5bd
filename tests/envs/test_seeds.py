"""What a seed decides: starts, food places and food types of an episode and of those that follow."""

from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.counter_rng import key_of
from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.envs.layouts import training_layout
from khepera_forage.envs.recall import RecallEnv
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.envs.wheels_env import WheelsEnv
from khepera_forage.noise import Noise
from khepera_forage.sim.world import Layout
from khepera_forage.task.placement import layout_key

MIXED = {"PICKABLE": 1.0, "PUSHABLE": 1.0, "POISONOUS": 1.0}


def begun(env: RecallEnv[Any], seed: int | None, **options: Any) -> tuple[Layout, list[int]]:
    """Layout and food types of a new episode."""
    env.reset(seed=seed, options=options)
    return env.layout, [food.type for food in env.forager.tracker.foods]


@pytest.mark.parametrize("kind", [BehavioursEnv, WheelsEnv])
def test_seed_decides_this_episode_and_those_that_follow(kind: type[RecallEnv[Any]]) -> None:
    runs = []
    for _ in range(2):
        env = kind(arena="rectangle", foods=3, food_types=MIXED)
        runs.append([begun(env, 5), begun(env, None), begun(env, None), begun(env, 5), begun(env, None)])
    first, second, third, again, after = runs[0]
    assert runs[0] == runs[1]
    assert (again, after) == (first, second)
    assert len({first[0], second[0], third[0]}) == 3


@pytest.mark.parametrize(
    "make",
    [
        BehavioursEnv,
        lambda: BehavioursEnv(backend="compiled"),
        TrainingEnv,
        lambda: gym.make_vec("khepera_forage/Corridor-v1", num_envs=2),
    ],
)
def test_generator_that_was_set_decides_the_episodes_that_follow(make: Any) -> None:
    env = make()

    def places() -> list[Any]:
        if isinstance(env, gym.vector.VectorEnv):
            return env.reset()[1]["pose"].tolist()  # type: ignore[no-any-return]
        env.reset()
        return [(robot.x, robot.y) for robot in env.world.poses()]

    episodes = [places()]
    for seed in (1, 2, 1):
        env.np_random = np.random.default_rng(seed)
        episodes.append([places(), places()])
    _, one, other, again = episodes
    assert one == again
    assert one != other
    assert one[0] != one[1]


def test_given_start_leaves_the_food_of_the_seed() -> None:
    env = BehavioursEnv(arena="rectangle", foods=1)
    drawn, _ = begun(env, 3)
    start_given, _ = begun(env, 3, start=(560, 60, 180))
    foods_given, _ = begun(env, 3, foods=[(560, 60)])
    assert start_given.starts[0][:2] == (560, 60)
    assert start_given.foods == drawn.foods
    assert foods_given == Layout(drawn.starts, ((560, 60),))  # type: ignore[arg-type]


def test_training_seed_decides_this_episode_and_those_that_follow() -> None:
    runs = []
    for _ in range(2):
        env = TrainingEnv(food_types=MIXED)
        episodes = []
        for seed in (5, None, None):
            env.reset(seed=seed)
            types = [[food.type for food in forager.tracker.foods] for forager in env.foragers]
            assert types[0] == types[1], "corresponding food"
            episodes.append((env.world.poses(), env.world.food_places(), types[0]))
        runs.append(episodes)
    assert runs[0] == runs[1]
    assert len({poses for poses, _, _ in runs[0]}) == 3
    layout = training_layout(env.arenas, Noise.laboratory(), layout_key(key_of(5), 0))
    assert runs[0][0][0] == layout.starts
