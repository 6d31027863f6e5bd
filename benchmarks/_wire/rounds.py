"""Rounds of real drivers with virtual Kheperas: the bytes that pass, and the time that it takes."""

import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

import numpy as np

from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, JAW_CLOSED, JAW_OPEN, Motors
from khepera_forage.robots.serial.fleet import Fleet
from khepera_forage.robots.serial.line_events import Traffic
from khepera_forage.robots.serial.port import BAUDS, seconds_on_wire
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from khepera_forage.robots.virtual.firmware import Firmware
from khepera_forage.robots.virtual.virtual_port import VirtualKhepera
from khepera_forage.sim.arena import CORRIDOR, copies
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.world import Layout

FLEETS = (1, 2, 4, 8)
_PERIOD = 20
"""Rounds from one movement of arm and jaw to the next: half of them have one going on, as arms need a second."""
_WARM = 12
"""Rounds before anything is counted: first readings are asked twice, and the gripper comes to rest."""


@dataclass(frozen=True, slots=True)
class Round:
    """One round.

    Attributes:
        baud: Of the lines.
        robots: How many took part.
        number: Of the round, from 0.
        gripper: Whether arm or jaw was told something, or its position asked.
        sent: Bytes to the first robot.
        received: Bytes from it.
        wire: Milliseconds that these take on the line.
        taken: Milliseconds that the round took, `transmit` and `receive` of all robots.
    """

    baud: int
    robots: int
    number: int
    gripper: bool
    sent: int
    received: int
    wire: float
    taken: float


def rounds(baud: int, robots: int, count: int, seed: int) -> list[Round]:
    """Drive about, now and then with the gripper: the same commands for any baud rate and number."""
    wheels = np.random.default_rng(seed).integers(-12, 13, (count + _WARM, 2)).tolist()
    kept = []
    with _fleet(baud, robots, seed) as (fleet, advance):
        heard: list[Traffic] = []
        fleet.robots[0].listen(heard.append)
        for number, (left, right) in enumerate(wheels, -_WARM):
            down = number >= 0 and (number // _PERIOD) % 2
            for robot in fleet.robots:
                robot.drive(
                    Motors(left, right, ARM_DOWN if down else ARM_RAISED, JAW_CLOSED if down else JAW_OPEN)
                )
            heard.clear()
            begin = time.perf_counter()
            fleet.transmit()
            between = time.perf_counter()
            advance()
            resumed = time.perf_counter()
            fleet.receive()
            taken = time.perf_counter() - resumed + between - begin
            sent = b"".join(t.data for t in heard if t.sent)
            received = sum(len(t.data) for t in heard if not t.sent)
            gripper = any(command in sent for command in (b"T,1,D", b"T,1,E", b"T,1,H"))
            wire = 1000 * seconds_on_wire(len(sent) + received, baud)
            if number >= 0:
                kept.append(Round(baud, robots, number, gripper, len(sent), received, wire, 1000 * taken))
    return kept


def work() -> list[tuple[int, int]]:
    """Baud rates, and how many robots: one at each rate, then more at 38400 baud."""
    return [(baud, 1) for baud in BAUDS] + [(38400, robots) for robots in FLEETS if robots > 1]


@contextmanager
def _fleet(baud: int, robots: int, seed: int) -> Iterator[tuple[Fleet, "Advance"]]:
    """Robots in a corridor each, behind virtual Kheperas at the pace of the baud rate."""
    world = PymunkWorld(copies(CORRIDOR, robots), [1 + number % 2 for number in range(robots)])
    starts = tuple(arena.start for arena in world.arenas)
    world.reset(np.random.default_rng(seed), Layout(starts, ()))
    lock = threading.RLock()
    firmwares = [Firmware(robot, lock) for robot in world.robots]
    with ExitStack() as stack:
        ports = [stack.enter_context(VirtualKhepera(firmware, baud=baud)) for firmware in firmwares]
        fleet = stack.enter_context(Fleet([SerialKhepera(port.url, baud=baud) for port in ports]))
        yield fleet, Advance(world, firmwares, lock)


class Advance:
    """One round of the simulated world behind the ports."""

    def __init__(self, world: PymunkWorld, firmwares: list[Firmware], lock: threading.RLock) -> None:
        self._world = world
        self._firmwares = firmwares
        self._lock = lock

    def __call__(self) -> None:
        """Advance it."""
        with self._lock:
            self._world.advance()
            for firmware in self._firmwares:
                firmware.tick()
