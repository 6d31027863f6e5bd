"""How long wheels turn after the end of the process that drives them."""

import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from khepera_forage.estimates import Column, Table, extremes, pick
from khepera_forage.robots.khepera import ARM_RAISED, JAW_OPEN, Motors, Senses, applicable
from khepera_forage.robots.virtual.firmware import Firmware
from khepera_forage.robots.virtual.virtual_khepera import VirtualKhepera
from serial_lines.latency import BAUD

ENDINGS = {
    "Ctrl-C": signal.SIGINT,
    "termination": signal.SIGTERM,
    "hang-up": signal.SIGHUP,
    "Ctrl-\\": signal.SIGQUIT,
    "Ctrl-Z": signal.SIGTSTP,
    "SIGABRT": signal.SIGABRT,
    "SIGALRM": signal.SIGALRM,
    "SIGXCPU": signal.SIGXCPU,
    "crash (SIGSEGV)": signal.SIGSEGV,
    "os._exit": None,
    "kill -9": signal.SIGKILL,
    "SIGSTOP": signal.SIGSTOP,
}
_PROGRAM = """
import os, signal, sys
# A shell starts programs in the background with some signals ignored, and their children inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)
for number in (signal.SIGQUIT, signal.SIGHUP, signal.SIGTSTP):
    signal.signal(number, signal.SIG_DFL)
from khepera_forage.robots.khepera import Motors
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
with SerialKhepera(sys.argv[1]) as robot:
    robot.drive(Motors(5, 5, 215, 200))
    robot.transmit()
    print("driving", flush=True)
    sys.stdin.readline()
    os._exit(0)
"""
_TIMEOUT = 5.0
"""Seconds after which wheels count as turning for good."""
_NOTE = (
    f"A process drives a virtual robot at {BAUD} baud, and is ended. Time from then until the robot receives the stop: "
    "median [lowest, highest]. After a crash, `os._exit`, kill -9 and SIGSTOP the watchdog stops the robot; it notices "
    "SIGSTOP by 0.5 s without a sign of life."
)


@dataclass(frozen=True, slots=True)
class End:
    """The end of a process.

    Attributes:
        ending: A key of `ENDINGS`.
        number: Of the process, from 0.
        taken: Milliseconds until the wheels were stopped.
    """

    ending: str
    number: int
    taken: float


class RecordingRobot:
    """A robot without a body, which records when its wheels were stopped."""

    has_gripper = True

    def __init__(self) -> None:
        self.motors = Motors(0, 0, ARM_RAISED, JAW_OPEN)
        self.stopped_at = 0.0

    def sense(self) -> Senses:
        """Constant senses."""
        return Senses((0,) * 8, 0, 0, ARM_RAISED, JAW_OPEN, 0)

    def drive(self, motors: Motors) -> Motors:
        """Record a command."""
        was_turning = any(self.motors[:2])
        self.motors = applicable(motors)
        if was_turning and not any(self.motors[:2]):
            self.stopped_at = time.perf_counter()
        return self.motors

    def stop(self) -> None:
        """Stop the wheels."""
        self.drive(self.motors._replace(left=0, right=0))

    def close(self) -> None:
        """Nothing to release."""


class Ending(NamedTuple):
    """Processes that end in one way.

    Attributes:
        ending: A key of `ENDINGS`.
        processes: How many.
    """

    ending: str
    processes: int

    @property
    def key(self) -> str:
        """The way."""
        return f"ending {self.ending}"

    def run(self) -> list[End]:
        """Measure every process."""
        return [End(self.ending, number, 1000 * self._measured()) for number in range(self.processes)]

    def _measured(self) -> float:
        robot = RecordingRobot()
        with (
            VirtualKhepera(Firmware(robot), baud=BAUD) as port,
            subprocess.Popen(
                [sys.executable, "-c", _PROGRAM, port.url],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                process_group=0,
            ) as process,
        ):
            assert process.stdin is not None
            assert process.stdout is not None
            process.stdout.readline()
            begin = time.perf_counter()
            number = ENDINGS[self.ending]
            if number is None:
                process.stdin.write(b"\n")
                process.stdin.flush()
            else:
                process.send_signal(number)
            while any(robot.motors[:2]) and time.perf_counter() < begin + _TIMEOUT:
                time.sleep(0.0005)
            taken = robot.stopped_at - begin if not any(robot.motors[:2]) else float("inf")
            process.kill()
        return taken


def ending_table(rows: Sequence[End]) -> Table:
    """Milliseconds by ending."""
    columns = (
        Column("end of the process"),
        Column("processes"),
        Column("wheels turn on (ms)", digits=0, estimate=True),
    )
    lines = []
    for ending in ENDINGS:
        own = pick(rows, ending=ending)
        if own:
            lines.append((ending, len(own), extremes([row.taken for row in own])))
    return Table("endings", "Ends of a process", _NOTE, columns, lines)
