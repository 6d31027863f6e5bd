"""Serial lines: time of a round by baud rate, robots, latency and disturbance; and stopping when a process ends.

    python benchmarks/wire.py --help

Real drivers and virtual Kheperas exchange real bytes over pseudo-terminals, at the pace of the baud rate.
"""

import math
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, NamedTuple
from unittest.mock import patch

import numpy as np

from khepera_forage.envs.arguments import checked_arena, timing_of
from khepera_forage.estimates import Estimate, Table, Value, pick, quantiles, table_of
from khepera_forage.figures import GREY, OURS, THESIS, legend, levels, panels
from khepera_forage.lab.clock import WallClock
from khepera_forage.robots.khepera import (
    ARM_DOWN,
    ARM_RAISED,
    JAW_CLOSED,
    JAW_OPEN,
    MAX_SPEED,
    Motors,
    RobotLost,
    Senses,
)
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
FLEETS = (1, 2, 4, 8)
LATENCIES, QUICK_LATENCIES = (0, 5, 16, 40, 80, 100, 200, 300, 1000), (16, 80, 100)
"""Milliseconds: 16 is that of a USB adapter with the usual setting; 100 and more do not allow a period of 0.1 s."""
DISTURBANCES = {
    "none": Faults(),
    "20 % late by 0.2 to 0.6 s": Faults(delay=0.2, lateness=(0.2, 0.6)),
    "20 % garbled": Faults(garble=0.2),
    "5 % lost": Faults(drop=0.05),
}
ENDINGS = {
    "Ctrl-C": signal.SIGINT,
    "Ctrl-Z": signal.SIGTSTP,
    "kill -9": signal.SIGKILL,
    "SIGSTOP": signal.SIGSTOP,
    "termination": signal.SIGTERM,
    "hang-up": signal.SIGHUP,
    "Ctrl-\\": signal.SIGQUIT,
    "SIGABRT": signal.SIGABRT,
    "SIGALRM": signal.SIGALRM,
    "SIGXCPU": signal.SIGXCPU,
    "crash (SIGSEGV)": signal.SIGSEGV,
}
"""A quick run has the first four."""
DECISIONS = replace(DEFAULT_DECISIONS, arm_travel_time=1.0)
"""An arm that takes several rounds, as the driver expects, so that rounds with a moving gripper are typical ones."""
TIMING = timing_of(DECISIONS)
PERIOD_MS = 1000 * TIMING.round_duration
_MOVEMENT_PERIOD = 2 * math.ceil(DECISIONS.arm_travel_time / TIMING.round_duration)
"""Rounds from one movement of the gripper to the next: in half of the rounds, the arm moves."""
_WARM_UP = 12
"""Rounds that are not counted: first readings are requested twice, and the gripper comes to rest."""
RESTS, MOVES = "gripper rests", "gripper moves, or its position is read"
_TIMEOUT = 5.0
"""Seconds after which wheels count as turning for good."""
_PROGRAM = """
import signal, sys, time
# A shell starts programs in the background with some signals ignored, and their children inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)
for number in (signal.SIGQUIT, signal.SIGHUP, signal.SIGTSTP):
    signal.signal(number, signal.SIG_DFL)
from khepera_forage.robots.khepera import Motors
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
with SerialKhepera(sys.argv[1], period=None) as robot:
    robot.drive(Motors(5, 5, 215, 200))
    robot.transmit()
    print("driving", flush=True)
    # In turns, because Python may overlook a signal just before a call that waits for ever.
    while True:
        time.sleep(0.05)
"""
PARTS = {
    "rounds": "Bytes to and from the first robot, and the time of `transmit` and `receive` of all robots.",
    "latency": f"One robot at {BAUD} baud. End: from the beginning of a period until its commands are sent. Between: "
    "from the arrival of a round's readings to that of the next round's.",
    "disturbances": f"One robot at {BAUD} baud with random speeds; the last round is undisturbed. Undetectable: "
    "garbled replies that are well-formed.",
    "endings": "From the end of a process that drives a robot until the robot receives the stop, or 5 s have passed.",
}
"""The tables and their notes."""


@dataclass(frozen=True, slots=True)
class Measurement:
    """One measured value of a case of one of `PARTS`; times are in ms."""

    part: str
    case: str
    measure: str
    value: float


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
    firmwares = [Firmware(robot, lock, TIMING.round_duration) for robot in world.robots]

    def advance() -> None:
        with lock:
            world.advance()
            for firmware in firmwares:
                firmware.tick()

    with ExitStack() as stack:
        ports = []
        for number, firmware in enumerate(firmwares):
            rng = np.random.default_rng((seed, number))
            port = VirtualKhepera(firmware, baud=baud, faults=Faults(), rng=rng)
            ports.append(stack.enter_context(port))
        yield VirtualFleet(ports, firmwares, advance, world.robots[0].sense)


def _motors(left: int, right: int, down: int) -> Motors:
    return Motors(left, right, *((ARM_DOWN, JAW_CLOSED) if down else (ARM_RAISED, JAW_OPEN)))


def _timed(work: Callable[[], None]) -> float:
    """Milliseconds that something takes."""
    begin = time.perf_counter()
    work()
    return 1000 * (time.perf_counter() - begin)


def fleet_name(robots: int) -> str:
    """A number of robots in words."""
    return f"{robots} {'robot' if robots == 1 else 'robots'}"


def fleet_case(baud: int, robots: int, gripper: str) -> str:
    """The case of the rounds of a fleet: baud rate, number of robots, and whether the first gripper rests or moves."""
    return f"{baud} baud, {fleet_name(robots)}, {gripper}"


def drive(baud: int, robots: int, rounds: int, seed: int) -> list[Measurement]:
    """Robots that drive about and now and then move the gripper; all drives have the same commands."""
    wheels = np.random.default_rng(seed).integers(-12, 13, (rounds + _WARM_UP, 2)).tolist()
    rows, heard = [], list[bytes]()
    with (
        virtual_fleet(baud, robots, seed) as virtual,
        patch.object(virtual.firmwares[0], "handle", _recorded(virtual.firmwares[0].handle, heard)),
        Fleet([SerialKhepera(port.url, baud=baud, period=None) for port in virtual.ports]) as fleet,
    ):
        for number, (left, right) in enumerate(wheels, -_WARM_UP):
            down = number >= 0 and number // _MOVEMENT_PERIOD % 2
            for robot in fleet.robots:
                robot.drive(_motors(left, right, down))
            heard.clear()
            taken = _timed(fleet.transmit)
            virtual.advance()
            taken += _timed(fleet.receive)
            if number >= 0:
                moves = any(line.startswith((b"T,1,D", b"T,1,E", b"T,1,H")) for line in heard)
                case = fleet_case(baud, robots, MOVES if moves else RESTS)
                rows.append(Measurement("rounds", case, "bytes", len(b"".join(heard))))
                rows.append(Measurement("rounds", case, "measured", taken))
    return rows


def _recorded(handle: Callable[[bytes], bytes], heard: list[bytes]) -> Callable[[bytes], bytes]:
    """A firmware that also records requests and replies."""

    def handle_and_record(line: bytes) -> bytes:
        reply = handle(line)
        heard.extend((line + b"\n", reply))
        return reply

    return handle_and_record


def slow_line(latency: int, rounds: int, seed: int) -> list[Measurement]:
    """A robot on a line with a constant latency in ms."""
    seconds, period = latency / 1000, TIMING.round_duration
    measured = partial(Measurement, "latency", f"{latency} ms")
    with virtual_fleet(BAUD, 1, seed) as ((port,), _, advance, _):
        port.faults = Faults(delay=1.0 if latency else 0.0, lateness=(seconds, seconds))
        begin = time.perf_counter()
        try:
            robot = SerialKhepera(port.url, baud=BAUD, period=period)
        except LineTooSlow:
            return [measured("rejected after", 1000 * (time.perf_counter() - begin))]
        rows = [measured("opening", 1000 * (time.perf_counter() - begin))]
        with robot:
            robot.receive()  # as at the reset of a laboratory: all readings, twice
            clock = WallClock(period, time.perf_counter)
            _command(robot, -1)
            end = clock.beginning
            # Round -1 gives the moment from which the next one is measured.
            for number in range(-1, rounds):
                clock.wait()
                # A long delay shortens the next period, which then begins at once.
                beginning = min(clock.beginning, time.perf_counter())
                advance()  # by a whole round, after the command has arrived
                robot.receive()
                between, end = time.perf_counter() - end, time.perf_counter()
                _command(robot, number + 1)
                if number >= 0:
                    exchanged = time.perf_counter() - beginning
                    rows += [measured("end", 1000 * exchanged), measured("between", 1000 * between)]
            port.faults = Faults()
    return rows


def _command(robot: SerialKhepera, number: int) -> None:
    """Send the commands of a round."""
    robot.drive(_motors(5, number % 9, number // 5 % 2))
    robot.transmit()


def disturbed_line(disturbance: str, rounds: int, seed: int) -> list[Measurement]:
    """A robot on a line with one of `DISTURBANCES`; its last round is undisturbed, and shows what remains."""
    wheels = np.random.default_rng(seed).integers(-MAX_SPEED, MAX_SPEED + 1, (rounds, 2)).tolist()
    taken, errors, lost = list[float](), list[int](), 0
    with (
        virtual_fleet(BAUD, 1, seed) as ((port,), _, advance, truth),
        SerialKhepera(port.url, baud=BAUD, period=None) as robot,
    ):
        robot.receive()
        for number, (left, right) in enumerate(wheels, 1):
            port.faults = Faults() if number == len(wheels) else DISTURBANCES[disturbance]
            robot.drive(_motors(left, right, 0))
            begin = time.perf_counter()
            try:
                outward = _timed(robot.transmit)
                advance()
                taken.append(outward + _timed(robot.receive))
                pairs = zip(robot.sense()[1:3], truth()[1:3], strict=True)
                errors.append(max(abs(read - true) for read, true in pairs))
            except RobotLost:
                taken.append(1000 * (time.perf_counter() - begin))
                lost += 1
        counts = {
            "undetectable": port.fault_counts["undetectable"],
            "rounds with a wrong counter": sum(error > 0 for error in errors[:-1]),
            "error at the end (pulses)": errors[-1],
            "lost": lost,
        }
    measured = partial(Measurement, "disturbances", disturbance)
    return [measured("a round", ms) for ms in taken] + [measured(*count) for count in counts.items()]


def end_processes(ending: str, processes: int) -> list[Measurement]:
    """Processes that end in one way: milliseconds until the wheels stand."""
    rows = []
    for _ in range(processes):
        with (
            virtual_fleet(BAUD, 1, 0) as ((port,), (firmware,), _, _),
            subprocess.Popen(
                [sys.executable, "-c", _PROGRAM, port.url],
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                process_group=0,
            ) as process,
        ):
            assert process.stdout is not None
            process.stdout.readline()
            begin = time.perf_counter()
            process.send_signal(ENDINGS[ending])
            while firmware.turning and time.perf_counter() < begin + _TIMEOUT:
                time.sleep(0.0005)
            rows.append(Measurement("endings", ending, "wheels turn on", 1000 * (time.perf_counter() - begin)))
            process.kill()
    return rows


def table(part: str, rows: Sequence[Measurement]) -> Table:
    """All measures of a part: median [5th, 95th percentile], and the longest."""
    lines: list[dict[str, Value]] = []
    own = pick(rows, part=part)
    for case, measure in dict.fromkeys((row.case, row.measure) for row in own):
        values = [row.value for row in pick(own, case=case, measure=measure)]
        spread = quantiles(values)
        lines.append(
            {"case": case, "measure": measure, "values": len(values), "median": spread, "longest": max(values)}
        )
    note = f"{PARTS[part]} Median [5th, 95th percentile], and the longest; times in ms."
    return table_of(part, part.capitalize(), note, lines)


def picture(rows: Sequence[Measurement]) -> "Figure":
    """Rounds by baud rate, and by number of robots."""

    def spread(baud: int, robots: int, gripper: str) -> Estimate:
        own = pick(rows, part="rounds", case=fleet_case(baud, robots, gripper), measure="measured")
        return quantiles([row.value for row in own])

    figure, (left, right) = panels(2, "Time of a round")
    label = "ms: median, 5th and 95th percentile"
    rounds = {f"{baud} baud": [spread(baud, 1, gripper) for gripper in (RESTS, MOVES)] for baud in BAUD_RATES}
    levels(left, rounds, label, (RESTS, MOVES), (OURS, THESIS))
    left.axvline(PERIOD_MS, color=GREY, lw=1.2, ls="--", label=f"a round: {PERIOD_MS:.0f} ms")
    fleets = {fleet_name(n): [spread(BAUD, n, RESTS)] for n in FLEETS}
    levels(right, fleets, f"ms at {BAUD} baud")
    for axes in (left, right):
        axes.set_xlim(left=0)
    legend(figure, left, columns=3)
    return figure


def main() -> int:
    """Run the benchmark."""
    count = Count("rounds", 200, 12, "rounds at each baud rate and with each number of robots")
    given = parse("wire", __doc__, count, jobs=None)
    rounds, seed, quick = given.rounds, given.seed, given.quick
    latencies = QUICK_LATENCIES if quick else LATENCIES
    endings = list(ENDINGS)[: 4 if quick else None]
    units = [
        *(Job(f"{baud} baud", drive, (baud, 1, rounds, seed)) for baud in BAUD_RATES),
        *(Job(f"{n} robots", drive, (BAUD, n, rounds, seed)) for n in FLEETS if n > 1),
        *(Job(f"latency {ms} ms", slow_line, (ms, max(10, rounds // 4), seed)) for ms in latencies),
        *(
            Job(f"disturbance {name}", disturbed_line, (name, rounds, seed))
            for name in list(DISTURBANCES)[:: 1 + quick]
        ),
        *(Job(f"ending {name}", end_processes, (name, max(1, rounds // 40))) for name in endings),
    ]
    rows = collect(given, units, {Measurement: "measurements"}).of(Measurement)
    caption = "milliseconds of a round by baud rate, and by number of robots"
    parts: list[Table | Picture] = [table(part, rows) for part in PARTS]
    return finish(given, Page("Serial lines", [*parts, Picture("wire", caption, picture(rows))]))


if __name__ == "__main__":
    sys.exit(main())
