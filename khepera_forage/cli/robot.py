"""`khepera-forage robot`: test a real Khepera, e-puck2 or toio cube, or start a virtual robot."""

import argparse
import statistics
import sys
import time
from typing import Any

from khepera_forage.cli import selftest, virtual
from khepera_forage.cli.options import Command, option
from khepera_forage.cli.robot_port import PORT, open_robot, open_serial_robot, wait_for_rest
from khepera_forage.option_values import real_number, whole_number
from khepera_forage.robots.khepera import (
    ARM_DOWN,
    ARM_RAISED,
    CONTROL_PERIOD,
    MAX_SPEED,
    PULSE,
    SPEED_UNIT,
    Senses,
)
from khepera_forage.robots.model import E_PUCK, KHEPERA, MODELS
from khepera_forage.robots.proximity import MAX_READING
from khepera_forage.robots.serial.line import RequestRejected
from khepera_forage.robots.serial.serial_robot import SerialRobot

_MAX_SECONDS = 60.0
"""Longest drive of one command: an operator does not watch a robot for longer."""
_GRIPPER_COMMANDS = {
    "open": ("T,1,D", 0),
    "close": ("T,1,D", 1),
    "raise": ("T,1,E", ARM_RAISED),
    "lower": ("T,1,E", ARM_DOWN),
}
_ROUND_TRIPS = 10
"""Measurements of each response time."""
_COUNTERS = {KHEPERA.name: "H", E_PUCK.name: "Q"}
_NAMES = ("left 90", "left 45", "left 10", "right 10", "right 45", "right 90", "back right", "back left")
_BAR_WIDTH = 50
_CURSOR_UP, _CLEAR_LINE = "\x1b[{}A", "\x1b[K"
"""Terminal escape sequences."""


def _probe(arguments: argparse.Namespace) -> int:
    """Query the robot and print its answers; nothing moves, and turning wheels are stopped."""
    model = MODELS[arguments.robot]
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
        print(
            f"counters   {_numbers(robot.request(_COUNTERS[model.name]))}   (left, right; {model.pulse:.3g} mm each)"
        )
        timed: list[tuple[Any, ...]] = [(identity.command,), ("N",), (_COUNTERS[model.name],)]
        for command in [*timed, ("T,1,G",), ("T,1,H", 1)] if model.has_gripper else timed:
            try:
                print(f"{','.join(map(str, command)):10s} {_round_trips(robot, *command)}")
            except RequestRejected:
                continue
        timing, counts = robot.timing, robot.statistics
        print(
            f"latency    {1000 * timing.latency:.1f} ms in addition to the transmission; a round takes "
            f"{1000 * timing.round_time:.0f} ms: at most {1 / timing.round_time:.1f} rounds a second"
            f"{'' if timing.pipelined else ', because the robot answers only one request at a time'}"
        )
        print(f"line       {counts.sent} requests, {counts.timeouts} unanswered, {counts.garbled} garbled")
    return 0


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


def _sensors(arguments: argparse.Namespace) -> int:
    """Print the readings of every round: as bars that are redrawn in a terminal, otherwise as one line."""
    live = sys.stdout.isatty()
    with open_robot(arguments) as robot:
        if not live:
            print("L90 L45 L10 R10 R45 R90 backR backL | left right pulses | arm jaw present")
        shown = 0
        due = time.monotonic()
        while not arguments.rounds or shown < arguments.rounds:
            robot.receive()
            text = bars(robot.sense()) if live else line(robot.sense())
            if live and shown:
                print(_CURSOR_UP.format(text.count("\n") + 1), end="")
            print(text, flush=True)
            shown += 1
            due = max(due + CONTROL_PERIOD, time.monotonic())
            time.sleep(max(0.0, due - time.monotonic()))
    return 0


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


def line(senses: Senses) -> str:
    """All readings in one line."""
    proximity = " ".join(f"{reading:4d}" for reading in senses.proximity)
    return (
        f"{proximity} | {senses.left_pulses} {senses.right_pulses} | "
        f"{senses.arm} {senses.jaw} {senses.object_presence}"
    )


def _drive(arguments: argparse.Namespace) -> int:
    """Turn the wheels, stop them, and print how far they turned; the gripper does not move."""
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
        scale = robot.model.scale
    left, right = after.left_pulses - before.left_pulses, after.right_pulses - before.right_pulses
    if restarts:
        print(f"the robot restarted {restarts} time{'s' * (restarts > 1)}: check its power supply")
    left_mm, right_mm = (pulses * PULSE * scale for pulses in (left, right))
    print(f"left {left} pulses, {left_mm:.0f} mm; right {right} pulses, {right_mm:.0f} mm")
    return 0


def _grip(arguments: argparse.Namespace) -> int:
    """Move the arm or the jaw, wait until it stands still, and print its position."""
    model = MODELS[arguments.robot]
    if not model.has_gripper:
        raise ValueError(f"--robot {model.name} has no gripper; allowed: {KHEPERA.name}")
    with open_serial_robot(arguments) as robot:
        command, value = _GRIPPER_COMMANDS[arguments.action]
        robot.request(command, value)
        is_arm = command == "T,1,E"
        position = wait_for_rest(robot, is_arm)
        (barrier,) = robot.request("T,1,G")
        print(f"{'arm' if is_arm else 'jaw'} at {position}, barrier {barrier}")
    return 0


_UNIT = f"in speed units of {SPEED_UNIT:g} mm/s, -{MAX_SPEED}..{MAX_SPEED}"
COMMAND = Command(
    "robot",
    "test a real robot, or start a virtual one",
    commands=(
        Command("probe", "print the robot's versions, sensor readings and response times", _probe, PORT),
        Command(
            "sensors",
            "show the sensor readings as they change",
            _sensors,
            [
                *PORT,
                option(
                    "--rounds",
                    type=whole_number(0),
                    default=0,
                    help="number of rounds of 0.1 s; 0 runs until Ctrl-C (0)",
                ),
            ],
        ),
        Command(
            "drive",
            "turn the wheels for some seconds, then stop",
            _drive,
            [
                *PORT,
                *(
                    option(
                        f"--{side}",
                        type=whole_number(-MAX_SPEED, MAX_SPEED),
                        default=3,
                        help=f"{side} wheel, {_UNIT} (3)",
                    )
                    for side in ("left", "right")
                ),
                option(
                    "--seconds",
                    type=real_number(0.0, _MAX_SECONDS, "seconds"),
                    default=2.0,
                    help=f"duration, at most {_MAX_SECONDS:g} (2)",
                ),
            ],
        ),
        Command(
            "grip",
            "open, close, raise or lower the gripper",
            _grip,
            [*PORT, option("action", choices=tuple(_GRIPPER_COMMANDS), help="the movement")],
        ),
        selftest.COMMAND,
        virtual.COMMAND,
    ),
)
