"""The contracts, for worlds of both backends and for policies."""

from typing import Any

import numpy as np
import pytest

from khepera_forage.noise import Noise
from khepera_forage.policies import NearestNeighbourImitator, Policy, Teacher, UniformPolicy
from khepera_forage.sim.arena import Point, Pose
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.world import Layout
from tests.contracts.suites import CameraContract, PolicyContract, RobotContract, SimulationContract, Stage
from tests.version_0_1 import RECTANGLE, TIMING


@pytest.fixture(params=["none", "laboratory"])
def noise(request: pytest.FixtureRequest) -> Noise:
    return Noise.none() if request.param == "none" else Noise.laboratory()


@pytest.fixture(params=["pymunk", "compiled"])
def stage(request: pytest.FixtureRequest, noise: Noise) -> Stage:
    kind: Any = PymunkWorld
    if request.param == "compiled":
        pytest.importorskip("numba")
        from khepera_forage.sim.compiled.world import CompiledWorld as kind  # noqa: N813
    world = kind([RECTANGLE], (2,), noise, timing=TIMING)
    layout = Layout((Pose(200.0, 300.0, 0.5),), (Point(500.0, 150.0),))
    world.reset(np.random.default_rng(3), layout)
    return Stage(world, layout)


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
