"""Every argument of every environment survives a spec that is stored as JSON, as Minari stores it."""

from dataclasses import replace
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from gymnasium.envs.registration import EnvSpec
from gymnasium.vector import AutoresetMode

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage import Decisions, Noise
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.sim.arenas.procedural import ProceduralArenas
from khepera_forage.task.states import FoodType
from tests.arenas import BLOCKS, HALL

SMALL = replace(DIFFICULTIES["easy"], name="small", foods=1)
ARGUMENTS: list[dict[str, Any]] = [
    {"noise": Noise.only("wheels")},
    {"noise": "none", "foods": 2, "limit": 30, "render_mode": "rgb_array"},
    {"decisions": Decisions(next_to_food=22), "food_types": FoodType.PUSHABLE},
    {"food_types": {FoodType.PUSHABLE: 1.0, "poisonous": 1.0}},
    {"arena": BLOCKS},
    {"robot": "toio", "food_types": "PUSHABLE"},
    {"arena": [BLOCKS, "corridor", HALL]},
    {"arena": ProceduralArenas("easy", "test", num_levels=3)},
    {"difficulty": SMALL, "split": "test", "num_levels": 3, "start_level": 1},
]


def assert_alike(env: Any, again: Any, action: Any) -> None:
    for seed in range(2):
        np.testing.assert_equal(again.reset(seed=seed), env.reset(seed=seed))
        for _ in range(3):
            np.testing.assert_equal(again.step(action), env.step(action))


def name_of(given: dict[str, Any], kind: str) -> str:
    return f"khepera_forage/{'Procedural' if 'difficulty' in given else 'Corridor'}{kind}-v1"


@pytest.mark.parametrize("backend", ["pymunk", "compiled"])
@pytest.mark.parametrize("given", ARGUMENTS, ids=str)
def test_environment_of_a_stored_spec_is_the_same(given: dict[str, Any], backend: str) -> None:
    env = gym.make(name_of(given, ""), backend=backend, max_episode_steps=40, **given)
    assert env.spec is not None
    assert_alike(env, gym.make(EnvSpec.from_json(env.spec.to_json())), 0)


@pytest.mark.parametrize("mode", ["sync", "vector_entry_point"])
@pytest.mark.parametrize("given", ARGUMENTS, ids=str)
def test_vector_environment_of_a_stored_spec_is_the_same(given: dict[str, Any], mode: str) -> None:
    if mode == "vector_entry_point":
        given = {"autoreset_mode": AutoresetMode.SAME_STEP, "max_episode_steps": 40} | given
    name = name_of(given, "Wheels")
    env = gym.make_vec(name, num_envs=2, vectorization_mode=mode, **given)
    again = gym.make_vec(EnvSpec.from_json(env.unwrapped.spec.to_json()))  # type: ignore[union-attr]
    assert again.metadata["autoreset_mode"] == env.metadata["autoreset_mode"]
    assert_alike(env, again, np.zeros((2, 4), np.float32))
