"""`khepera-forage robot sensors`: live sensor readings, the infra-reds as bars in a terminal."""

import argparse
import sys
import time

from khepera_forage.cli.robot.port import add_port_arguments, open_robot
from khepera_forage.option_values import whole_number
from khepera_forage.robots.khepera import CONTROL_PERIOD, Senses
from khepera_forage.robots.proximity import MAX_READING

_NAMES = ("left 90", "left 45", "left 10", "right 10", "right 45", "right 90", "back right", "back left")
_BAR_WIDTH = 50
_CURSOR_UP, _CLEAR_LINE = "\x1b[{}A", "\x1b[K"
"""Terminal escape sequences."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the command's arguments."""
    add_port_arguments(parser)
    parser.add_argument(
        "--rounds", type=whole_number(0), default=0, help="number of rounds of 0.1 s; 0 runs until Ctrl-C (0)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Print the readings of every round: as bars that are redrawn in a terminal, otherwise as one line.

    Raises:
        OSError: The port cannot be opened, or the robot is lost.
    """
    live = sys.stdout.isatty()
    with open_robot(arguments) as robot:
        if not live:
            print("L90 L45 L10 R10 R45 R90 backR backL | left right pulses | arm jaw present")
        shown = 0
        due = time.monotonic()
        while not arguments.rounds or shown < arguments.rounds:
            robot.receive()
            text = bars(robot.sense()) if live else line(robot.sense())
            if live and shown:
                print(_CURSOR_UP.format(text.count("\n") + 1), end="")
            print(text, flush=True)
            shown += 1
            due = max(due + CONTROL_PERIOD, time.monotonic())
            time.sleep(max(0.0, due - time.monotonic()))
    return 0


def bars(senses: Senses) -> str:
    """One bar for each infra-red sensor, and the other readings below; each line clears its predecessor."""
    lines = []
    for name, reading in zip(_NAMES, senses.proximity, strict=True):
        bar = "█" * round(_BAR_WIDTH * reading / MAX_READING)
        lines.append(f"{name:>10} {reading:5d} {bar:<{_BAR_WIDTH}}")
    lines.append(
        f"{'arm':>10} {senses.arm:5d}   jaw {senses.jaw}   {'object' if senses.object_presence else 'nothing'} between "
        f"the fingers   wheels {senses.left_pulses} {senses.right_pulses}"
    )
    return "\n".join(f"{text}{_CLEAR_LINE}" for text in lines)


def line(senses: Senses) -> str:
    """All readings in one line."""
    proximity = " ".join(f"{reading:4d}" for reading in senses.proximity)
    return (
        f"{proximity} | {senses.left_pulses} {senses.right_pulses} | "
        f"{senses.arm} {senses.jaw} {senses.object_presence}"
    )
