"""`khepera-forage robot probe`: who is there, what it senses, and how fast it answers."""

import argparse
import statistics
import time

from khepera_forage.robots.serial.line_events import Refused
from khepera_forage.robots.serial.serial_khepera import SerialKhepera

_TRIPS = 10
_QUESTIONS = (("B", ()), ("N", ()), ("H", ()), ("T,1,G", ()), ("T,1,H", (1,)))


def run(arguments: argparse.Namespace) -> int:
    """Ask, and print the answers; nothing moves, and wheels that turn are stopped.

    Raises:
        OSError: The port cannot be opened, or nobody answers.
    """
    with SerialKhepera(arguments.port, baud=arguments.baud) as robot:
        print(f"port       {robot.port}, {robot.baud} baud")
        bios, protocol = robot.ask("B")
        print(f"robot      BIOS {bios}, protocol {protocol}")
        print(f"gripper    {_gripper(robot)}")
        print(
            f"proximity  {_numbers(robot.ask('N'))}   (left 90, 45, 10, right 10, 45, 90, back right, left)"
        )
        print(f"light      {_numbers(robot.ask('O'))}   (about 500 is dark)")
        print(f"counters   {_numbers(robot.ask('H'))}   (left, right; 0.08 mm each)")
        for command, values in _QUESTIONS:
            try:
                print(f"{_name(command, values):10s} {_round_trips(robot, command, values)}")
            except Refused:
                continue
        counts = robot.counts
        print(f"line       {counts.sent} requests, {counts.unanswered} unanswered, {counts.garbled} garbled")
    return 0


def _gripper(robot: SerialKhepera) -> str:
    """The gripper's version and state, or why there is none."""
    try:
        version, revision = robot.ask("T,1,B")
        (jumpers,) = robot.ask("T,1,J")
        (arm,) = robot.ask("T,1,H", 1)
        (barrier,) = robot.ask("T,1,G")
        (jaw,) = robot.ask("T,1,H", 0)
    except Refused as error:
        return f"none: {error.reason}"
    return (
        f"version {version}.{revision}, jumpers {jumpers}; arm {arm} (255 down), jaw {jaw} (200 open), "
        f"barrier {barrier} (above 100: an object)"
    )


def _round_trips(robot: SerialKhepera, command: str, values: tuple[int, ...]) -> str:
    """How long answers take, nothing else being on the line."""
    taken = []
    for _ in range(_TRIPS):
        # Something else in between, or the driver itself asks something else first.
        robot.ask("E")
        begin = time.perf_counter()
        robot.ask(command, *values)
        taken.append(1000 * (time.perf_counter() - begin))
    return f"{statistics.median(taken):.1f} ms round trip [{min(taken):.1f}, {max(taken):.1f}]"


def _name(command: str, values: tuple[int, ...]) -> str:
    return ",".join((command, *map(str, values)))


def _numbers(values: tuple[int | str, ...]) -> str:
    return " ".join(f"{value:>4}" for value in values)
