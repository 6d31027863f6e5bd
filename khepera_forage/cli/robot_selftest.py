"""`khepera-forage robot selftest`: every part is tried, little is moved, and a table says what works."""

import argparse
import statistics
import time
from collections.abc import Callable
from typing import NamedTuple

from khepera_forage.cli.robot_move import counters, rest
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
from khepera_forage.robots.proximity import MAX_READING
from khepera_forage.robots.serial.line_events import Refused
from khepera_forage.robots.serial.serial_khepera import SerialKhepera

_SPEED, _SECONDS = 4, 0.5
"""Wheels: 16 mm each way."""
_LOWERED = ARM_DOWN - 15
"""The arm is lowered nearly to the floor, and not onto what may lie there."""
_NEAR_ENOUGH = 8
_ROUNDS = 10


class Failed(Exception):  # noqa: N818 (what a check says, not a mistake)
    """A check that did not come out well, and what was seen."""


class Check(NamedTuple):
    """A part and how it is tried; the function returns what was seen, or raises `Failed`."""

    name: str
    run: Callable[[SerialKhepera], str]


def run(arguments: argparse.Namespace) -> int:
    """Try everything, in turn, and print a line for each part.

    Returns:
        0 if all passed, otherwise 1.

    Raises:
        OSError: The port cannot be opened, or the robot is lost meanwhile.
    """
    failed = 0
    with SerialKhepera(arguments.port, baud=arguments.baud) as robot:
        print("Keep 30 mm free around the robot: wheels, arm and jaw will move a little.", flush=True)
        for check in CHECKS:
            try:
                word, seen = "pass", check.run(robot)
            except Failed as failure:
                word, seen = "FAIL", str(failure)
            except Refused as refusal:
                word, seen = "FAIL", f"{refusal.command}: {refusal.reason}"
            failed += word == "FAIL"
            print(f"{check.name:18s} {word}   {seen}", flush=True)
    print(f"{len(CHECKS) - failed} of {len(CHECKS)} passed")
    return 1 if failed else 0


def _versions(robot: SerialKhepera) -> str:
    bios, protocol = robot.ask("B")
    return f"BIOS {bios}, protocol {protocol}"


def _lamps(robot: SerialKhepera) -> str:
    for lamp in (0, 1):
        for action in (1, 0):
            robot.ask("L", lamp, action)
            time.sleep(CONTROL_PERIOD)
    return "both were on and off: you saw them or not"


def _infra_reds(robot: SerialKhepera) -> str:
    near = [_readings(robot, "N") for _ in range(5)]
    if any(len(set(readings)) == 1 and readings[0] == MAX_READING for readings in near):
        raise Failed(f"all eight read {near[0][0]}")
    medians = [int(statistics.median(column)) for column in zip(*near, strict=True)]
    return f"proximity {' '.join(map(str, medians))}"


def _light(robot: SerialKhepera) -> str:
    light = _readings(robot, "O")
    if max(light) == 0:
        raise Failed("all eight read 0, brighter than the sun")
    return f"{min(light)}..{max(light)} (about 500 is dark)"


def _wheels(robot: SerialKhepera) -> str:
    start = counters(robot)
    forth = _travel(robot, _SPEED)
    back = _travel(robot, -_SPEED)
    off = [b - a for a, b in zip(start, counters(robot), strict=True)]
    if max(map(abs, off)) > 0.3 * _SPEED * SPEED_UNIT / PULSE * _SECONDS:
        raise Failed(f"forth {forth} and back {back} ends {off} pulses from where it began")
    return f"forth {forth}, back {back} pulses, {off} from where they began"


def _travel(robot: SerialKhepera, speed: int) -> list[int]:
    """Turn both wheels: within half of what they were told, since the supply may be low, but no sign may be wrong."""
    before = counters(robot)
    begin = time.monotonic()
    robot.ask("D", speed, speed)
    time.sleep(_SECONDS)
    robot.stop()
    expected = speed * SPEED_UNIT / PULSE * (time.monotonic() - begin)
    time.sleep(2 * CONTROL_PERIOD)
    gone = [after - b for after, b in zip(counters(robot), before, strict=True)]
    if any(not 0.5 < pulses / expected < 1.5 for pulses in gone):
        raise Failed(f"{gone} pulses at speed {speed}; expected: about {expected:.0f}")
    return gone


def _arm(robot: SerialKhepera) -> str:
    seen = []
    for target in (ARM_RAISED, _LOWERED, ARM_RAISED):
        robot.ask("T,1,E", target)
        seen.append(rest(robot, True))
        if abs(seen[-1] - target) > _NEAR_ENOUGH:
            raise Failed(f"sent to {target}, it rests at {seen[-1]}")
    return f"at {', '.join(map(str, seen))}"


def _jaw(robot: SerialKhepera) -> str:
    seen = []
    for closed, target in ((1, JAW_CLOSED), (0, JAW_OPEN)):
        robot.ask("T,1,D", closed)
        seen.append(rest(robot, False))
        if abs(seen[-1] - target) > 3 * _NEAR_ENOUGH:
            raise Failed(
                f"{'closed' if closed else 'opened'}, it rests at {seen[-1]}; expected: about {target}"
            )
    return f"closed at {seen[0]}, open at {seen[1]}"


def _barrier(robot: SerialKhepera) -> str:
    (barrier,) = robot.ask("T,1,G")
    if int(barrier) > 100:
        raise Failed(f"{barrier} with nothing between the fingers")
    return f"{barrier} with nothing between the fingers"


def _rounds(robot: SerialKhepera) -> str:
    taken = []
    for _ in range(_ROUNDS):
        begin = time.monotonic()
        robot.drive(Motors(0, 0, ARM_RAISED, JAW_OPEN))
        robot.transmit()
        robot.receive()
        taken.append(1000 * (time.monotonic() - begin))
    limit = 1000 * CONTROL_PERIOD
    said = f"{statistics.median(taken):.0f} ms, the longest {max(taken):.0f}; allowed: {limit:.0f}"
    if statistics.median(taken) > limit:
        raise Failed(said)
    return said


def _line(robot: SerialKhepera) -> str:
    counts = robot.counts
    troubles = counts.unanswered + counts.garbled + counts.refused + counts.restarts
    if troubles:
        raise Failed(f"{counts}")
    return f"{counts.sent} requests, all answered"


def _readings(robot: SerialKhepera, command: str) -> list[int]:
    return [int(value) for value in robot.ask(command)]


CHECKS = (
    Check("versions", _versions),
    Check("lamps", _lamps),
    Check("arm", _arm),
    Check("jaw", _jaw),
    Check("optical barrier", _barrier),
    Check("infra-reds", _infra_reds),
    Check("ambient light", _light),
    Check("wheels", _wheels),
    Check("a round", _rounds),
    Check("line", _line),
)
"""In this order: a raised arm leaves the infra-reds free."""
