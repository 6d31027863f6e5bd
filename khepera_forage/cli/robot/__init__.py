"""`khepera-forage robot`: test a real Khepera, or start a virtual one."""

import argparse

from khepera_forage.cli.robot import move, probe, selftest, sensors, virtual
from khepera_forage.cli.subcommands import Subcommand, add_subcommands

SUBCOMMANDS = (
    Subcommand(
        "probe",
        "print the robot's versions, sensor readings and response times",
        probe.add_arguments,
        probe.run,
    ),
    Subcommand("sensors", "show the sensor readings as they change", sensors.add_arguments, sensors.run),
    Subcommand("drive", "turn the wheels for some seconds, then stop", move.add_drive_arguments, move.drive),
    Subcommand("grip", "open, close, raise or lower the gripper", move.add_grip_arguments, move.grip),
    Subcommand(
        "selftest",
        "test every part with small movements, and print which ones work",
        selftest.add_arguments,
        selftest.run,
    ),
    Subcommand("virtual", "start a virtual Khepera at a serial port", virtual.add_arguments, virtual.run),
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the subcommands."""
    add_subcommands(parser, "task", SUBCOMMANDS)
