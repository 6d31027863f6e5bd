"""A driver in a process of its own, which a test ends in every way."""

import subprocess
import sys
import textwrap
import time
from collections.abc import Callable, Sequence

_PATIENCE = 20.0
"""Seconds after which an expected event counts as missing: a busy machine takes long."""

KHEPERA_DRIVER = "serial.serial_khepera.SerialKhepera"
DRIVE = """
import os, select, signal, sys, time
from khepera_forage.robots.khepera import Motors
from khepera_forage.robots.real_robot import Fleet
from khepera_forage.robots.{module} import {driver}
robots = [{driver}(port, {options}) for port in sys.argv[1:]]
def drive():
    for robot in robots:
        robot.drive(Motors(5, 5, 215, 200))
        robot.transmit()
    print("driving", flush=True)
def drive_until_told():
    drive()
    fleet = Fleet(robots)
    while not select.select([sys.stdin], [], [], 0)[0]:
        fleet.transmit()
        fleet.receive()
    sys.stdin.readline()
"""


def start_driver(
    ports: Sequence[str], body: str, *, before: str = "", options: str = "", driver: str = KHEPERA_DRIVER
) -> "subprocess.Popen[str]":
    """Start a process that drives robots, and wait until they drive.

    Args:
        ports: Of the robots.
        body: Program after the definitions above; calls `drive()` or `drive_until_told()`.
        before: Program before them.
        options: Further arguments of the driver.
        driver: Its module and class.
    """
    module, _, name = driver.rpartition(".")
    definitions = DRIVE.format(options=options, module=module, driver=name)
    program = "\n".join((before, definitions, textwrap.dedent(body)))
    child = subprocess.Popen(
        [sys.executable, "-W", "error", "-c", program, *ports],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # A group of its own, as a shell starts it: only such a process can be suspended.
        process_group=0,
    )
    assert child.stdout is not None
    assert child.stdout.readline() == "driving\n", child.communicate()[1]
    return child


def tell(child: "subprocess.Popen[str]") -> None:
    """Send a line to a process."""
    assert child.stdin is not None
    child.stdin.write("\n")
    child.stdin.flush()


def answer(child: "subprocess.Popen[str]") -> str:
    """The next line of a process."""
    assert child.stdout is not None
    return child.stdout.readline()


def wait_for(condition: Callable[[], bool]) -> None:
    """Wait until something happens."""
    end = time.monotonic() + _PATIENCE
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.005)


def wait_for_exit(child: "subprocess.Popen[str]") -> tuple[int, str]:
    """The exit status and the errors that a process has printed."""
    _, errors = child.communicate(timeout=20)
    return child.returncode, errors
