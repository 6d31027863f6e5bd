"""`khepera-forage robot selftest`: test every part of a robot with small movements."""

import argparse
import math
import statistics
import time
from collections.abc import Callable
from typing import Any

from khepera_forage.cli.options import Command
from khepera_forage.cli.robot_port import PORT, open_robot, wait_for_rest
from khepera_forage.robots.epuck.driver import INFRA_RED
from khepera_forage.robots.khepera import (
    ARM_DOWN,
    ARM_RAISED,
    CONTROL_PERIOD,
    JAW_CLOSED,
    JAW_OPEN,
    PULSE,
    SPEED_UNIT,
    Motors,
)
from khepera_forage.robots.model import E_PUCK, KHEPERA, TOIO
from khepera_forage.robots.proximity import MAX_READING
from khepera_forage.robots.real_robot import RealRobot
from khepera_forage.robots.serial.line import RequestRejected
from khepera_forage.robots.serial.serial_robot import SerialRobot
from khepera_forage.robots.toio.driver import ToioRobot

_SPEED, _SECONDS = 6, 0.3
"""Speed in units and duration of the wheel test: 14 mm each way, within the 0.3 s of a cube's command."""
_LOWERED = ARM_DOWN - 15
"""Arm position near the floor, above any object that may lie there."""
_ARM_TOLERANCE, _JAW_TOLERANCE = 8, 24
"""Largest deviation of a position that passes."""
_ROUNDS = 10


class CheckError(Exception):
    """A check failed; the message says what was measured."""


def _run(arguments: argparse.Namespace) -> int:
    """Test every part in turn, and print a line for each; 1 if one failed."""
    failed, checks = 0, CHECKS[arguments.robot]
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


def _lamps(robot: SerialRobot) -> str:
    lamps = (0, 1) if robot.model is KHEPERA else range(8)
    for lamp in lamps:
        for action in (1, 0):
            robot.request("L", lamp, action)
            time.sleep(CONTROL_PERIOD)
    return f"all {len(lamps)} were switched on and off; check that you saw them"


def _mat(robot: ToioRobot) -> str:
    robot.receive()
    if not robot.on_mat:
        raise CheckError(
            "it does not see the mat: put it on the simple mat, and check that its sensor is clean"
        )
    x, y, heading = robot.pose
    return f"at x {x:.0f} mm, y {y:.0f} mm of the plan, heading {math.degrees(heading):.0f} degrees"


def _infra_reds(robot: SerialRobot) -> str:
    rounds = [_readings(robot, "N") for _ in range(5)]
    highest = MAX_READING if robot.model is KHEPERA else INFRA_RED.high
    if any(set(readings) == {highest} for readings in rounds):
        raise CheckError(f"all eight read {rounds[0][0]}")
    medians = [int(statistics.median(column)) for column in zip(*rounds, strict=True)]
    return f"proximity {' '.join(map(str, medians))}"


def _light(robot: SerialRobot) -> str:
    light = _readings(robot, "O")
    if max(light) == 0:
        raise CheckError("all eight read 0, the value of the brightest light")
    return f"{min(light)}..{max(light)} (about 500 is dark)"


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

    The range is wide because a low supply voltage slows the motors, and a cube has few speeds. A wheel that turns the
    wrong way fails.
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
    positions = []
    for target in (ARM_RAISED, _LOWERED, ARM_RAISED):
        robot.request("T,1,E", target)
        positions.append(wait_for_rest(robot, True))
        if abs(positions[-1] - target) > _ARM_TOLERANCE:
            raise CheckError(f"sent to {target}, it stopped at {positions[-1]}")
    return f"at {', '.join(map(str, positions))}"


def _jaw(robot: SerialRobot) -> str:
    positions = []
    for closed, target in ((1, JAW_CLOSED), (0, JAW_OPEN)):
        robot.request("T,1,D", closed)
        positions.append(wait_for_rest(robot, False))
        if abs(positions[-1] - target) > _JAW_TOLERANCE:
            raise CheckError(
                f"{'closed' if closed else 'opened'}, it stopped at {positions[-1]}; expected: about {target}"
            )
    return f"closed at {positions[0]}, open at {positions[1]}"


def _barrier(robot: SerialRobot) -> str:
    (barrier,) = robot.request("T,1,G")
    if int(barrier) > 100:
        raise CheckError(f"{barrier} with nothing between the fingers")
    return f"{barrier} with nothing between the fingers"


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


def _readings(robot: SerialRobot, command: str) -> list[int]:
    return [int(value) for value in robot.request(command)]


_SERIAL: dict[str, Callable[[Any], str]] = {
    "infra-reds": _infra_reds,
    "ambient light": _light,
    "wheels": _wheels,
    "a round": _rounds,
    "line": _line,
}
CHECKS: dict[str, dict[str, Callable[[Any], str]]] = {
    KHEPERA.name: {
        "versions": _versions,
        "lamps": _lamps,
        "arm": _arm,
        "jaw": _jaw,
        "optical barrier": _barrier,
        **_SERIAL,
    },
    E_PUCK.name: {"version": _versions, "lamps": _lamps, **_SERIAL},
    TOIO.name: {"mat": _mat, "wheels": _wheels, "a round": _rounds},
}
"""By the kind of robot and the part; each returns what it measured, or raises `CheckError`.

The arm comes before the infra-reds: raised, it does not cover them.
"""
COMMAND = Command("selftest", "test every part with small movements, and print which ones work", _run, PORT)
