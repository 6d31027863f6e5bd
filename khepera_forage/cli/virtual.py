"""`khepera-forage robot virtual`: a simulated Khepera at a serial port, for programs that control a real one."""

import argparse
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np

from khepera_forage.cli.options import command, option, seed
from khepera_forage.envs.arguments import checked_arena, timing_of
from khepera_forage.option_values import whole_number
from khepera_forage.robots.drivers import DRIVERS, FIRMWARES
from khepera_forage.robots.khepera import CONTROL_PERIOD
from khepera_forage.robots.model import KHEPERA
from khepera_forage.robots.serial.protocol import BAUD_RATES
from khepera_forage.robots.virtual.virtual_khepera import FAULTS, Faults, VirtualKhepera
from khepera_forage.sim.arenas.thesis import CORRIDOR
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.world import Layout
from khepera_forage.task.decisions import DEFAULT_DECISIONS

_TCP = "listen on this port of 127.0.0.1 (0 for any free port) instead of a pseudo-terminal"
_BAUD = f"speed of the line: {', '.join(map(str, BAUD_RATES))}, or 0 for no limit (38400; of an e-puck2 115200)"
_LATENESS = "range of the delay of a delayed reply, in seconds (0.3 1.0)"


@command(
    option("--tcp", _TCP, whole_number(0, 65535), "PORT"),
    option("--baud", _BAUD, int),
    *(option(f"--{fault}", "share of replies with this fault (0)", float, "RATE", default=0.0) for fault in FAULTS),
    option("--lateness", _LATENESS, float, ("FROM", "TO"), nargs=2, default=Faults().lateness),
    option("--robot", f"kind of robot ({KHEPERA.name})", choices=tuple(FIRMWARES), default=KHEPERA.name),
    seed("seed of the simulation and of the faults"),
)
def virtual_command(arguments: argparse.Namespace) -> None:
    """Start a virtual Khepera at a serial port."""
    faults = Faults(**{fault: getattr(arguments, fault) for fault in FAULTS}, lateness=tuple(arguments.lateness))
    world_rng, fault_rng = np.random.default_rng(arguments.seed).spawn(2)
    arena = checked_arena(CORRIDOR, DEFAULT_DECISIONS)
    # A robot has no rounds: its firmware has a control period.
    timing = timing_of(DEFAULT_DECISIONS)._replace(round_duration=CONTROL_PERIOD)
    model = DRIVERS[arguments.robot].model
    world = PymunkWorld([arena], (DEFAULT_DECISIONS.recall_marker,), timing=timing, model=model)
    world.reset(world_rng, Layout((arena.start,), arena.foods))
    lock = threading.RLock()
    firmware = FIRMWARES[arguments.robot](world.robots[0], lock)
    baud = arguments.baud if arguments.baud is not None else firmware.protocol.baud
    due, overruns = time.monotonic(), 0
    virtual = VirtualKhepera(firmware, tcp=arguments.tcp, baud=baud or None, faults=faults, rng=fault_rng)
    with _collected_signals() as signals, virtual as khepera:
        print(f"a virtual {firmware.name} at {khepera.url}; Ctrl-C ends it", flush=True)
        while khepera.connected and not signals:
            due += CONTROL_PERIOD
            late = time.monotonic() - due
            if late > CONTROL_PERIOD:
                # Skip the missed rounds: a robot does not drive faster because its computer was busy.
                due += late
                overruns += 1
            else:
                time.sleep(max(0.0, -late))
            with lock:
                world.advance()
                firmware.tick()
        print("stopped" if khepera.connected else "unplugged", flush=True)
    world.close()
    counts = khepera.fault_counts
    happened = [f"{counts[fault]} {fault}" for fault in FAULTS if counts[fault]]
    print(", ".join([f"{counts['replies']} requests", *happened]))
    if overruns:
        print(f"{overruns} rounds began late")


@contextmanager
def _collected_signals() -> Iterator[list[int]]:
    """Append SIGINT and SIGTERM to a list instead of raising them: a handler must not take the world's lock."""
    signals: list[int] = []
    numbers = signal.SIGINT, signal.SIGTERM
    before = [signal.signal(number, lambda number, _: signals.append(number)) for number in numbers]
    try:
        yield signals
    finally:
        for number, handler in zip(numbers, before, strict=True):
            signal.signal(number, handler)
