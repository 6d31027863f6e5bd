"""The contracts, for worlds of both backends and for policies."""

from itertools import product
from typing import Any

import numpy as np
import pytest

from khepera_forage.envs.behaviours_env import BehavioursEnv
from khepera_forage.policies import NearestNeighbourImitator, Policy, Teacher, UniformPolicy
from tests.arenas import POOL
from tests.contracts.suites import CameraContract, PolicyContract, RobotContract, SimulationContract, Stage
from tests.version_0_1 import RECTANGLE, V0_1


@pytest.fixture(params=product(["pymunk", "compiled"], [True, False]), ids=str)
def stage(request: pytest.FixtureRequest) -> Stage:
    """A world that was made for this episode, with noise, or one without that has been in another arena before."""
    backend, moved = request.param
    if backend == "compiled":
        pytest.importorskip("numba")
    arena = POOL if moved else RECTANGLE
    noise = "none" if moved else "laboratory"
    env: Any = BehavioursEnv(arena=arena, foods=1, noise=noise, backend=backend, decisions=V0_1)
    for seed in (1, 0):  # episodes in the third and the second arena of the pool
        env.reset(seed=seed, options={"start": (200, 300, 29), "foods": [(500, 150)]})
    assert env.world.arenas[0] == (POOL[1] if moved else RECTANGLE)
    env.world.reset(np.random.default_rng(3), env.layout)
    return Stage(env.world, env.layout)


class TestSimulatedKhepera(RobotContract):
    pass


class TestOverheadCamera(CameraContract):
    pass


class TestSimulation(SimulationContract):
    pass


@pytest.fixture(params=["teacher", "imitator", "uniform"])
def policy(request: pytest.FixtureRequest) -> Policy:
    if request.param == "imitator":
        vectors = [(0, 60, 0, 215, 40), (0, 60, 0, 255, 18), (0, 61, 0, 255, 18), (1, 30, 1, 215, 138)]
        return NearestNeighbourImitator(diagonal=138).fit(np.array(vectors), np.array([0, 2, 1, 7]))
    return Teacher(18) if request.param == "teacher" else UniformPolicy()


class TestPolicies(PolicyContract):
    pass
