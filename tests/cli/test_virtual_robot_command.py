"""`khepera-forage robot virtual`: a virtual Khepera for other programs."""

import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
import serial

from khepera_forage.cli.main import main

WAIT = 10.0


@contextmanager
def started(*arguments: str) -> Iterator[tuple[subprocess.Popen[str], str]]:
    """The command in another process, and the port that it prints."""
    with subprocess.Popen(
        [sys.executable, "-m", "khepera_forage", "robot", "virtual", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            assert process.stdout is not None
            first = process.stdout.readline()
            assert first.startswith("a virtual Khepera at "), process.communicate()
            yield process, first.split()[4].removesuffix(";")
        finally:
            process.kill()


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_virtual_robot_runs_until_a_signal(number: signal.Signals) -> None:
    with started("--baud", "115200") as (process, port):
        with serial.serial_for_url(port, 115200, timeout=WAIT) as host:
            host.write(b"B\nD,5,5\n")
            assert host.readline() == b"b,5.02,5.01\r\n"
            assert host.readline() == b"d\r\n"
            deadline, count = time.monotonic() + WAIT, 0
            while count < 100 and time.monotonic() < deadline:
                host.write(b"H\n")
                count = int(host.readline().decode().split(",")[1])
            assert count >= 100, "its world advances in real time"
        process.send_signal(number)
        printed, errors = process.communicate(timeout=WAIT)
        assert process.returncode == 0
    assert printed.startswith("stopped\n")
    assert " requests" in printed
    assert errors == ""


def test_virtual_robot_ends_when_unplugged() -> None:
    with started("--tcp", "0", "--unplug", "1", "--seed", "3") as (process, port):
        with serial.serial_for_url(port, timeout=WAIT) as host:
            host.write(b"B\n")
            with pytest.raises(serial.SerialException):
                host.read(1)
        printed, errors = process.communicate(timeout=WAIT)
        assert process.returncode == 0
    assert printed == "unplugged\n1 requests, 1 unplug\n"
    assert errors == ""


def test_signals_are_as_before_after_a_mistake(capsys: pytest.CaptureFixture[str]) -> None:
    handlers = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    assert main(["robot", "virtual", "--baud", "300"]) == 2
    assert "300" in capsys.readouterr().err
    assert (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)) == handlers
