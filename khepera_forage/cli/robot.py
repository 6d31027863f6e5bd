"""`khepera-forage robot`: test a real robot, or start a virtual one."""

import argparse
import math
import statistics
import sys
import time
from collections.abc import Callable, Mapping
from contextlib import suppress
from itertools import count
from typing import Any

from khepera_forage.cli.options import Group, command, flag, option, refuse_ignored
from khepera_forage.cli.virtual import virtual_command
from khepera_forage.option_values import real_number, whole_number
from khepera_forage.robots.drivers import DRIVERS
from khepera_forage.robots.drivers import open_robot as open_any
from khepera_forage.robots.khepera import (
    ARM_DOWN,
    ARM_RAISED,
    CONTROL_PERIOD,
    JAW_CLOSED,
    JAW_OPEN,
    MAX_SPEED,
    PULSE,
    SPEED_UNIT,
    Motors,
    Senses,
)
from khepera_forage.robots.mat import MatRobot
from khepera_forage.robots.model import KHEPERA
from khepera_forage.robots.proximity import MAX_READING
from khepera_forage.robots.real_robot import RealRobot
from khepera_forage.robots.serial.line import DEFAULT_TIMEOUT, MAX_TIMEOUT, RequestRejected
from khepera_forage.robots.serial.protocol import BAUD_RATES, Range
from khepera_forage.robots.serial.serial_robot import SerialRobot

_REST_TIMEOUT = 4.0
"""Seconds to wait for the gripper: an arm needs 1 s and a jaw 0.6 s (KNET); the rest is margin."""
_REST_READINGS = 3
"""Equal readings in a row, 0.1 s apart, that count as standing still."""
_MAX_SECONDS = 60.0
"""Longest drive of one command: an operator does not watch a robot for longer."""
_JAW, _ARM = "T,1,D", "T,1,E"
_MOVEMENTS = {"open": (_JAW, 0), "close": (_JAW, 1), "raise": (_ARM, ARM_RAISED), "lower": (_ARM, ARM_DOWN)}
_ROUND_TRIPS = 10
"""Measurements of each response time."""
_NAMES = ("left 90", "left 45", "left 10", "right 10", "right 45", "right 90", "back right", "back left")
_BAR_WIDTH = 50
_CURSOR_UP, _CLEAR_LINE = "\x1b[{}A", "\x1b[K"  # of terminals
_UNIT = f"in speed units of {SPEED_UNIT:g} mm/s, -{MAX_SPEED}..{MAX_SPEED}"
_SPEED, _SECONDS = 6, 0.3
"""Speed in units and duration of the wheel test: 14 mm each way, within the 0.3 s of a cube's command."""
_LOWERED = ARM_DOWN - 15
"""Arm position near the floor, above any object that may lie there."""
_ARM_TOLERANCE, _JAW_TOLERANCE = 8, 24
"""Largest deviation of a position that passes."""
_ROUNDS = 10
_PORT = "/dev/ttyUSB0, socket://host:port, rfc2217://host:port, or the name of a toio cube, such as toio-A1b"
_BAUD = f"as set by a Khepera's mode switch: {', '.join(map(str, BAUD_RATES))} (38400; of an e-puck2 115200)"
_TIMEOUT = f"that a reply may take in addition to the transmission time of its bytes ({DEFAULT_TIMEOUT})"
PORT = (
    option("--robot", f"kind of robot ({KHEPERA.name})", choices=tuple(DRIVERS), default=KHEPERA.name),
    option("--port", f"the robot's port: {_PORT}", required=True),
    option("--baud", _BAUD, int),
    option("--timeout", _TIMEOUT, real_number(0.0, MAX_TIMEOUT, "seconds"), "SECONDS"),
    flag("--no-watchdog", "start no process that stops the robot if this program is killed"),
)


def open_robot(arguments: argparse.Namespace) -> RealRobot:
    """The driver of the robot at the port, on a line with any latency: these commands have no rounds to keep."""
    if not issubclass(DRIVERS[arguments.robot], SerialRobot):
        refuse_ignored(arguments, ["--baud", "--timeout", "--no-watchdog"], "for a robot with a serial line")
    timeout = DEFAULT_TIMEOUT if arguments.timeout is None else arguments.timeout
    options = {"baud": arguments.baud, "timeout": timeout, "watchdog": not arguments.no_watchdog}
    return open_any(arguments.robot, arguments.port, period=None, **options)


def open_serial_robot(arguments: argparse.Namespace) -> SerialRobot:
    """As `open_robot`, for a robot with a serial line."""
    robot = open_robot(arguments)
    assert isinstance(robot, SerialRobot)
    return robot


def moved(robot: SerialRobot, command: str, value: int) -> tuple[int, float]:
    """The position at which the arm or the jaw stands still after a command, or where it is after 4 s.

    Returns:
        The position, and the seconds after which it was first seen there.
    """
    robot.request(command, value)
    is_arm, begin = command == _ARM, time.monotonic()
    last, equal, seconds = math.nan, 0, 0.0
    while True:
        time.sleep(CONTROL_PERIOD)
        (position,) = map(int, robot.request("T,1,H", int(is_arm)))
        passed = time.monotonic() - begin
        if position == last:
            equal += 1
        else:
            last, equal, seconds = position, 0, passed
        if equal >= _REST_READINGS or passed > _REST_TIMEOUT:
            return position, seconds


@command(*PORT)
def probe_command(arguments: argparse.Namespace) -> None:
    """Print the robot's versions, sensor readings and response times."""
    model = DRIVERS[arguments.robot].model
    serial = [kind for kind, driver in DRIVERS.items() if issubclass(driver, SerialRobot)]
    if model.name not in serial:
        raise ValueError(f"--robot {model.name}; allowed: {', '.join(serial)}, which have a serial line")
    with open_serial_robot(arguments) as robot:
        print(f"port       {robot.port}, {robot.baud} baud")
        identity = robot.protocol.identity
        version = robot.request(identity.command, *identity.values)
        if model.has_gripper:
            print(f"robot      BIOS {version[0]}, protocol {version[1]}")
            print(f"gripper    {_gripper(robot)}")
        else:
            print(f"robot      {model.name}, {version[0]}")
        directions = ", ".join(f"{degrees:g}" for degrees in model.infra_reds)
        print(f"proximity  {_numbers(robot.request('N'))}   (degrees to the left: {directions})")
        print(f"light      {_numbers(robot.request('O'))}   (the higher, the darker)")
        counters, _ = robot.protocol.counters
        print(f"counters   {_numbers(robot.request(counters))}   (left, right; {model.pulse:.3g} mm each)")
        timed: list[tuple[Any, ...]] = [(identity.command,), ("N",), (counters,)]
        for command in [*timed, ("T,1,G",), ("T,1,H", 1)] if model.has_gripper else timed:
            with suppress(RequestRejected):
                print(f"{','.join(map(str, command)):10s} {_round_trips(robot, *command)}")
        timing, counts = robot.timing, robot.statistics
        latency, taken, rate = 1000 * timing.latency, 1000 * timing.round_time, 1 / timing.round_time
        why = "" if timing.pipelined else ", because the robot answers only one request at a time"
        print(f"latency    {latency:.1f} ms in addition to the transmission; a round takes {taken:.0f} ms: ", end="")
        print(f"at most {rate:.1f} rounds a second{why}")
        print(f"line       {counts.sent} requests, {counts.timeouts} unanswered, {counts.garbled} garbled")


def _gripper(robot: SerialRobot) -> str:
    """The gripper's version and state, or why it does not answer."""
    try:
        version, revision = robot.request("T,1,B")
        (jumpers,) = robot.request("T,1,J")
        (arm,) = robot.request("T,1,H", 1)
        (barrier,) = robot.request("T,1,G")
        (jaw,) = robot.request("T,1,H", 0)
    except RequestRejected as error:
        return f"none: {error.reason}"
    return (
        f"version {version}.{revision}, jumpers {jumpers}; arm {arm} (255 down), jaw {jaw} (200 open), "
        f"barrier {barrier} (above 100: an object)"
    )


def _round_trips(robot: SerialRobot, command: str, *values: int) -> str:
    """Median and range of the response time of one command."""
    taken = []
    for _ in range(_ROUND_TRIPS):
        # Alternate with another command: the driver sends a query of its own before it repeats a command.
        robot.request("E")
        begin = time.perf_counter()
        robot.request(command, *values)
        taken.append(1000 * (time.perf_counter() - begin))
    return f"{statistics.median(taken):.1f} ms round trip [{min(taken):.1f}, {max(taken):.1f}]"


def _numbers(values: tuple[int | str, ...]) -> str:
    return " ".join(f"{value:>4}" for value in values)


@command(*PORT, option("--rounds", "number of rounds of 0.1 s; 0 runs until Ctrl-C (0)", whole_number(0), default=0))
def sensors_command(arguments: argparse.Namespace) -> None:
    """Show the sensor readings as they change."""
    live = sys.stdout.isatty()
    with open_robot(arguments) as robot:
        if not live:
            print("L90 L45 L10 R10 R45 R90 backR backL | left right pulses | arm jaw present")
        due = time.monotonic()
        for number in range(arguments.rounds) if arguments.rounds else count():
            robot.receive()
            proximity, left, right, arm, jaw, presence = senses = robot.sense()
            text = bars(senses) if live else f"{_numbers(proximity)} | {left} {right} | {arm} {jaw} {presence}"
            if live and number:
                print(_CURSOR_UP.format(text.count("\n") + 1), end="")
            print(text, flush=True)
            due = max(due + CONTROL_PERIOD, time.monotonic())
            time.sleep(max(0.0, due - time.monotonic()))


def bars(senses: Senses) -> str:
    """One bar for each infra-red sensor, and the other readings below; each line clears its predecessor."""
    lines = []
    for name, reading in zip(_NAMES, senses.proximity, strict=True):
        bar = "█" * round(_BAR_WIDTH * reading / MAX_READING)
        lines.append(f"{name:>10} {reading:5d} {bar:<{_BAR_WIDTH}}")
    lines.append(
        f"{'arm':>10} {senses.arm:5d}   jaw {senses.jaw}   {'object' if senses.object_presence else 'nothing'} between "
        f"the fingers   wheels {senses.left_pulses} {senses.right_pulses}"
    )
    return "\n".join(f"{text}{_CLEAR_LINE}" for text in lines)


@command(
    *PORT,
    option("--left", f"left wheel, {_UNIT} (3)", whole_number(-MAX_SPEED, MAX_SPEED), default=3),
    option("--right", f"right wheel, {_UNIT} (3)", whole_number(-MAX_SPEED, MAX_SPEED), default=3),
    option("--seconds", f"duration, at most {_MAX_SECONDS:g} (2)", real_number(0, _MAX_SECONDS, "seconds"), default=2),
)
def drive_command(arguments: argparse.Namespace) -> None:
    """Turn the wheels for some seconds, then stop."""
    with open_robot(arguments) as robot:
        robot.receive()
        before = robot.sense()
        end = time.monotonic() + arguments.seconds
        while (rest := end - time.monotonic()) > 0:
            # Again and again: a robot that restarts meanwhile drives on, and one that is lost raises an error.
            robot.turn_wheels(arguments.left, arguments.right)
            robot.receive()
            time.sleep(max(0.0, min(rest, CONTROL_PERIOD)))
        robot.stop()
        robot.receive()
        after = robot.sense()
    restarts = robot.statistics.restarts if isinstance(robot, SerialRobot) else 0
    if restarts:
        print(f"the robot restarted {restarts} time{'s' * (restarts > 1)}: check its power supply")
    left, right = after.left_pulses - before.left_pulses, after.right_pulses - before.right_pulses
    mm = PULSE * robot.model.scale
    print(f"left {left} pulses, {mm * left:.0f} mm; right {right} pulses, {mm * right:.0f} mm")


@command(*PORT, option("action", "the movement", choices=tuple(_MOVEMENTS)))
def grip_command(arguments: argparse.Namespace) -> None:
    """Open, close, raise or lower the gripper."""
    able = [kind for kind, driver in DRIVERS.items() if driver.model.has_gripper]
    if arguments.robot not in able:
        raise ValueError(f"--robot {arguments.robot} has no gripper; allowed: {', '.join(able)}")
    with open_serial_robot(arguments) as robot:
        command, value = _MOVEMENTS[arguments.action]
        position, _ = moved(robot, command, value)
        (barrier,) = robot.request("T,1,G")
        print(f"{'arm' if command == _ARM else 'jaw'} at {position}, barrier {barrier}")


class CheckError(Exception):
    """A check failed; the message says what was measured."""


@command(*PORT)
def selftest_command(arguments: argparse.Namespace) -> int:
    """Test every part with small movements, and print which ones work."""
    failed, checks = 0, checks_of(DRIVERS[arguments.robot])
    with open_robot(arguments) as robot:
        moving = "wheels, arm and jaw" if robot.model.has_gripper else "the wheels"
        print(f"Keep 30 mm free around the robot: {moving} will move a little.", flush=True)
        for name, check in checks.items():
            try:
                verdict, measured = "pass", check(robot)
            except CheckError as failure:
                verdict, measured = "FAIL", str(failure)
            except RequestRejected as refusal:
                verdict, measured = "FAIL", f"{refusal.command}: {refusal.reason}"
            failed += verdict == "FAIL"
            print(f"{name:18s} {verdict}   {measured}", flush=True)
    print(f"{len(checks) - failed} of {len(checks)} passed")
    return 1 if failed else 0


def _versions(robot: SerialRobot) -> str:
    return ", ".join(map(str, robot.request(robot.protocol.identity.command)))


def _lamps(robot: RealRobot) -> str:
    robot.flash()
    return "all were switched on and off; check that you saw them"


def _mat(robot: MatRobot) -> str:
    robot.receive()
    if not robot.on_mat:
        raise CheckError("it does not see the mat: put it on the simple mat, and check that its sensor is clean")
    x, y, heading = robot.pose
    return f"at x {x:.0f} mm, y {y:.0f} mm of the plan, heading {round(math.degrees(heading)) % 360} degrees"


def _infra_reds(robot: SerialRobot) -> str:
    rounds = [robot.request("N") for _ in range(5)]
    allowed = robot.protocol.commands["N"].results[0]
    assert isinstance(allowed, Range)
    highest = allowed.high
    if any(set(readings) == {highest} for readings in rounds):
        raise CheckError(f"all eight read {highest}")
    medians = [int(statistics.median(map(int, column))) for column in zip(*rounds, strict=True)]
    return f"proximity {' '.join(map(str, medians))}"


def _light(robot: SerialRobot) -> str:
    light = [int(value) for value in robot.request("O")]
    if max(light) == 0:
        raise CheckError("all eight read 0, the value of the brightest light")
    return f"{min(light)}..{max(light)} (the higher, the darker)"


def _wheels(robot: RealRobot) -> str:
    start = _counters(robot)
    forth = _travel(robot, _SPEED)
    back = _travel(robot, -_SPEED)
    off = [b - a for a, b in zip(start, _counters(robot), strict=True)]
    # A virtual robot moves in rounds of a third of the time.
    if max(map(abs, off)) > 0.5 * _SPEED * SPEED_UNIT / PULSE * _SECONDS:
        raise CheckError(f"forward {forth} and back {back} pulses end {off} pulses from the start")
    return f"forward {forth}, back {back} pulses, {off} from the start"


def _travel(robot: RealRobot, speed: int) -> list[int]:
    """Turn both wheels and return their pulses; half to one and a half times the expected number passes.

    The range is wide because a low supply voltage slows the motors, and a cube has few speeds.
    """
    before = _counters(robot)
    begin = time.monotonic()
    robot.turn_wheels(speed, speed)
    time.sleep(_SECONDS)
    robot.stop()
    expected = speed * SPEED_UNIT / PULSE * (time.monotonic() - begin)
    time.sleep(2 * CONTROL_PERIOD)
    gone = [after - b for after, b in zip(_counters(robot), before, strict=True)]
    if any(not 0.5 < pulses / expected < 1.5 for pulses in gone):
        raise CheckError(f"{gone} pulses at speed {speed}; expected: about {expected:.0f}")
    return gone


def _counters(robot: RealRobot) -> tuple[int, int]:
    """The encoder counts of the left and right wheel, in pulses."""
    robot.receive()
    return robot.sense()[1:3]


def _arm(robot: SerialRobot) -> str:
    measured, seconds = _reached(
        robot, _ARM, _ARM_TOLERANCE, {"raised": ARM_RAISED, "lowered": _LOWERED, "again": ARM_RAISED}
    )
    slow = seconds > 1.5 * CONTROL_PERIOD
    advice = "; longer than a round: train and recall with --decision lowering_speed=0" if slow else ""
    return f"{measured} in {seconds:.1f} s{advice}"


def _jaw(robot: SerialRobot) -> str:
    return _reached(robot, _JAW, _JAW_TOLERANCE, {"closed": JAW_CLOSED, "opened": JAW_OPEN})[0]


def _reached(robot: SerialRobot, command: str, tolerance: int, targets: Mapping[str, int]) -> tuple[str, float]:
    """Move the arm or the jaw to one position after the other; the positions, and the seconds of the last movement."""
    told, seconds = [], 0.0
    for name, target in targets.items():
        position, seconds = moved(robot, command, target if command == _ARM else int(target == JAW_CLOSED))
        if abs(position - target) > tolerance:
            raise CheckError(f"{name}, it stopped at {position}; expected: about {target}")
        told.append(f"{name}: {position}")
    return ", ".join(told), seconds


def _barrier(robot: SerialRobot) -> str:
    (barrier,) = robot.request("T,1,G")
    measured = f"{barrier} with nothing between the fingers"
    if int(barrier) > 100:
        raise CheckError(measured)
    return measured


def _rounds(robot: RealRobot) -> str:
    taken = []
    for _ in range(_ROUNDS):
        begin = time.monotonic()
        robot.drive(Motors(0, 0, ARM_RAISED, JAW_OPEN))
        robot.transmit()
        robot.receive()
        taken.append(1000 * (time.monotonic() - begin))
    limit = 1000 * CONTROL_PERIOD
    measured = f"{statistics.median(taken):.0f} ms, the longest {max(taken):.0f}; allowed: {limit:.0f}"
    if statistics.median(taken) > limit:
        raise CheckError(measured)
    return measured


def _line(robot: SerialRobot) -> str:
    counts = robot.statistics
    if counts.timeouts + counts.garbled + counts.rejected + counts.restarts:
        raise CheckError(f"{counts}")
    return f"{counts.sent} requests, all answered"


Check = Callable[[Any], str]
"""Tests a part of a robot; returns what it measured, or raises `CheckError`."""


def checks_of(driver: type[RealRobot]) -> dict[str, Check]:
    """The checks of a kind of robot, by part.

    The arm comes before the infra-reds: raised, it does not cover them.
    """
    serial, gripper = issubclass(driver, SerialRobot), driver.model.has_gripper
    checks: list[tuple[str, Check, bool]] = [
        ("mat", _mat, issubclass(driver, MatRobot)),
        ("versions", _versions, serial),
        ("lamps", _lamps, True),
        ("arm", _arm, gripper),
        ("jaw", _jaw, gripper),
        ("optical barrier", _barrier, gripper),
        ("infra-reds", _infra_reds, serial),
        ("ambient light", _light, serial),
        ("wheels", _wheels, True),
        ("a round", _rounds, True),
        ("line", _line, serial),
    ]
    return {name: check for name, check, applies in checks if applies}


robot_command = Group(
    "Test a real robot, or start a virtual one.",
    (probe_command, sensors_command, drive_command, grip_command, selftest_command, virtual_command),
)
