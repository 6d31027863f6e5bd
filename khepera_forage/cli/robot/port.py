"""The arguments of a robot's serial port."""

import argparse

from khepera_forage.option_values import real_number
from khepera_forage.robots.serial.khepera_protocol import BAUD_RATES
from khepera_forage.robots.serial.line import DEFAULT_TIMEOUT, MAX_TIMEOUT
from khepera_forage.robots.serial.serial_khepera import SerialKhepera


def add_port_arguments(parser: argparse.ArgumentParser) -> None:
    """Add `--port`, `--baud`, `--timeout` and `--no-watchdog`."""
    parser.add_argument(
        "--port",
        required=True,
        help="the robot's port: a device such as /dev/ttyUSB0, socket://host:port or rfc2217://host:port",
    )
    bauds = ", ".join(map(str, BAUD_RATES))
    parser.add_argument(
        "--baud",
        type=int,
        default=SerialKhepera.default_baud,
        help=f"as set by the robot's mode switch: {bauds} ({SerialKhepera.default_baud})",
    )
    parser.add_argument(
        "--timeout",
        type=real_number(0.0, MAX_TIMEOUT, "seconds"),
        default=DEFAULT_TIMEOUT,
        metavar="SECONDS",
        help=f"that a reply may take in addition to the transmission time of its bytes ({DEFAULT_TIMEOUT})",
    )
    parser.add_argument(
        "--no-watchdog",
        dest="watchdog",
        action="store_false",
        help="start no process that stops the robot if this program is killed",
    )


def open_robot(arguments: argparse.Namespace) -> SerialKhepera:
    """The driver of the robot at the port, on a line with any latency: these commands have no rounds to keep.

    Raises:
        ValueError: A baud rate or a time-out that is not allowed.
        ConnectionError: The port cannot be opened; as `RobotLost`, that no robot replies.
    """
    return SerialKhepera(
        arguments.port,
        baud=arguments.baud,
        timeout=arguments.timeout,
        watchdog=arguments.watchdog,
        period=None,
    )
