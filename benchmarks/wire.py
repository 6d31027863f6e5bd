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
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, NamedTuple
from unittest.mock import patch

import numpy as np
from laboratory import Work

from khepera_forage.envs.arguments import checked_arena, timing_of
from khepera_forage.estimates import UNKNOWN, Estimate, Table, Value, extremes, pick, quantiles, table_of
from khepera_forage.figures import GREY, OURS, THESIS, WIDTH, legend, new_figure
from khepera_forage.lab.clock import WallClock
from khepera_forage.robots.fleet import Fleet
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
from khepera_forage.robots.serial.line import LineTooSlow
from khepera_forage.robots.serial.protocol import BAUD_RATES, seconds_on_wire
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from khepera_forage.robots.virtual.firmware import Firmware
from khepera_forage.robots.virtual.virtual_khepera import Faults, VirtualKhepera
from khepera_forage.sim.arena import copies
from khepera_forage.sim.arenas.thesis import CORRIDOR
from khepera_forage.sim.pymunk.world import PymunkWorld
from khepera_forage.sim.world import Layout
from khepera_forage.study import Count, Page, Picture, collect, finish, parse
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
    "termination": signal.SIGTERM,
    "hang-up": signal.SIGHUP,
    "Ctrl-\\": signal.SIGQUIT,
    "Ctrl-Z": signal.SIGTSTP,
    "SIGABRT": signal.SIGABRT,
    "SIGALRM": signal.SIGALRM,
    "SIGXCPU": signal.SIGXCPU,
    "crash (SIGSEGV)": signal.SIGSEGV,
    "os._exit": None,
    "kill -9": signal.SIGKILL,
    "SIGSTOP": signal.SIGSTOP,
}
QUICK_ENDINGS = ("Ctrl-C", "Ctrl-Z", "kill -9", "SIGSTOP")
DECISIONS = replace(DEFAULT_DECISIONS, arm_travel_time=1.0)
"""An arm that takes several rounds, as the driver expects, so that rounds with a moving gripper are typical ones."""
TIMING = timing_of(DECISIONS)
PERIOD_MS = 1000 * TIMING.round_duration
_MOVEMENT_PERIOD = 2 * math.ceil(DECISIONS.arm_travel_time / TIMING.round_duration)
"""Rounds from one movement of the gripper to the next: in half of the rounds, the arm moves."""
_WARM_UP = 12
"""Rounds that are not counted: first readings are requested twice, and the gripper comes to rest."""
_KINDS = {False: "gripper rests", True: "gripper moves, or its position is read"}
_VARIATION = 1000 * seconds_on_wire(84, BAUD)
"""Milliseconds by which the replies to a `receive` differ, with and without positions of the gripper."""
_TIMEOUT = 5.0
"""Seconds after which wheels count as turning for good."""
_PROGRAM = """
import os, signal, sys
# A shell starts programs in the background with some signals ignored, and their children inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)
for number in (signal.SIGQUIT, signal.SIGHUP, signal.SIGTSTP):
    signal.signal(number, signal.SIG_DFL)
from khepera_forage.robots.khepera import Motors
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
with SerialKhepera(sys.argv[1]) as robot:
    robot.drive(Motors(5, 5, 215, 200))
    robot.transmit()
    print("driving", flush=True)
    sys.stdin.readline()
    os._exit(0)
"""


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


@dataclass(frozen=True, slots=True)
class Round:
    """A round of a fleet: whether its gripper moved or was read, bytes to and from the first robot, and milliseconds.

    `wire` is the time of these bytes on the line; `taken` that of `transmit` and `receive` of all robots.
    """

    baud: int
    robots: int
    gripper: bool
    bytes: int
    wire: float
    taken: float


def drive(baud: int, robots: int, rounds: int, seed: int) -> list[Round]:
    """Robots that drive about and now and then move the gripper; all drives have the same commands."""
    wheels = np.random.default_rng(seed).integers(-12, 13, (rounds + _WARM_UP, 2)).tolist()
    rows, heard = [], list[bytes]()
    with (
        virtual_fleet(baud, robots, seed) as virtual,
        patch.object(virtual.firmwares[0], "handle", recorded(virtual.firmwares[0].handle, heard)),
        closing(SerialKhepera(virtual.ports[0].url, baud=baud)) as first,
        Fleet([first, *(SerialKhepera(port.url, baud=baud) for port in virtual.ports[1:])]) as fleet,
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
                gripper = any(line.startswith((b"T,1,D", b"T,1,E", b"T,1,H")) for line in heard)
                count = len(b"".join(heard))
                rows.append(Round(baud, robots, gripper, count, 1000 * seconds_on_wire(count, baud), taken))
    return rows


def _timed(work: Callable[[], None]) -> float:
    """Milliseconds that something takes."""
    begin = time.perf_counter()
    work()
    return 1000 * (time.perf_counter() - begin)


def recorded(handle: Callable[[bytes], bytes], heard: list[bytes]) -> Callable[[bytes], bytes]:
    """A firmware that also records requests and replies."""

    def handle_and_record(line: bytes) -> bytes:
        reply = handle(line)
        heard.extend((line + b"\n", reply))
        return reply

    return handle_and_record


@dataclass(frozen=True, slots=True)
class SlowRound:
    """One round on a line with a latency, or the rejection of the line. Times are in ms.

    Attributes:
        latency: Of the line.
        opening: Time that opening took.
        accepted: Whether the line was; otherwise, all that follows is 0.
        exchanged: From the beginning of the period to the end of its exchange.
        taken: From the arrival of the last round's readings to that of this one's.
    """

    latency: int
    opening: float
    accepted: bool
    exchanged: float = 0.0
    taken: float = 0.0


def slow_line(latency: int, rounds: int, seed: int) -> list[SlowRound]:
    """A robot on a line with a constant latency in ms."""
    seconds, period = latency / 1000, TIMING.round_duration
    with virtual_fleet(BAUD, 1, seed) as ((port,), _, advance, _):
        port.faults = Faults(delay=1.0 if latency else 0.0, lateness=(seconds, seconds))
        begin = time.perf_counter()
        try:
            robot = SerialKhepera(port.url, baud=BAUD, period=period)
        except LineTooSlow:
            return [SlowRound(latency, 1000 * (time.perf_counter() - begin), False)]
        opening = 1000 * (time.perf_counter() - begin)
        rows = []
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
                taken = time.perf_counter() - end
                end += taken
                _command(robot, number + 1)
                exchanged = time.perf_counter() - beginning
                if number >= 0:
                    rows.append(SlowRound(latency, opening, True, 1000 * exchanged, 1000 * taken))
            port.faults = Faults()
    return rows


def _command(robot: SerialKhepera, number: int) -> None:
    """Send the commands of a round."""
    robot.drive(_motors(5, number % 9, number // 5 % 2))
    robot.transmit()


@dataclass(frozen=True, slots=True)
class DisturbedRound:
    """One round on a disturbed line.

    Attributes:
        disturbance: A key of `DISTURBANCES`.
        taken: Milliseconds of `transmit` and `receive`.
        error: Pulses by which the worse counter differs from the truth; 0 after a loss.
        undetectable: Garbled replies so far that are well-formed.
        unknown: Readings so far that could not be confirmed.
        lost: Whether the robot counted as lost.
    """

    disturbance: str
    taken: float
    error: int
    undetectable: int
    unknown: int
    lost: bool


def disturbed_line(disturbance: str, rounds: int, seed: int) -> list[DisturbedRound]:
    """A robot on a line with one of `DISTURBANCES`; its last round is undisturbed, and shows what remains."""
    rng = np.random.default_rng(seed)
    wheels = rng.integers(-MAX_SPEED, MAX_SPEED + 1, (rounds, 2)).tolist()
    rows = []
    with (
        virtual_fleet(BAUD, 1, seed) as ((port,), _, advance, truth),
        SerialKhepera(port.url, baud=BAUD) as robot,
    ):
        robot.receive()
        for number, (left, right) in enumerate(wheels, 1):
            port.faults = Faults() if number == len(wheels) else DISTURBANCES[disturbance]
            lost, error, begin = False, 0, time.perf_counter()
            robot.drive(_motors(left, right, 0))
            try:
                taken = _timed(robot.transmit)
                advance()
                taken += _timed(robot.receive)
                pairs = zip(robot.sense()[1:3], truth()[1:3], strict=True)
                error = max(abs(read - true) for read, true in pairs)
            except RobotLost:
                taken, lost = 1000 * (time.perf_counter() - begin), True
            counts = port.fault_counts["undetectable"], robot.statistics.unknown
            rows.append(DisturbedRound(disturbance, taken, error, *counts, lost))
        port.faults = Faults()
    return rows


@dataclass(frozen=True, slots=True)
class End:
    """The end of a process that drives a robot: one of `ENDINGS`, and milliseconds until the wheels were stopped."""

    ending: str
    taken: float


def end_processes(ending: str, processes: int) -> list[End]:
    """Processes that end in one way."""
    return [End(ending, 1000 * seconds_until_stopped(ending)) for _ in range(processes)]


def seconds_until_stopped(ending: str) -> float:
    """Seconds from the end of a process in this way until the wheels stand."""
    with (
        virtual_fleet(BAUD, 1, 0) as ((port,), (firmware,), _, _),
        subprocess.Popen(
            [sys.executable, "-c", _PROGRAM, port.url],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            process_group=0,
        ) as process,
    ):
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdout.readline()
        begin = time.perf_counter()
        number = ENDINGS[ending]
        if number is None:
            process.stdin.write(b"\n")
            process.stdin.flush()
        else:
            process.send_signal(number)
        while firmware.turning and time.perf_counter() < begin + _TIMEOUT:
            time.sleep(0.0005)
        taken = math.inf if firmware.turning else time.perf_counter() - begin
        process.kill()
    return taken


def wire_table(rows: Sequence[Round]) -> Table:
    """Rounds of one robot by baud rate."""
    note = (
        f"One robot moves wheels and gripper, whose arm takes {DECISIONS.arm_travel_time:g} s. On the wire: median "
        "[lowest, highest], 11 bits a byte. Measured: `transmit` and `receive`, median [5th, 95th percentile]."
    )
    lines: list[dict[str, Value]] = [
        {
            "baud": baud,
            "round": kind,
            "rounds": len(own),
            "on the wire (ms)": extremes([row.wire for row in own]),
            "measured (ms)": quantiles([row.taken for row in own]),
            f"within {PERIOD_MS:.0f} ms (%)": 100.0 * sum(row.taken <= PERIOD_MS for row in own) / len(own),
        }
        for baud in BAUD_RATES
        for gripper, kind in _KINDS.items()
        if (own := pick(rows, baud=baud, robots=1, gripper=gripper))
    ]
    return table_of("wire", "Time on the wire", note, lines)


def _by_fleet(rows: Sequence[Round]) -> dict[int, Estimate]:
    own = {robots: pick(rows, baud=BAUD, robots=robots, gripper=False) for robots in FLEETS}
    return {robots: quantiles([row.taken for row in its]) for robots, its in own.items()}


def fleet_table(rows: Sequence[Round]) -> Table:
    """Rounds by number of robots."""
    note = f"At {BAUD} baud; rounds in which the first robot's gripper rests: median [5th, 95th percentile]."
    measured = _by_fleet(rows)
    lines: list[dict[str, Value]] = [
        {"robots": robots, "a round (ms)": taken, "times one robot's": taken.value / measured[1].value}
        for robots, taken in measured.items()
    ]
    return table_of("fleet", "Several robots in parallel", note, lines, {"times one robot's": 2})


def latency_table(rows: Sequence[SlowRound]) -> Table:
    """Opening and rounds by latency."""
    note = (
        f"One robot at {BAUD} baud. End: from the beginning of a period until its commands are sent. Between: from the "
        "arrival of a round's readings to that of the next round's. Median [5th, 95th percentile], longest and bound, "
        "in ms."
    )
    lines: list[dict[str, Value]] = []
    for latency in dict.fromkeys(row.latency for row in rows):
        own = pick(rows, latency=latency)
        accepted = own[0].accepted
        exchanged, taken = [row.exchanged for row in own], [row.taken for row in own]
        lines.append(
            {
                "latency": latency,
                "opening": own[0].opening,
                "line": "accepted" if accepted else "rejected",
                "end": quantiles(exchanged) if accepted else UNKNOWN,
                "longest": max(exchanged) if accepted else math.nan,
                "bound": PERIOD_MS + latency if accepted else math.nan,
                "between": quantiles(taken) if accepted else UNKNOWN,
                "longest between": max(taken) if accepted else math.nan,
                "bound between": PERIOD_MS + max(latency, _VARIATION) if accepted else math.nan,
            }
        )
    return table_of("latency", "Lines with a latency", note, lines, dict.fromkeys(lines[0], 0))


def disturbance_table(rows: Sequence[DisturbedRound]) -> Table:
    """Rounds and errors by disturbance."""
    note = (
        f"One robot at {BAUD} baud with random speeds. Undetectable: garbled replies that are well-formed. Unknown: "
        "readings that could not be confirmed. The last round is undisturbed."
    )
    lines: list[dict[str, Value]] = [
        {
            "replies": disturbance,
            "rounds": len(own),
            "a round (ms)": quantiles([row.taken for row in own]),
            "longest (ms)": max(row.taken for row in own),
            "undetectable": own[-1].undetectable,
            "counters wrong (rounds)": sum(row.error > 0 for row in own[:-1]),
            "counter error at the end (pulses)": own[-1].error,
            "unknown": own[-1].unknown,
            "lost": sum(row.lost for row in own),
        }
        for disturbance in dict.fromkeys(row.disturbance for row in rows)
        if (own := pick(rows, disturbance=disturbance))
    ]
    return table_of("disturbances", "Disturbed lines", note, lines, {"a round (ms)": 0, "longest (ms)": 0})


def ending_table(rows: Sequence[End]) -> Table:
    """Milliseconds by ending."""
    note = f"From the end of a process until the robot, at {BAUD} baud, receives the stop: median [lowest, highest]."
    turning = "wheels turn on (ms)"
    lines: list[dict[str, Value]] = [
        {
            "end of the process": ending,
            "processes": len(own),
            turning: extremes([row.taken for row in own]),
        }
        for ending in ENDINGS
        if (own := pick(rows, ending=ending))
    ]
    return table_of("endings", "Ends of a process", note, lines, {turning: 0})


def picture(rows: Sequence[Round]) -> "Figure":
    """Rounds by baud rate, and by number of robots."""
    figure = new_figure(WIDTH, 4.2)
    left, right = figure.subplots(1, 2)
    for gripper, colour, shift in ((False, OURS, -0.18), (True, THESIS, 0.18)):
        own = [pick(rows, baud=baud, robots=1, gripper=gripper) for baud in BAUD_RATES]
        places = [place + shift for place in range(len(own))]
        for name, what, alpha in (("taken", "measured", 0.35), ("wire", "on the wire", 1.0)):
            medians = [quantiles([getattr(row, name) for row in its]).value for its in own]
            left.bar(places, medians, 0.34, color=colour, alpha=alpha, label=f"{_KINDS[gripper]}: {what}")
    left.axhline(PERIOD_MS, color=GREY, lw=1.2, ls="--", label=f"a round: {PERIOD_MS:.0f} ms")
    left.set_xticks(range(len(BAUD_RATES)), list(map(str, BAUD_RATES)))
    left.set(xlabel="baud", ylabel="time of a round (ms, median)")
    legend(figure, left, columns=2)
    measured = _by_fleet(rows)
    values, low, high = zip(*measured.values(), strict=True)
    bars = [np.subtract(values, low), np.subtract(high, values)]
    right.bar(range(len(values)), values, 0.5, color=OURS, yerr=bars, ecolor=GREY, capsize=3)
    right.set_xticks(range(len(values)), [str(robots) for robots in measured])
    right.set_xlabel(f"robots in parallel, {BAUD} baud")
    right.set_ylabel("time of a round (ms, median)\nbars: 5th to 95th percentile")
    right.set_ylim(bottom=0)
    return figure


def main() -> int:
    """Run the benchmark."""
    count = Count("rounds", 200, 12, "rounds at each baud rate and with each number of robots")
    given = parse("wire", __doc__, count, jobs=None)
    rounds, seed, quick = given.rounds, given.seed, given.quick
    units = [
        *(Work(f"{baud} baud", partial(drive, baud, 1, rounds, seed)) for baud in BAUD_RATES),
        *(Work(f"{n} robots", partial(drive, BAUD, n, rounds, seed)) for n in FLEETS if n > 1),
        *(
            Work(f"latency {ms} ms", partial(slow_line, ms, max(10, rounds // 4), seed))
            for ms in (QUICK_LATENCIES if quick else LATENCIES)
        ),
        *(
            Work(f"disturbance {name}", partial(disturbed_line, name, rounds, seed))
            for name in list(DISTURBANCES)[:: 1 + quick]
        ),
        *(
            Work(f"ending {name}", partial(end_processes, name, max(1, rounds // 40)))
            for name in (QUICK_ENDINGS if quick else ENDINGS)
        ),
    ]
    tables = {Round: "rounds", SlowRound: "slow_lines", DisturbedRound: "disturbed_lines", End: "endings"}
    rows = collect(given, units, tables)
    rounds = rows.of(Round)
    parts: list[Table | Picture] = [
        wire_table(rounds),
        fleet_table(rounds),
        latency_table(rows.of(SlowRound)),
        disturbance_table(rows.of(DisturbedRound)),
        ending_table(rows.of(End)),
        Picture("wire", "milliseconds of a round by baud rate, and by number of robots", picture(rounds)),
    ]
    return finish(given, Page("Serial lines", parts))


if __name__ == "__main__":
    sys.exit(main())
