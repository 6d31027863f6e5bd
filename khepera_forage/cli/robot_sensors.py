"""`khepera-forage robot sensors`: the infra-reds as bars in the terminal, and what else a step senses."""

import argparse
import sys
import time

from khepera_forage.robots.khepera import CONTROL_PERIOD, Senses
from khepera_forage.robots.proximity import MAX_READING
from khepera_forage.robots.serial.serial_khepera import SerialKhepera

_NAMES = ("left 90", "left 45", "left 10", "right 10", "right 45", "right 90", "back right", "back left")
_WIDTH = 50
_UP, _CLEAR = "\x1b[{}A", "\x1b[K"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The command's arguments."""
    parser.add_argument(
        "--rounds", type=int, default=0, help="end after so many rounds of 0.1 s; 0 goes on until Ctrl-C (0)"
    )


def run(arguments: argparse.Namespace) -> int:
    """Show them: bars that are drawn anew in a terminal, otherwise a line a round.

    Raises:
        ValueError: A negative number of rounds.
        OSError: The port cannot be opened, or the robot is lost.
    """
    if arguments.rounds < 0:
        raise ValueError(f"--rounds is {arguments.rounds}; allowed: 0 or more")
    live = sys.stdout.isatty()
    with SerialKhepera(arguments.port, baud=arguments.baud) as robot:
        if not live:
            print("L90 L45 L10 R10 R45 R90 backR backL | left right pulses | arm jaw present")
        shown = 0
        beat = time.monotonic()
        while not arguments.rounds or shown < arguments.rounds:
            robot.receive()
            text = picture(robot.sense()) if live else line(robot.sense())
            if live and shown:
                print(_UP.format(text.count("\n") + 1), end="")
            print(text, flush=True)
            shown += 1
            beat = max(beat + CONTROL_PERIOD, time.monotonic())
            time.sleep(beat - time.monotonic() if beat > time.monotonic() else 0.0)
    return 0


def picture(senses: Senses) -> str:
    """A bar for each infra-red, and the other senses below; lines clear what stood there before."""
    lines = []
    for name, reading in zip(_NAMES, senses.proximity, strict=True):
        bar = "█" * round(_WIDTH * reading / MAX_READING)
        lines.append(f"{name:>10} {reading:5d} {bar:<{_WIDTH}}")
    lines.append(
        f"{'arm':>10} {senses.arm:5d}   jaw {senses.jaw}   {'object' if senses.object_presence else 'nothing'} between "
        f"the fingers   wheels {senses.left_pulses} {senses.right_pulses}"
    )
    return "\n".join(f"{text}{_CLEAR}" for text in lines)


def line(senses: Senses) -> str:
    """The same numbers in one line."""
    proximity = " ".join(f"{reading:4d}" for reading in senses.proximity)
    return (
        f"{proximity} | {senses.left_pulses} {senses.right_pulses} | "
        f"{senses.arm} {senses.jaw} {senses.object_presence}"
    )
