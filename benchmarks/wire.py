"""Serial lines: time of a round by baud rate, number of robots, latency and disturbance.

    python benchmarks/wire.py --help

Real drivers and virtual Kheperas exchange real bytes over pseudo-terminals, at the pace of the baud rate.
"""

import math
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple
from unittest.mock import Mock, patch

import numpy as np

from khepera_forage.envs.arguments import checked_arena, timing_of
from khepera_forage.estimates import Estimate, Table, Value, pick, quantiles, table_of
from khepera_forage.figures import GREY, OURS, THESIS, legend, levels, panels
from khepera_forage.lab.clock import WallClock
from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, JAW_CLOSED, JAW_OPEN, Motors, RobotLost, Senses
from khepera_forage.robots.real_robot import Fleet
from khepera_forage.robots.serial.line import LineTooSlow
from khepera_forage.robots.serial.protocol import BAUD_RATES
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from khepera_forage.robots.virtual.firmware import Firmware
from khepera_forage.robots.virtual.virtual_khepera import Faults, VirtualKhepera
from khepera_forage.sim.arena import copies
from khepera_forage.sim.arenas.thesis import CORRIDOR
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.world import Layout
from khepera_forage.study import Count, Job, Page, Picture, collect, finish, parse
from khepera_forage.task.decisions import DEFAULT_DECISIONS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BAUD = 38400
"""Of all measurements but those by baud rate."""
DECISIONS = replace(DEFAULT_DECISIONS, arm_travel_time=1.0)
"""An arm that takes several rounds, as the driver expects, so that rounds with a moving gripper are typical ones."""
TIMING = timing_of(DECISIONS)
PERIOD = TIMING.round_duration
_MOVEMENT_PERIOD = 2 * math.ceil(DECISIONS.arm_travel_time / PERIOD)
"""Rounds from one movement of the gripper to the next: in half of the rounds, the arm moves."""
_WARM_UP = 12
"""Rounds that are not counted: first readings are requested twice, and the gripper comes to rest."""
RESTS, MOVES = "gripper rests", "gripper moves, or its position is read"


class Line(NamedTuple):
    """Robots that drive, each on a line of its own, and what disturbs the first line.

    Attributes:
        latency: Of every reply, in ms.
        period: Seconds of a round, which the driver requires of a line when it is opened, and for which the robots
            drive. None accepts every line, and rounds follow each other at once.
        faults: Of the replies in rounds; None for the latency alone.
    """

    name: str
    baud: int = BAUD
    robots: int = 1
    latency: int = 0
    period: float | None = None
    faults: Faults | None = None


RATES = [Line(f"{baud} baud", baud) for baud in BAUD_RATES]
FLEETS = [Line(f"{robots} robots", robots=robots) for robots in (2, 4, 8)]
LATENCIES = [Line(f"latency {ms} ms", latency=ms, period=PERIOD) for ms in (0, 5, 16, 40, 80, 100, 200, 300, 1000)]
"""16 ms is that of a USB adapter with the usual setting; 100 ms and more do not allow a period of 0.1 s."""
DISTURBANCES = [
    Line("20 % garbled", faults=Faults(garble=0.2)),
    Line("20 % late by 0.2 to 0.6 s", faults=Faults(delay=0.2, lateness=(0.2, 0.6))),
    Line("5 % lost", faults=Faults(drop=0.05)),
]
LINES = [*RATES, *FLEETS, *LATENCIES, *DISTURBANCES]
QUICK_LINES = [*RATES, *FLEETS, *LATENCIES[2:6], *DISTURBANCES[:1]]


@dataclass(frozen=True, slots=True)
class Round:
    """Whether the gripper moved or its position was read, the time in ms, and whether a counter was wrong."""

    line: str
    moves: bool
    ms: float
    wrong: bool


@dataclass(frozen=True, slots=True)
class Opening:
    """Whether the driver accepted the lines, after which time, and the rounds in which a robot was lost."""

    line: str
    accepted: bool
    ms: float
    lost: int = 0


class VirtualFleet(NamedTuple):
    """Robots behind virtual Kheperas at the pace of their lines; `truth` returns the senses of the first one."""

    ports: list[VirtualKhepera]
    firmwares: list[Firmware]
    advance: Callable[[], None]
    truth: Callable[[], Senses]


@contextmanager
def virtual_fleet(baud: int, robots: int, seed: int) -> Iterator[VirtualFleet]:
    """Robots in corridors, without food; the seed is that of the world, and of faults that may be set."""
    corridors = copies(checked_arena(CORRIDOR, DECISIONS), robots)
    world = PymunkWorld(corridors, [1 + number % 2 for number in range(robots)], timing=TIMING)
    world.reset(np.random.default_rng(seed), Layout(tuple(arena.start for arena in world.arenas), ()))
    lock = threading.RLock()
    firmwares = [Firmware(robot, lock, PERIOD) for robot in world.robots]

    def advance() -> None:
        with lock:
            world.advance()
            for firmware in firmwares:
                firmware.tick()

    with ExitStack() as stack:
        ports = []
        for number, firmware in enumerate(firmwares):
            port = VirtualKhepera(firmware, baud=baud, rng=np.random.default_rng((seed, number)))
            ports.append(stack.enter_context(port))
        yield VirtualFleet(ports, firmwares, advance, world.robots[0].sense)


def _ms_since(begin: float) -> float:
    return 1000 * (time.perf_counter() - begin)


def _timed(work: Callable[[], None]) -> float:
    begin = time.perf_counter()
    work()
    return _ms_since(begin)


def drive(line: Line, rounds: int, seed: int) -> list[Round | Opening]:
    """Robots that drive about and now and then move the gripper; all drives have the same commands."""
    wheels = np.random.default_rng(seed).integers(-12, 13, (rounds + _WARM_UP, 2)).tolist()
    rows: list[Round | Opening] = []
    lost = 0
    with virtual_fleet(line.baud, line.robots, seed) as (ports, (firmware, *_), advance, truth), ExitStack() as stack:
        port, seconds, begin = ports[0], line.latency / 1000, time.perf_counter()
        port.faults = Faults(delay=1.0 if seconds else 0.0, lateness=(seconds, seconds))
        try:
            robots = [SerialKhepera(port.url, baud=line.baud, period=line.period) for port in ports]
        except LineTooSlow:
            return [Opening(line.name, False, _ms_since(begin))]
        opened = _ms_since(begin)
        clock = None if line.period is None else WallClock(line.period)
        fleet = stack.enter_context(Fleet(robots))
        handle = stack.enter_context(patch.object(firmware, "handle", Mock(wraps=firmware.handle)))
        for number, (left, right) in enumerate(wheels, -_WARM_UP):
            if number == 0 and line.faults is not None:
                port.faults = line.faults
            is_down = number >= 0 and number // _MOVEMENT_PERIOD % 2
            gripper = (ARM_DOWN, JAW_CLOSED) if is_down else (ARM_RAISED, JAW_OPEN)
            for robot in robots:
                robot.drive(Motors(left, right, *gripper))
            handle.reset_mock()
            try:
                taken = _timed(fleet.transmit)
                if clock is not None:
                    clock.wait()
                advance()
                taken += _timed(fleet.receive)
            except RobotLost:
                lost += 1
                continue
            if number >= 0:
                requests = [call.args[0] for call in handle.call_args_list]
                moves = any(request.startswith((b"T,1,D", b"T,1,E", b"T,1,H")) for request in requests)
                rows.append(Round(line.name, moves, taken, robots[0].sense()[1:3] != truth()[1:3]))
        port.faults = Faults()
    return [*rows, Opening(line.name, True, opened, lost)]


def _spread(rows: Sequence[Round], line: Line, moves: bool) -> Estimate:
    return quantiles([row.ms for row in pick(rows, line=line.name, moves=moves)])


def line_table(openings: Sequence[Opening], rows: Sequence[Round]) -> Table:
    """Opening, times of rounds, and what went wrong, by line."""
    note = (
        f"Times in ms, at {BAUD} baud unless said otherwise. Rounds: `transmit` and `receive` of all robots, median "
        "[5th, 95th percentile]. A line is rejected if it is too slow for rounds of 100 ms. Lost: rounds in which "
        "a robot did not answer."
    )
    lines: list[dict[str, Value]] = []
    for line in LINES:
        for opening in pick(openings, line=line.name):
            own = pick(rows, line=line.name)
            lines.append(
                {
                    "line": line.name,
                    "accepted": "yes" if opening.accepted else "no",
                    "opening": opening.ms,
                    "rounds": len(own),
                    RESTS: _spread(rows, line, False),
                    MOVES: _spread(rows, line, True),
                    "longest": max((row.ms for row in own), default=math.nan),
                    "wrong counter": len(pick(own, wrong=True)),
                    "lost": opening.lost,
                }
            )
    return table_of("lines", "Rounds", note, lines)


def picture(rows: Sequence[Round]) -> "Figure":
    """Rounds by baud rate, and by number of robots."""
    figure, (left, right) = panels(2, "Time of a round")
    rates = {line.name: [_spread(rows, line, moves) for moves in (False, True)] for line in RATES}
    levels(left, rates, "ms: median, 5th and 95th percentile", (RESTS, MOVES), (OURS, THESIS))
    left.axvline(1000 * PERIOD, color=GREY, lw=1.2, ls="--", label=f"a round: {1000 * PERIOD:.0f} ms")
    fleets = {"1 robot": Line(f"{BAUD} baud")} | {line.name: line for line in FLEETS}
    levels(right, {name: [_spread(rows, line, False)] for name, line in fleets.items()}, f"ms at {BAUD} baud")
    for axes in (left, right):
        axes.set_xlim(left=0)
    legend(figure, left, columns=3)
    return figure


def main() -> int:
    """Run the benchmark."""
    given = parse("wire", __doc__, Count("rounds", 200, 12, "rounds of every line"), jobs=None)
    lines = QUICK_LINES if given.quick else LINES
    units = [Job(line.name, drive, (line, given.rounds, given.seed)) for line in lines]
    rows = collect(given, units, {Round: "rounds", Opening: "openings"})
    rounds = rows.of(Round)
    caption = "milliseconds of a round by baud rate, and by number of robots"
    parts: list[Table | Picture] = [line_table(rows.of(Opening), rounds), Picture("wire", caption, picture(rounds))]
    return finish(given, Page("Serial lines", parts))


if __name__ == "__main__":
    sys.exit(main())
