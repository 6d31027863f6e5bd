"""The wheels stand after every way out of a program: a child process drives, and the parent looks at the robot."""

import os
import signal
import subprocess
import sys
import textwrap
import threading
import time
from collections.abc import Iterator
from types import FrameType
from typing import Any

import pytest

from khepera_forage.robots.serial import emergency_stop as stopping
from khepera_forage.robots.serial.port_thread import Task
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from tests.robots.rig import FORWARD, Rig, rig

DRIVE = """
import os, signal, sys, time
from khepera_forage.robots.serial.fleet import Fleet
from khepera_forage.robots.khepera import Motors
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
robots = [SerialKhepera(port) for port in sys.argv[1:]]
def drive():
    for robot in robots:
        robot.drive(Motors(5, 5, 215, 200))
        robot.transmit()
    print("driving", flush=True)
def in_mid_request():
    drive()
    while True:
        Fleet(robots).receive()
"""


def program(built: Rig, body: str) -> "subprocess.Popen[str]":
    ports = [port.url for port in built.ports]
    child = subprocess.Popen(
        [sys.executable, "-W", "error", "-c", DRIVE + textwrap.dedent(body), *ports],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert child.stdout is not None
    assert child.stdout.readline() == "driving\n", child.communicate()[1]
    return child


def ended(child: "subprocess.Popen[str]") -> tuple[int, str]:
    _, errors = child.communicate(timeout=20)
    return child.returncode, errors


@pytest.mark.parametrize(
    ("body", "status", "last_words"),
    [
        ("drive()", 0, ""),
        ("drive(); sys.exit(3)", 3, ""),
        ("drive(); raise KeyError('here')", 1, "KeyError: 'here'"),
        ("drive(); robots[0].close(); robots[0].close()", 0, ""),
        ("with robots[0], robots[1]: drive()", 0, ""),
    ],
    ids=["end", "sys.exit", "uncaught", "one closed", "with"],
)
def test_leaving(body: str, status: int, last_words: str) -> None:
    with rig(2) as built:
        child = program(built, body)
        code, errors = ended(child)
        assert code == status
        assert last_words in errors
        assert errors.count("\n") == 0 or last_words
        assert built.stands()


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
@pytest.mark.parametrize(
    "body", ["drive(); time.sleep(60)", "in_mid_request()"], ids=["idle", "in mid-request"]
)
def test_signals(name: str, body: str) -> None:
    number = signal.Signals[name]
    with rig(2, baud=38400) as built:
        child = program(built, body)
        time.sleep(0.1)
        assert built.wheels(0) == built.wheels(1) == (50, 50)
        child.send_signal(number)
        code, errors = ended(child)
        assert built.stands()
        assert code == -number
        assert ("KeyboardInterrupt" in errors) == (name == "SIGINT")


def test_a_handler_that_was_there_is_handed_on_to() -> None:
    install = "import signal, sys\nsignal.signal(signal.SIGTERM, lambda number, frame: sys.exit(7))\n"
    with rig(1) as built:
        child = subprocess.Popen(
            [sys.executable, "-W", "error", "-c", install + DRIVE + "in_mid_request()", built.url],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        assert child.stdout is not None
        assert child.stdout.readline() == "driving\n"
        child.terminate()
        code, errors = ended(child)
        assert (code, errors) == (7, "")
        assert built.stands()


def test_a_signal_that_is_ignored_stays_ignored() -> None:
    body = """
    drive()
    sys.stdin.readline()
    """
    with rig(1) as built:
        child = subprocess.Popen(
            [
                sys.executable,
                "-c",
                "import signal\nsignal.signal(signal.SIGHUP, signal.SIG_IGN)\n"
                + DRIVE
                + textwrap.dedent(body),
                built.url,
            ],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        assert child.stdout is not None
        assert child.stdout.readline() == "driving\n"
        child.send_signal(signal.SIGHUP)
        time.sleep(0.2)
        assert child.poll() is None
        assert built.wheels() == (50, 50)
        child.communicate("\n", timeout=20)
        assert child.returncode == 0
        assert built.stands()


def test_a_forked_child_leaves_the_robots_alone() -> None:
    body = """
    drive()
    if os.fork() == 0:
        sys.exit(0)
    os.wait()
    print(robots[0].ask("E"), flush=True)
    sys.stdin.readline()
    os._exit(0)
    """
    with rig(1) as built:
        child = subprocess.Popen(
            [sys.executable, "-c", DRIVE + textwrap.dedent(body), built.url],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert child.stdout is not None
        assert child.stdout.readline() == "driving\n"
        assert child.stdout.readline() == "(0, 0)\n"
        assert built.wheels() == (50, 50)
        child.communicate("\n", timeout=20)


@pytest.fixture
def handlers() -> Iterator[dict[int, Any]]:
    """This process' own, put back after the test."""
    found: dict[int, Any] = {n: signal.getsignal(n) for n in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)}
    yield found
    for number, handler in found.items():
        signal.signal(number, handler)


def test_handlers_are_there_only_while_a_robot_is_open(handlers: dict[int, Any]) -> None:
    with rig(2) as built:
        robots = [SerialKhepera(port.url) for port in built.ports]
        assert all(signal.getsignal(number) is not found for number, found in handlers.items())
        robots[0].close()
        assert all(signal.getsignal(number) is not found for number, found in handlers.items())
        robots[1].close()
        assert all(signal.getsignal(number) is found for number, found in handlers.items())


def test_a_handler_that_hands_on_to_ours_is_left(handlers: dict[int, Any]) -> None:
    heard: list[int] = []
    signal.signal(signal.SIGTERM, lambda number, frame: heard.append(1))
    with rig(1) as built:
        robot = SerialKhepera(built.url)
        ours = signal.getsignal(signal.SIGTERM)

        def later(number: int, frame: FrameType | None) -> None:
            heard.append(2)
            assert callable(ours)
            ours(number, frame)

        signal.signal(signal.SIGTERM, later)
        robot.close()
        assert signal.getsignal(signal.SIGTERM) is later
        os.kill(os.getpid(), signal.SIGTERM)
        assert heard == [2, 1]
        with SerialKhepera(built.url) as robot:
            robot.drive(FORWARD)
            robot.transmit()
            os.kill(os.getpid(), signal.SIGTERM)
            assert heard == [2, 1, 2, 1]
            assert built.stands()


def test_a_robot_opened_in_another_thread_is_stopped_at_exit_only(handlers: dict[int, Any]) -> None:
    with rig(1) as built:
        robots: list[SerialKhepera] = []
        thread = threading.Thread(target=lambda: robots.append(SerialKhepera(built.url)))
        thread.start()
        thread.join()
        assert all(signal.getsignal(number) is found for number, found in handlers.items())
        robots[0].close()


class Deaf:
    """A robot that cannot be stopped."""

    port = "nowhere"

    def begin_stop(self) -> Task[None]:
        return Task(lambda: None)


def test_one_that_cannot_be_stopped_keeps_no_other_from_it() -> None:
    with rig(1) as built, SerialKhepera(built.url) as robot:
        robot.drive(FORWARD)
        robot.transmit()
        deaf = Deaf()
        failed = stopping.stop_all((deaf, robot), patience=0.5)
        assert built.stands()
        assert [(which, type(error)) for which, error in failed] == [(deaf, TimeoutError)]
