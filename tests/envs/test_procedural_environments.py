"""Environments whose episodes take place in procedural arenas, for one robot, many worlds and paired training."""

from typing import Any

import gymnasium as gym
import pettingzoo
import pytest
from gymnasium.utils.env_checker import check_env

from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.sim.arenas.procedural import ProceduralArenas

LEVELS: dict[str, Any] = {"difficulty": "easy", "split": "test", "num_levels": 30}
NAMES = {arena.name for arena in ProceduralArenas("easy", "test", 30)}


@pytest.mark.parametrize("env_id", ["Procedural-v1", "ProceduralWheels-v1"])
@pytest.mark.parametrize("backend", ["pymunk", "compiled"])
def test_environment_of_levels_passes_the_checker(env_id: str, backend: str) -> None:
    env = gym.make(f"khepera_forage/{env_id}", backend=backend, **LEVELS)
    check_env(env.unwrapped, skip_render_check=True)
    assert env.spec is not None
    assert env.spec.max_episode_steps is None


def test_seed_has_the_same_level_and_layout_on_both_backends() -> None:
    environments: list[Any] = [
        gym.make("khepera_forage/Procedural-v1", backend=backend, **LEVELS).unwrapped
        for backend in ("pymunk", "compiled")
    ]
    names = set()
    for seed in range(10):
        for env in environments:
            env.reset(seed=seed)
        one, other = environments
        assert one.arena == other.arena
        assert one.layout == other.layout
        names.add(one.arena.name)
    assert 3 < len(names) <= 10
    assert names <= NAMES


def test_settings_are_those_of_the_difficulty() -> None:
    env: Any = gym.make("khepera_forage/Procedural-v1", difficulty="hard", num_levels=3).unwrapped
    env.reset(seed=0)
    assert len(env.layout.foods) == DIFFICULTIES["hard"].foods
    assert env.limit == DIFFICULTIES["hard"].limit


def test_paired_training_takes_place_in_the_levels() -> None:
    env = pettingzoo.make("parallel", "khepera_forage/PairedProcedural-v1", **LEVELS)
    names, observations = [], []
    for seed in (0, 1, 2, 3, 0):
        first, _ = env.reset(seed=seed)
        observations.append({agent: values.tolist() for agent, values in first.items()})
        names.append(env.unwrapped.arenas[0].name)
        assert len(env.unwrapped.arenas) == 2
    assert set(names) <= NAMES
    assert len(set(names)) > 1
    assert names[0] == names[-1]
    assert observations[0] == observations[-1]
