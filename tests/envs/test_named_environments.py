"""The environments of the family and of procedural arenas, by name."""

from dataclasses import replace
from typing import Any

import gymnasium as gym
import pettingzoo
import pytest

import khepera_forage  # noqa: F401  (registers the environments)
from khepera_forage import Noise
from khepera_forage.envs import paired_arenas_v1
from khepera_forage.envs.arena_settings import environment_name, procedural_settings, settings_of
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES
from khepera_forage.sim.arenas.named import FAMILY, family_arena, step_limit
from khepera_forage.sim.arenas.procedural import ProceduralArenas
from khepera_forage.sim.waypoints import longest_path


def test_all_environments_are_registered() -> None:
    own = {env_id for env_id in gym.registry if env_id.startswith("khepera_forage/")}
    families = ("TMaze", "LRoom", "Doors", "Obstacles", "ManyFoods", "MixedFoods", "Procedural")
    expected = {f"khepera_forage/{name}{kind}-v1" for name in families for kind in ("", "Wheels")}
    for name in ("Corridor", "Rectangle"):
        for kind in ("", "Wheels"):
            expected |= {f"khepera_forage/{name}{kind}-{version}" for version in ("v0", "v1")}
    assert own == expected
    paired = {f"khepera_forage/Paired{name}-v1" for name in (*families, "Corridors")}
    paired |= {"khepera_forage/PairedCorridors-v0", "khepera_forage/PairedCorridorsWheels-v1"}
    for registry in (pettingzoo.aec_registry, pettingzoo.parallel_registry):
        assert {env_id for env_id in registry if env_id.startswith("khepera_forage/")} == paired


@pytest.mark.parametrize("arena", FAMILY)
def test_environments_have_the_arena_and_its_settings(arena: str) -> None:
    name, own = environment_name(arena), family_arena(arena)
    for kind in ("", "Wheels"):
        env: Any = gym.make(f"khepera_forage/{name}{kind}-v1").unwrapped
        assert (env.arena, env.foods, env.limit) == (own, len(FAMILY[arena].foods), FAMILY[arena].limit)
    aec: Any = pettingzoo.make("aec", f"khepera_forage/Paired{name}-v1")
    assert aec.metadata["name"] == f"paired_{arena}_v1"
    first, second = aec.unwrapped.arenas
    assert first == own
    assert first.bounds != second.bounds


def test_paired_environment_has_the_settings_of_its_arena() -> None:
    env: Any = paired_arenas_v1.raw_env("mixed_foods")
    assert env.max_cycles == FAMILY["mixed_foods"].limit * 1.2
    pool: Any = paired_arenas_v1.raw_env(arena=["t_maze", "doors"], max_cycles=2500)
    assert pool.metadata["name"] == "paired_arenas_v1"
    other: Any = paired_arenas_v1.raw_env("corridor", max_cycles=70, num_learners=2)
    assert (other.max_cycles, other.arenas[0].name, len(other.arenas)) == (70, "corridor", 3)


# ---------------------------------------------------------------- procedural arenas


LEVELS: dict[str, Any] = {"difficulty": "easy", "split": "test", "num_levels": 30}
LEVEL_NAMES = {arena.name for arena in ProceduralArenas("easy", "test", 30)}


def test_settings_are_those_of_the_difficulty() -> None:
    env: Any = gym.make("khepera_forage/Procedural-v1", difficulty="hard", num_levels=3).unwrapped
    env.reset(seed=0)
    assert len(env.layout.foods) == DIFFICULTIES["hard"].foods
    assert env.limit == DIFFICULTIES["hard"].limit
    assert procedural_settings("hard", "train", 1, 0)["noise"] == Noise.laboratory()
    env, names = gym.make("khepera_forage/Procedural-v1", **LEVELS).unwrapped, set()
    for seed in range(10):
        env.reset(seed=seed)
        names.add(env.arena.name)
    assert len(names) > 3
    assert names <= LEVEL_NAMES


def test_paired_training_takes_place_in_the_levels() -> None:
    env = pettingzoo.make("parallel", "khepera_forage/PairedProcedural-v1", **LEVELS)
    names = []
    for seed in (0, 1, 2, 3, 0):
        env.reset(seed=seed)
        assert len(env.unwrapped.arenas) == 2
        names.append(env.unwrapped.arenas[0].name)
    assert 1 < len(set(names)) < 5
    assert set(names) <= LEVEL_NAMES
    assert names[0] == names[-1]


def test_arena_of_ones_own_has_a_step_limit_that_follows_from_its_paths() -> None:
    arena = family_arena("doors")
    assert settings_of(arena) == {"arena": arena, "foods": 2, "limit": step_limit(2, longest_path(arena))}
    wide = replace(family_arena("many_foods"), foods=family_arena("many_foods").foods[:1])
    assert settings_of(wide)["limit"] == step_limit(1, 1200)
    assert step_limit(1, 100) == 500, "that of the thesis at least"
