"""The arguments that name a robot's serial port."""

import argparse

from khepera_forage.robots.serial.client import DEFAULT_BAUD
from khepera_forage.robots.serial.port import BAUD_RATES


def add_port_arguments(parser: argparse.ArgumentParser) -> None:
    """Add `--port` and `--baud`."""
    parser.add_argument(
        "--port",
        required=True,
        help="the robot's port: a device such as /dev/ttyUSB0, socket://host:port or rfc2217://host:port",
    )
    bauds = ", ".join(map(str, BAUD_RATES))
    parser.add_argument(
        "--baud",
        type=int,
        default=DEFAULT_BAUD,
        help=f"as set by the robot's mode switch: {bauds} ({DEFAULT_BAUD})",
    )
