"""Robots in a simulated world, behind virtual Kheperas at the pace of their lines."""

import threading
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from khepera_forage.envs.arguments import checked_arena, timing_of
from khepera_forage.robots.khepera import Senses
from khepera_forage.robots.virtual.faults import Faults
from khepera_forage.robots.virtual.firmware import Firmware
from khepera_forage.robots.virtual.virtual_khepera import VirtualKhepera
from khepera_forage.sim.arena import copies
from khepera_forage.sim.arenas.thesis import CORRIDOR
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.world import Layout
from khepera_forage.task.decisions import DEFAULT_DECISIONS

DECISIONS = replace(DEFAULT_DECISIONS, arm_travel_time=1.0)
"""An arm that takes several rounds, as the driver expects, so that rounds with a moving gripper are typical ones."""
TIMING = timing_of(DECISIONS)


class VirtualFleet(NamedTuple):
    """Virtual robots.

    Attributes:
        ports: Their ends of the lines.
        advance: Advances their simulated world by a round.
        truth: Returns the senses of the first one.
    """

    ports: list[VirtualKhepera]
    advance: Callable[[], None]
    truth: Callable[[], Senses]


@contextmanager
def virtual_fleet(baud: int, robots: int, seed: int) -> Iterator[VirtualFleet]:
    """Robots in corridors, without food.

    Args:
        baud: Of the lines.
        robots: How many.
        seed: Of the world, and of the faults that may be set.
    """
    corridors = copies(checked_arena(CORRIDOR, DECISIONS), robots)
    world = PymunkWorld(corridors, [1 + number % 2 for number in range(robots)], timing=TIMING)
    starts = tuple(arena.start for arena in world.arenas)
    world.reset(np.random.default_rng(seed), Layout(starts, ()))
    lock = threading.RLock()
    firmwares = [Firmware(robot, lock, TIMING.round_duration) for robot in world.robots]

    def advance() -> None:
        with lock:
            world.advance()
            for firmware in firmwares:
                firmware.tick()

    with ExitStack() as stack:
        ports = [
            stack.enter_context(
                VirtualKhepera(
                    firmware, baud=baud, faults=Faults(), rng=np.random.default_rng((seed, number))
                )
            )
            for number, firmware in enumerate(firmwares)
        ]
        yield VirtualFleet(ports, advance, world.robots[0].sense)
