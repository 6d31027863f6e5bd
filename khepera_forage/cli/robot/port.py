"""The arguments of a robot's port."""

import argparse

from khepera_forage.option_values import real_number
from khepera_forage.robots.drivers import open_robot as open_any
from khepera_forage.robots.model import E_PUCK, KHEPERA, MODELS, RobotModel
from khepera_forage.robots.real_robot import RealRobot
from khepera_forage.robots.serial.khepera_protocol import BAUD_RATES
from khepera_forage.robots.serial.line import DEFAULT_TIMEOUT, MAX_TIMEOUT
from khepera_forage.robots.serial.serial_robot import SerialRobot


def add_robot_argument(parser: argparse.ArgumentParser) -> None:
    """Add `--robot`."""
    parser.add_argument(
        "--robot", choices=tuple(MODELS), default=KHEPERA.name, help=f"kind of robot ({KHEPERA.name})"
    )


def add_port_arguments(parser: argparse.ArgumentParser) -> None:
    """Add `--robot`, `--port`, `--baud`, `--timeout` and `--no-watchdog`."""
    add_robot_argument(parser)
    parser.add_argument(
        "--port",
        required=True,
        help="the robot's port: /dev/ttyUSB0, socket://host:port or rfc2217://host:port; or the name of a "
        "toio cube, such as toio-A1b",
    )
    bauds = ", ".join(map(str, BAUD_RATES))
    parser.add_argument(
        "--baud", type=int, help=f"as set by a Khepera's mode switch: {bauds} (38400; of an e-puck2 115200)"
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


def open_robot(arguments: argparse.Namespace) -> RealRobot:
    """The driver of the robot at the port, on a line with any latency: these commands have no rounds to keep.

    Raises:
        ValueError: A baud rate or a time-out that is not allowed.
        ConnectionError: The port cannot be opened; as `RobotLost`, that no robot replies.
    """
    return open_any(
        arguments.robot,
        arguments.port,
        baud=arguments.baud,
        timeout=arguments.timeout,
        watchdog=arguments.watchdog,
        period=None,
    )


def open_serial_robot(arguments: argparse.Namespace) -> SerialRobot:
    """As `open_robot`, for a robot with a serial line.

    Raises:
        ValueError: Another robot.
    """
    if arguments.robot not in (KHEPERA.name, E_PUCK.name):
        raise ValueError(
            f"--robot {arguments.robot}; allowed: {KHEPERA.name}, {E_PUCK.name}, which have a serial line"
        )
    robot = open_robot(arguments)
    assert isinstance(robot, SerialRobot)
    return robot


def require_gripper(model: RobotModel) -> None:
    """Refuse a robot without a gripper.

    Raises:
        ValueError: It has none.
    """
    if not model.has_gripper:
        raise ValueError(f"--robot {model.name} has no gripper; allowed: {KHEPERA.name}")
