"""`khepera-forage robot virtual`: a simulated Khepera at a serial port, for any program that talks to a real one."""

import argparse
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from khepera_forage.robots.khepera import CONTROL_PERIOD
from khepera_forage.robots.serial.port import BAUDS
from khepera_forage.robots.virtual.firmware import Firmware
from khepera_forage.robots.virtual.line_faults import FAULTS, FaultCounts, Faults
from khepera_forage.robots.virtual.virtual_port import VirtualKhepera
from khepera_forage.sim.arena import CORRIDOR
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.world import Layout


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's arguments."""
    parser.add_argument(
        "--tcp",
        type=int,
        metavar="PORT",
        help="listen on this port of 127.0.0.1, 0 for any, instead of at a pseudo-terminal",
    )
    bauds = ", ".join(map(str, BAUDS))
    parser.add_argument(
        "--baud", type=int, default=38400, help=f"pace of the line: {bauds}, or 0 for none (38400)"
    )
    for fault in FAULTS:
        parser.add_argument(
            f"--{fault}",
            type=float,
            default=0.0,
            metavar="RATE",
            help="share of replies with this fault (0)",
        )
    parser.add_argument(
        "--lateness",
        type=float,
        nargs=2,
        default=Faults().lateness,
        metavar=("FROM", "TO"),
        help="seconds by which a delayed reply is late (0.3 1.0)",
    )
    parser.add_argument("--seed", type=int, default=0, help="of the simulation and of the faults (0)")


def run(arguments: argparse.Namespace) -> int:
    """Serve it until interrupted or terminated, or until the cable is unplugged by a fault.

    Raises:
        ValueError: A baud or a rate that is out of range.
        OSError: The TCP port is taken.
    """
    faults = Faults(
        **{fault: getattr(arguments, fault) for fault in FAULTS}, lateness=tuple(arguments.lateness)
    )
    world_rng, fault_rng = np.random.default_rng(arguments.seed).spawn(2)
    world = PymunkWorld([CORRIDOR])
    world.reset(world_rng, Layout((CORRIDOR.start,), CORRIDOR.foods))
    lock = threading.RLock()
    firmware = Firmware(world.robots[0], lock)
    with (
        _caught() as signals,
        VirtualKhepera(
            firmware, tcp=arguments.tcp, baud=arguments.baud or None, faults=faults, rng=fault_rng
        ) as khepera,
    ):
        print(f"a virtual Khepera at {khepera.url}; Ctrl-C ends it", flush=True)
        overruns = _live(world, firmware, lock, khepera, signals)
        print("stopped" if khepera.plugged else "unplugged", flush=True)
    world.close()
    print(_told(khepera.counts))
    if overruns:
        print(f"{overruns} rounds began late")
    return 0


def _live(
    world: PymunkWorld,
    firmware: Firmware,
    lock: threading.RLock,
    khepera: VirtualKhepera,
    signals: list[int],
) -> int:
    """Advance the world by the clock on the wall; returns how many rounds began a whole round late."""
    beat, overruns = time.monotonic(), 0
    while khepera.plugged and not signals:
        beat += CONTROL_PERIOD
        late = time.monotonic() - beat
        if late > CONTROL_PERIOD:
            # What was missed is not made up for: a robot does not drive faster because its computer was busy.
            beat += late
            overruns += 1
        else:
            time.sleep(max(0.0, -late))
        with lock:
            world.advance()
            firmware.tick()
    return overruns


@contextmanager
def _caught() -> Iterator[list[int]]:
    """The SIGINT and SIGTERM that come while this lasts, in a list: no lock is touched inside a signal handler."""
    signals: list[int] = []
    before = {
        number: signal.signal(number, lambda number, _: signals.append(number))
        for number in (signal.SIGINT, signal.SIGTERM)
    }
    try:
        yield signals
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _told(counts: FaultCounts) -> str:
    said = f"{counts.replies} requests"
    faults = [f"{getattr(counts, fault)} {fault}" for fault in FAULTS if getattr(counts, fault)]
    return ", ".join([said, *faults])
