"""The contracts, for real drivers and the real tracker on virtual devices."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from khepera_forage.envs.laboratories import virtual_laboratory
from khepera_forage.noise import Noise
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from khepera_forage.sim.arena import Point, Pose
from khepera_forage.sim.world import Layout
from khepera_forage.vision.tracker import TrackedCamera
from tests.contracts.suites import CameraContract, RobotContract, Stage, WorldContract
from tests.version_0_1 import RECTANGLE, V0_1

pytest.importorskip("serial")
pytest.importorskip("cv2")


@pytest.fixture
def stage() -> Iterator[Stage]:
    noise = replace(Noise.laboratory(), placement_error=1, placement_heading_error=0.5)
    with virtual_laboratory(RECTANGLE, 1, V0_1, noise=noise) as world:
        assert (type(world.robots[0]), type(world.camera)) == (SerialKhepera, TrackedCamera)
        layout = Layout((Pose(200.0, 300.0, 0.5),), (Point(500.0, 150.0),))
        world.reset(np.random.default_rng(3), layout)
        yield Stage(world, layout, world.simulation)


class TestSerialKhepera(RobotContract):
    pass


class TestTrackedCamera(CameraContract):
    distance, angle = 5.0, 3.0


class TestLaboratory(WorldContract):
    pass
