"""`khepera-forage robot probe`: a robot's versions, sensor readings and response times."""

import argparse
import statistics
import time

from khepera_forage.cli.robot.port import add_port_arguments, open_serial_robot
from khepera_forage.robots.model import E_PUCK, KHEPERA, MODELS
from khepera_forage.robots.serial.line import RequestRejected
from khepera_forage.robots.serial.serial_robot import SerialRobot

_ROUND_TRIPS = 10
"""Measurements of each response time."""
_COUNTERS = {KHEPERA.name: "H", E_PUCK.name: "Q"}
_GRIPPER: tuple[tuple[str, tuple[int, ...]], ...] = (("T,1,G", ()), ("T,1,H", (1,)))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_port_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Query the robot and print its answers; nothing moves, and turning wheels are stopped.

    Raises:
        OSError: The port cannot be opened, or no robot answers.
    """
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
        timed = [
            (identity.command, ()),
            ("N", ()),
            (_COUNTERS[model.name], ()),
            *(_GRIPPER if model.has_gripper else ()),
        ]
        for command, values in timed:
            try:
                print(f"{_name(command, values):10s} {_round_trips(robot, command, values)}")
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


def _round_trips(robot: SerialRobot, command: str, values: tuple[int, ...]) -> str:
    """Median and range of the response time of one command."""
    taken = []
    for _ in range(_ROUND_TRIPS):
        # Alternate with another command: the driver sends a query of its own before it repeats a command.
        robot.request("E")
        begin = time.perf_counter()
        robot.request(command, *values)
        taken.append(1000 * (time.perf_counter() - begin))
    return f"{statistics.median(taken):.1f} ms round trip [{min(taken):.1f}, {max(taken):.1f}]"


def _name(command: str, values: tuple[int, ...]) -> str:
    return ",".join((command, *map(str, values)))


def _numbers(values: tuple[int | str, ...]) -> str:
    return " ".join(f"{value:>4}" for value in values)
