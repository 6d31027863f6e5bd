"""The contracts, for worlds of environments with several arenas, and for these environments in every form."""

from collections.abc import Callable, Sequence
from importlib.util import find_spec
from typing import Any

import gymnasium as gym
import pettingzoo
import pytest

import khepera_forage  # noqa: F401 (registers the environments)
from khepera_forage.envs.training import TrainingEnv
from khepera_forage.sim.arena import Arena, Point
from khepera_forage.sim.world import Layout
from tests.arenas import BLOCKS, HALL, POOL
from tests.contracts.suites import (
    CameraContract,
    PoolContract,
    Pooled,
    RobotContract,
    SimulationContract,
    Stage,
)

NAME = "khepera_forage/Corridor-v1"
SEEDS = (1, 0)
"""Of an episode in the third arena, and of the next one, in the second."""
PLACES = {"start": (200, 300, 29), "foods": [(500, 150)]}
"""Free in all arenas."""
NAMED: Sequence[Arena | str] = ["rectangle", HALL, BLOCKS]
needs_numba = pytest.mark.skipif(find_spec("numba") is None, reason="needs numba")


@pytest.fixture(params=["pymunk", pytest.param("compiled", marks=needs_numba)])
def stage(request: pytest.FixtureRequest) -> Stage:
    """The world of a recall in another arena than the first one and the one before."""
    env: Any = gym.make(NAME, arena=POOL, backend=request.param, noise="none").unwrapped
    for seed in SEEDS:
        env.reset(seed=seed, options=PLACES)
    assert env.arena == env.world.arenas[0] == POOL[1]
    return Stage(env.world, env.layout)


class TestRobotInSeveralArenas(RobotContract):
    pass


class TestCameraInSeveralArenas(CameraContract):
    pass


class TestWorldInSeveralArenas(SimulationContract):
    pass


class TestTrainingWorldInSeveralArenas(SimulationContract):
    @pytest.fixture
    def stage(self) -> Stage:
        env = TrainingEnv(arena=POOL, noise="none")
        for seed in SEEDS:
            env.reset(seed=seed, options=PLACES)
        assert env.arenas[0] == env.world.arenas[0] == POOL[1]
        foods = tuple(Point(x, y) for x, y, _ in env.world.food_places())
        return Stage(env.world, Layout(env.world.poses(), foods))


def _one(backend: str) -> Pooled:
    env: Any = gym.make(NAME, arena=NAMED, backend=backend).unwrapped
    return _pooled(lambda seed: env.reset(seed=seed)[0], lambda: [env.arena], env.observation_space.contains)


def _many(mode: str) -> Pooled:
    env: Any = gym.make_vec(NAME, 2, arena=NAMED, vectorization_mode=mode)

    def arenas() -> Sequence[Arena]:
        if mode == "vector_entry_point":
            return env.unwrapped.batch.arenas  # type: ignore[no-any-return]
        return [one.unwrapped.arena for one in env.envs]

    return _pooled(lambda seed: env.reset(seed=seed)[0], arenas, env.observation_space.contains)


def _aec() -> Pooled:
    env = TrainingEnv(arena=NAMED)

    def reset(seed: int | None) -> Any:
        env.reset(seed=seed)
        return [env.observe(agent) for agent in env.possible_agents]

    return _paired(reset, env)


def _parallel() -> Pooled:
    env: Any = pettingzoo.make("parallel", "khepera_forage/PairedCorridors-v1", arena=NAMED)
    return _paired(lambda seed: list(env.reset(seed=seed)[0].values()), env.unwrapped)


def _paired(reset: Callable[[int | None], Any], env: TrainingEnv) -> Pooled:
    spaces = [env.observation_space(agent) for agent in env.possible_agents]
    return _pooled(
        reset,
        lambda: env.arenas[:1],
        lambda shown: all(space.contains(own) for space, own in zip(spaces, shown, strict=True)),
    )


def _pooled(
    reset: Callable[[int | None], Any],
    arenas: Callable[[], Sequence[Arena]],
    contains: Callable[[Any], bool],
) -> Pooled:
    return Pooled(("rectangle", "hall", "blocks"), reset, arenas, contains)


FORMS: dict[str, Callable[[], Pooled]] = {
    "pymunk": lambda: _one("pymunk"),
    "compiled": lambda: _one("compiled"),
    "sync": lambda: _many("sync"),
    "compiled vector": lambda: _many("vector_entry_point"),
    "paired": _aec,
    "paired, parallel": _parallel,
}


@pytest.fixture(
    scope="module",
    params=[pytest.param(form, marks=needs_numba if form.startswith("compiled") else ()) for form in FORMS],
)
def pooled(request: pytest.FixtureRequest) -> Pooled:
    return FORMS[request.param]()


class TestEnvironmentsInSeveralArenas(PoolContract):
    pass
