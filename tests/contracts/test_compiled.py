"""The contracts, for compiled worlds."""

import numpy as np
import pytest

from khepera_forage.noise import Noise
from khepera_forage.sim.arena import Point, Pose
from khepera_forage.sim.world import Layout
from tests.contracts.suites import CameraContract, RobotContract, SimulationContract, Stage
from tests.version_0_1 import RECTANGLE, TIMING

pytest.importorskip("numba")

from khepera_forage.sim.compiled.world import CompiledWorld


@pytest.fixture(params=["none", "laboratory"])
def stage(request: pytest.FixtureRequest) -> Stage:
    noise = Noise.none() if request.param == "none" else Noise.laboratory()
    world = CompiledWorld([RECTANGLE], (2,), noise, timing=TIMING)
    layout = Layout((Pose(200.0, 300.0, 0.5),), (Point(500.0, 150.0),))
    world.reset(np.random.default_rng(3), layout)
    return Stage(world, layout)


class TestCompiledKhepera(RobotContract):
    pass


class TestCompiledCamera(CameraContract):
    pass


class TestCompiledWorld(SimulationContract):
    pass
