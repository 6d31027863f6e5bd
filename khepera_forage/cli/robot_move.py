"""`khepera-forage robot drive` and `grip`: move one thing, for a bounded time."""

import argparse
import math
import time

from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, CONTROL_PERIOD, MAX_SPEED, PULSE, SPEED_UNIT
from khepera_forage.robots.serial.serial_khepera import SerialKhepera

_LONGEST = 60.0
"""Seconds that one command may drive: nobody watches a robot for longer."""
_ARRIVES = 4.0
"""Seconds that arm or jaw are given: one for an arm, 0.6 for a jaw (KNET), and some to spare."""
_RESTS = 3
"""Equal readings in a row, 0.1 s apart, after which they are at rest."""
_GRIPS = {
    "open": ("T,1,D", 0),
    "close": ("T,1,D", 1),
    "raise": ("T,1,E", ARM_RAISED),
    "lower": ("T,1,E", ARM_DOWN),
}


def add_drive_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of `drive`."""
    unit = f"in speed units of {SPEED_UNIT:g} mm/s, -{MAX_SPEED}..{MAX_SPEED}"
    parser.add_argument("--left", type=int, default=3, help=f"left wheel, {unit} (3)")
    parser.add_argument("--right", type=int, default=3, help=f"right wheel, {unit} (3)")
    parser.add_argument("--seconds", type=float, default=2.0, help=f"for how long, at most {_LONGEST:g} (2)")


def drive(arguments: argparse.Namespace) -> int:
    """Turn the wheels, stop them, and say how far they went; the gripper is left as it is.

    Raises:
        ValueError: A speed or a time out of range.
        OSError: The port cannot be opened, or the robot is lost.
    """
    for name in ("left", "right"):
        if not -MAX_SPEED <= getattr(arguments, name) <= MAX_SPEED:
            raise ValueError(f"--{name} is {getattr(arguments, name)}; allowed: -{MAX_SPEED}..{MAX_SPEED}")
    if not 0 < arguments.seconds <= _LONGEST:
        raise ValueError(f"--seconds is {arguments.seconds:g}; allowed: more than 0, at most {_LONGEST:g}")
    with SerialKhepera(arguments.port, baud=arguments.baud) as robot:
        left, right = counters(robot)
        robot.ask("D", arguments.left, arguments.right)
        end = time.monotonic() + arguments.seconds
        while (rest := end - time.monotonic()) > 0:
            time.sleep(min(rest, CONTROL_PERIOD))
            counters(robot)  # A robot that is lost meanwhile is noticed.
        robot.stop()
        gone = [after - before for after, before in zip(counters(robot), (left, right), strict=True)]
    print(
        f"left {gone[0]} pulses, {gone[0] * PULSE:.0f} mm; right {gone[1]} pulses, {gone[1] * PULSE:.0f} mm"
    )
    return 0


def add_grip_arguments(parser: argparse.ArgumentParser) -> None:
    """The arguments of `grip`."""
    parser.add_argument("action", choices=tuple(_GRIPS), help="what the gripper shall do")


def grip(arguments: argparse.Namespace) -> int:
    """Move arm or jaw, wait until it rests, and say where it is.

    Raises:
        OSError: The port cannot be opened, the robot is lost, or it has no gripper.
    """
    with SerialKhepera(arguments.port, baud=arguments.baud) as robot:
        command, value = _GRIPS[arguments.action]
        robot.ask(command, value)
        is_arm = command == "T,1,E"
        position = rest(robot, is_arm)
        (barrier,) = robot.ask("T,1,G")
        print(f"{'arm' if is_arm else 'jaw'} at {position}, barrier {barrier}")
    return 0


def rest(robot: SerialKhepera, is_arm: bool) -> int:
    """Wait until arm or jaw rests, or its time is over; returns where it is."""
    end = time.monotonic() + _ARRIVES
    last, equal = math.nan, 0
    while True:
        time.sleep(CONTROL_PERIOD)
        (position,) = robot.ask("T,1,H", int(is_arm))
        equal = equal + 1 if position == last else 0
        last = position = int(position)
        if equal >= _RESTS or time.monotonic() > end:
            return position


def counters(robot: SerialKhepera) -> tuple[int, int]:
    """The encoders of both wheels, in pulses."""
    left, right = robot.ask("H")
    return int(left), int(right)
