"""Environments with several arenas: a seed has the same arenas in every form, and worlds keep their contract."""

from typing import Any

import gymnasium as gym
import numpy as np
import pettingzoo
import pytest

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.counter_rng import key_of
from khepera_forage.task.placement import arena_number
from tests.arenas import BLOCKS, HALL, POOL
from tests.contracts.suites import SimulationContract, Stage

pytest.importorskip("numba")

NAME = "khepera_forage/Corridor-v1"
PLACES = {"start": (200, 300, 29), "foods": [(500, 150)]}
"""Free in all arenas."""


@pytest.fixture(params=["pymunk", "compiled"])
def stage(request: pytest.FixtureRequest) -> Stage:
    """The world of a recall in another arena than the first one and the one before."""
    env: Any = gym.make(NAME, arena=POOL, backend=request.param, noise="none").unwrapped
    for seed in (1, 0):  # of an episode in the third arena, and of the next one, in the second
        env.reset(seed=seed, options=PLACES)
    assert env.arena == env.world.arenas[0] == POOL[1]
    return Stage(env.world, env.layout)


class TestWorldInSeveralArenas(SimulationContract):
    pass


def names_of(env: Any) -> list[str]:
    """The arena of every world."""
    if isinstance(env, gym.vector.SyncVectorEnv):
        return [one.unwrapped.arena.name for one in env.envs]  # type: ignore[attr-defined]
    own = env.unwrapped
    if isinstance(env, gym.vector.VectorEnv):
        return [arena.name for arena in own.batch.arenas]
    return [own.arena.name if isinstance(env, gym.Env) else own.arenas[0].name]


def begun(env: Any, seed: int | None) -> list[Any]:
    """The observations of a new episode, which are in their spaces."""
    shown = env.reset(seed=seed)
    if isinstance(env, gym.Env | gym.vector.VectorEnv):
        assert env.observation_space.contains(shown[0])
        return [shown[0]]
    observations = [env.unwrapped.observe(agent) for agent in env.possible_agents]
    for agent, observation in zip(env.possible_agents, observations, strict=True):
        assert env.observation_space(agent).contains(observation)
    return observations


@pytest.mark.parametrize(
    ("make", "name", "kwargs"),
    [
        (gym.make, NAME, {"backend": "pymunk"}),
        (gym.make, NAME, {"backend": "compiled"}),
        (gym.make_vec, NAME, {"num_envs": 2, "vectorization_mode": "sync"}),
        (gym.make_vec, NAME, {"num_envs": 2}),
        (lambda name, **kwargs: pettingzoo.make("aec", name, **kwargs), "khepera_forage/PairedCorridors-v1", {}),
        (lambda name, **kwargs: pettingzoo.make("parallel", name, **kwargs), "khepera_forage/PairedCorridors-v1", {}),
    ],
    ids=("pymunk", "compiled", "sync", "compiled vector", "paired", "paired, parallel"),
)  # fmt: skip
def test_seed_and_episode_determine_the_arena(make: Any, name: str, kwargs: dict[str, Any]) -> None:
    pool = ("rectangle", "hall", "blocks")
    env, seen = make(name, arena=["rectangle", HALL, BLOCKS], **kwargs), set()
    for seed in range(4):
        first = begun(env, seed)
        for episode in range(2):
            if episode:
                begun(env, None)
            names = names_of(env)
            keys = [key_of(seed + world) for world in range(len(names))]
            assert names == [pool[arena_number(key, episode, len(pool))] for key in keys]
            seen.update(names)
        np.testing.assert_equal(begun(env, seed), first)
    assert seen == set(pool)
