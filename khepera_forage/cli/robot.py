"""`khepera-forage robot`: try out a real Khepera, or start a virtual one."""

import argparse

from khepera_forage.cli import (
    robot_move,
    robot_probe,
    robot_selftest,
    robot_sensors,
    robot_virtual,
)
from khepera_forage.robots.serial.port import BAUDS
from khepera_forage.robots.serial.serial_khepera import BAUD


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The subcommands and their arguments."""
    subparsers = parser.add_subparsers(dest="what", required=True, metavar="what")
    for name, adds, run, help_text in (
        ("probe", None, robot_probe.run, "say who is there, what it senses, and how fast it answers"),
        ("sensors", robot_sensors.add_arguments, robot_sensors.run, "show the infra-reds as they change"),
        ("drive", robot_move.add_drive_arguments, robot_move.drive, "turn the wheels for a while, then stop"),
        ("grip", robot_move.add_grip_arguments, robot_move.grip, "open, close, raise or lower the gripper"),
        ("selftest", None, robot_selftest.run, "try every part, moving little, and say what works"),
        ("virtual", None, robot_virtual.run, "start a virtual Khepera for any program to talk to"),
    ):
        subparser = subparsers.add_parser(
            name, help=help_text, description=f"{help_text[:1].upper()}{help_text[1:]}."
        )
        if name == "virtual":
            robot_virtual.add_arguments(subparser)
        else:
            _add_port(subparser)
        if adds is not None:
            adds(subparser)
        subparser.set_defaults(run_robot=run)


def run(arguments: argparse.Namespace) -> int:
    """Do what was asked.

    Raises:
        ValueError: An argument out of range.
        OSError: The port cannot be opened, or the robot is lost.
    """
    status: int = arguments.run_robot(arguments)
    return status


def _add_port(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--port",
        required=True,
        help="where the robot is: a device such as /dev/ttyUSB0, socket://host:port or rfc2217://host:port",
    )
    bauds = ", ".join(map(str, BAUDS))
    parser.add_argument(
        "--baud", type=int, default=BAUD, help=f"as the robot's mode switch is set: {bauds} ({BAUD})"
    )
