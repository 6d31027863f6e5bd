"""The contracts, for real drivers and the real tracker on virtual devices."""

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from khepera_forage.envs.laboratories import virtual_laboratory
from khepera_forage.lab.virtual_laboratory import VirtualLaboratory
from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import Motors
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
        yield Stage(world, layout)


class TestSerialKhepera(RobotContract):
    pass


class TestTrackedCamera(CameraContract):
    def test_regions_are_at_the_true_places(self, stage: Stage) -> None:
        """The poses of the laboratory are the camera's, so the contract alone does not test them."""
        assert isinstance(stage.world, VirtualLaboratory)
        stage.rounds(20, Motors(6, 4, 215, 200))
        stage.rounds(2, Motors(0, 0, 215, 200))
        (x, y, heading), (food,) = stage.world.simulation.poses()[0], stage.world.simulation.food_places()
        for region in stage.camera.look().regions:
            there = (x, y) if region.holes else food[:2]
            assert math.dist((region.x * 5, region.y * 5), there) < 5
            if region.holes:
                assert abs((region.orientation - math.degrees(heading) + 180) % 360 - 180) < 3


class TestLaboratory(WorldContract):
    pass
