"""The options of a robot's port, and the robot at it."""

import argparse
import math
import time

from khepera_forage.cli.options import option
from khepera_forage.option_values import real_number
from khepera_forage.robots.drivers import open_robot as open_any
from khepera_forage.robots.khepera import CONTROL_PERIOD
from khepera_forage.robots.model import E_PUCK, KHEPERA, MODELS
from khepera_forage.robots.real_robot import RealRobot
from khepera_forage.robots.serial.khepera_protocol import BAUD_RATES
from khepera_forage.robots.serial.line import DEFAULT_TIMEOUT, MAX_TIMEOUT
from khepera_forage.robots.serial.serial_robot import SerialRobot

_REST_TIMEOUT = 4.0
"""Seconds to wait for the gripper: an arm needs 1 s and a jaw 0.6 s (KNET); the rest is margin."""
_REST_READINGS = 3
"""Equal readings in a row, 0.1 s apart, that count as standing still."""
PORT = (
    option("--robot", choices=tuple(MODELS), default=KHEPERA.name, help=f"kind of robot ({KHEPERA.name})"),
    option(
        "--port",
        required=True,
        help="the robot's port: /dev/ttyUSB0, socket://host:port or rfc2217://host:port; or the name of a "
        "toio cube, such as toio-A1b",
    ),
    option(
        "--baud",
        type=int,
        help=f"as set by a Khepera's mode switch: {', '.join(map(str, BAUD_RATES))} (38400; of an e-puck2 115200)",
    ),
    option(
        "--timeout",
        type=real_number(0.0, MAX_TIMEOUT, "seconds"),
        default=DEFAULT_TIMEOUT,
        metavar="SECONDS",
        help=f"that a reply may take in addition to the transmission time of its bytes ({DEFAULT_TIMEOUT})",
    ),
    option(
        "--no-watchdog",
        dest="watchdog",
        action="store_false",
        help="start no process that stops the robot if this program is killed",
    ),
)


def open_robot(arguments: argparse.Namespace) -> RealRobot:
    """The driver of the robot at the port, on a line with any latency: these commands have no rounds to keep."""
    return open_any(
        arguments.robot,
        arguments.port,
        baud=arguments.baud,
        timeout=arguments.timeout,
        watchdog=arguments.watchdog,
        period=None,
    )


def open_serial_robot(arguments: argparse.Namespace) -> SerialRobot:
    """As `open_robot`, for a robot with a serial line."""
    if arguments.robot not in (KHEPERA.name, E_PUCK.name):
        raise ValueError(
            f"--robot {arguments.robot}; allowed: {KHEPERA.name}, {E_PUCK.name}, which have a serial line"
        )
    robot = open_robot(arguments)
    assert isinstance(robot, SerialRobot)
    return robot


def wait_for_rest(robot: SerialRobot, is_arm: bool) -> int:
    """Wait until the arm or the jaw stands still, at most 4 s; returns its position."""
    end = time.monotonic() + _REST_TIMEOUT
    last, equal = math.nan, 0
    while True:
        time.sleep(CONTROL_PERIOD)
        (position,) = robot.request("T,1,H", int(is_arm))
        equal = equal + 1 if position == last else 0
        last = position = int(position)
        if equal >= _REST_READINGS or time.monotonic() > end:
            return position
