"""A test rig: simulated robots with their firmwares, and virtual robots on pseudo-terminals or TCP ports."""

import contextlib
import math
import threading
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from khepera_forage.noise import Noise
from khepera_forage.robots.khepera import Motors, Senses
from khepera_forage.robots.real_robot import Fleet
from khepera_forage.robots.serial import serial_robot
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from khepera_forage.robots.virtual.firmware import Firmware
from khepera_forage.robots.virtual.virtual_khepera import VirtualKhepera
from khepera_forage.sim.arena import Pose
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.simulation import SimulatedKhepera
from khepera_forage.sim.world import Layout
from tests.sim.worlds import FIELD, make_world
from tests.version_0_1 import RECTANGLE, TIMING


class Rig:
    """Simulated robots in one world, each with its firmware; `ports` are the virtual robots, if there are any."""

    def __init__(self, world: PymunkWorld, kind: type[Firmware] = Firmware) -> None:
        self.world, self.lock = world, threading.RLock()
        self.firmwares = [kind(robot, self.lock) for robot in world.robots]
        self.ports: list[VirtualKhepera] = []

    @property
    def url(self) -> str:
        return self.ports[0].url

    @property
    def firmware(self) -> Firmware:
        return self.firmwares[0]

    @property
    def robots(self) -> tuple[SimulatedKhepera, ...]:
        return self.world.robots

    def intercept(self, replace: Callable[[bytes], bytes | None] = lambda line: None) -> list[bytes]:
        """Record the requests that the first robot receives; what `replace` returns is the reply, if not None."""
        handle, requests = self.firmware.handle, list[bytes]()

        def recorded(line: bytes) -> bytes:
            requests.append(line)
            reply = replace(line)
            return handle(line) if reply is None else reply

        self.firmware.handle = recorded  # type: ignore[method-assign]
        return requests

    def request(self, line: str) -> str:
        """Let the first robot execute a request; returns the reply without its line ending."""
        return self.firmware.handle(line.encode()).decode().removesuffix("\r\n")

    def advance(self, rounds: int = 1) -> None:
        with self.lock:
            for _ in range(rounds):
                self.world.advance()
                for firmware in self.firmwares:
                    firmware.tick()

    def wheel_pulses(self, number: int = 0) -> tuple[float, float]:
        """Advance one round; returns the pulses that the robot's wheels turned in it."""
        robot = self.robots[number]
        before = robot.sense()
        self.advance()
        after = robot.sense()
        return after.left_pulses - before.left_pulses, after.right_pulses - before.right_pulses

    def is_stopped(self) -> bool:
        return all(self.wheel_pulses(number) == (0, 0) for number in range(len(self.robots)))


def make_stage(food_ahead: float | None = None) -> Rig:
    """A robot in the rectangle, heading along x; food far away, or `food_ahead` mm ahead of its centre."""
    food = (600.0, 560.0) if food_ahead is None else (200.0 + food_ahead, 300.0)
    return Rig(make_world(Pose(200.0, 300.0, 0.0), food, arena=RECTANGLE))


@contextlib.contextmanager
def make_rig(
    robots: int = 1, *, tcp: bool = False, baud: int | None = None, seed: int = 0, kind: type[Firmware] = Firmware
) -> Iterator[Rig]:
    """Robots far apart on a wide floor, each behind its virtual line."""
    poses = [Pose(400 + 400 * (i % 4), 600 + 600 * (i // 4), 0.3 * i) for i in range(robots)]
    world = PymunkWorld([FIELD], [1 + i % 2 for i in range(robots)], Noise.none(), timing=TIMING)
    world.reset(np.random.default_rng(seed), Layout(tuple(poses), ()))
    rig = Rig(world, kind)
    with contextlib.ExitStack() as stack:
        # A busy machine can make the line look slow; commands would then be confirmed later than the tests expect.
        stack.enter_context(pytest.MonkeyPatch.context()).setattr(serial_robot, "FAST", math.inf)
        for number, firmware in enumerate(rig.firmwares):
            rng = np.random.default_rng((seed, number))
            port = VirtualKhepera(firmware, tcp=0 if tcp else None, baud=baud, rng=rng)
            rig.ports.append(stack.enter_context(port))
        yield rig


FORWARD = Motors(5, 5, 215, 200)


def run_rounds(rig: Rig, robots: SerialKhepera | Fleet, motors: Motors, rounds: int = 1) -> Senses:
    """Drive a robot, or a fleet, for a number of rounds; returns the last senses of the first robot."""
    each = robots.robots if isinstance(robots, Fleet) else (robots,)
    for _ in range(rounds):
        for robot in each:
            robot.drive(motors)
        robots.transmit()
        rig.advance()
        robots.receive()
    return each[0].sense()
