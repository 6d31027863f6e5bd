"""A simulated robot in an open arena with its firmware, without a serial line."""

import threading
from typing import NamedTuple

import numpy as np

from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import FOOD_RADIUS
from khepera_forage.robots.virtual.firmware import Firmware
from khepera_forage.sim.arena import Point, Pose
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.simulation import SimulatedKhepera
from khepera_forage.sim.world import Layout
from tests.version_0_1 import RECTANGLE, TIMING


class Stage(NamedTuple):
    """A world with one robot, its firmware, and their lock."""

    world: PymunkWorld
    firmware: Firmware
    lock: threading.RLock

    @property
    def robot(self) -> SimulatedKhepera:
        return self.world.robots[0]

    def request(self, line: str) -> str:
        """Execute a request; returns the reply without its line ending."""
        return self.firmware.handle(line.encode()).decode().removesuffix("\r\n")

    def numbers(self, line: str) -> list[int]:
        """Execute a request; returns the values of the reply."""
        letters = line.lower().split(",")[: 3 if line.startswith("T") else 1]
        fields = self.request(line).split(",")
        assert fields[: len(letters)] == letters
        return [int(field) for field in fields[len(letters) :]]

    def rounds(self, count: int) -> None:
        for _ in range(count):
            self.world.advance()
            self.firmware.tick()


def make_stage(noise: Noise | None = None, food_ahead: float | None = None) -> Stage:
    """A robot in the rectangle, heading along x; food far away, or `food_ahead` mm ahead of its centre."""
    world = PymunkWorld([RECTANGLE], (2,), Noise.none() if noise is None else noise, timing=TIMING)
    food = Point(600.0, 560.0) if food_ahead is None else Point(200.0 + food_ahead, 300.0)
    assert RECTANGLE.clearance(food) > FOOD_RADIUS
    world.reset(np.random.default_rng(3), Layout((Pose(200.0, 300.0, 0.0),), (food,)))
    lock = threading.RLock()
    return Stage(world, Firmware(world.robots[0], lock), lock)
