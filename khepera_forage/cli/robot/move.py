"""`khepera-forage robot drive` and `grip`: move the wheels or the gripper for a limited time."""

import argparse
import math
import time

from khepera_forage.cli.robot.port import add_port_arguments, open_robot, open_serial_robot, require_gripper
from khepera_forage.option_values import real_number, whole_number
from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, CONTROL_PERIOD, MAX_SPEED, PULSE, SPEED_UNIT
from khepera_forage.robots.model import MODELS
from khepera_forage.robots.serial.serial_robot import SerialRobot

_MAX_SECONDS = 60.0
"""Longest drive of one command: an operator does not watch a robot for longer."""
_REST_TIMEOUT = 4.0
"""Seconds to wait for the gripper: an arm needs 1 s and a jaw 0.6 s (KNET); the rest is margin."""
_REST_READINGS = 3
"""Equal readings in a row, 0.1 s apart, that count as standing still."""
_GRIPPER_COMMANDS = {
    "open": ("T,1,D", 0),
    "close": ("T,1,D", 1),
    "raise": ("T,1,E", ARM_RAISED),
    "lower": ("T,1,E", ARM_DOWN),
}


def add_drive_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `drive`."""
    add_port_arguments(parser)
    unit = f"in speed units of {SPEED_UNIT:g} mm/s, -{MAX_SPEED}..{MAX_SPEED}"
    speed = whole_number(-MAX_SPEED, MAX_SPEED)
    parser.add_argument("--left", type=speed, default=3, help=f"left wheel, {unit} (3)")
    parser.add_argument("--right", type=speed, default=3, help=f"right wheel, {unit} (3)")
    seconds = real_number(0.0, _MAX_SECONDS, "seconds")
    parser.add_argument(
        "--seconds", type=seconds, default=2.0, help=f"duration, at most {_MAX_SECONDS:g} (2)"
    )


def drive(arguments: argparse.Namespace) -> int:
    """Turn the wheels, stop them, and print how far they turned; the gripper does not move.

    Raises:
        OSError: The port cannot be opened, or the robot is lost.
    """
    with open_robot(arguments) as robot:
        robot.receive()
        before = robot.sense()
        end = time.monotonic() + arguments.seconds
        while (rest := end - time.monotonic()) > 0:
            # Again and again: a robot that restarts meanwhile drives on, and one that is lost raises an error.
            robot.turn_wheels(arguments.left, arguments.right)
            robot.receive()
            time.sleep(max(0.0, min(rest, CONTROL_PERIOD)))
        robot.stop()
        robot.receive()
        after = robot.sense()
        restarts = robot.statistics.restarts if isinstance(robot, SerialRobot) else 0
        scale = robot.model.scale
    left, right = after.left_pulses - before.left_pulses, after.right_pulses - before.right_pulses
    if restarts:
        print(f"the robot restarted {restarts} time{'s' * (restarts > 1)}: check its power supply")
    left_mm, right_mm = (pulses * PULSE * scale for pulses in (left, right))
    print(f"left {left} pulses, {left_mm:.0f} mm; right {right} pulses, {right_mm:.0f} mm")
    return 0


def add_grip_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of `grip`."""
    add_port_arguments(parser)
    parser.add_argument("action", choices=tuple(_GRIPPER_COMMANDS), help="the movement")


def grip(arguments: argparse.Namespace) -> int:
    """Move the arm or the jaw, wait until it stands still, and print its position.

    Raises:
        ValueError: A kind of robot without a gripper.
        OSError: The port cannot be opened, the robot is lost, or it has no gripper.
    """
    require_gripper(MODELS[arguments.robot])
    with open_serial_robot(arguments) as robot:
        command, value = _GRIPPER_COMMANDS[arguments.action]
        robot.request(command, value)
        is_arm = command == "T,1,E"
        position = wait_for_rest(robot, is_arm)
        (barrier,) = robot.request("T,1,G")
        print(f"{'arm' if is_arm else 'jaw'} at {position}, barrier {barrier}")
    return 0


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
