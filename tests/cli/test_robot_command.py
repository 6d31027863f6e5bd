"""`khepera-forage robot`, and virtual robots that the command itself starts for other programs."""

import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

import pytest
import serial

from khepera_forage.cli.robot import bars
from khepera_forage.robots.khepera import CONTROL_PERIOD, Senses
from khepera_forage.robots.serial import serial_robot
from khepera_forage.robots.virtual.virtual_khepera import Faults, VirtualKhepera
from tests.cli.running import Run
from tests.lab.laboratories import Time
from tests.robots.rig import Rig, make_rig

WAIT = 60.0
"""Seconds after which something counts as missing: a busy machine takes long."""


class WorldTime(Time):
    """The time of commands; the world of a rig advances while they sleep."""

    perf_counter = staticmethod(time.perf_counter)

    def __init__(self, rig: Rig) -> None:
        super().__init__()
        self.rig, self.begin, self.rounds = rig, self.now, 0

    def sleep(self, seconds: float) -> None:
        super().sleep(seconds)
        due = round((self.now - self.begin) / CONTROL_PERIOD)
        self.rig.advance(due - self.rounds)
        self.rounds = due


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


@pytest.fixture
def rig(monkeypatch: pytest.MonkeyPatch) -> Iterator[Rig]:
    """A virtual Khepera whose time passes only while commands sleep, at any load of the machine."""
    with make_rig(baud=38400) as rig:
        monkeypatch.setattr("khepera_forage.cli.robot.time", WorldTime(rig))
        yield rig


@pytest.fixture
def frozen() -> Iterator[VirtualKhepera]:
    """A virtual Khepera in a world without time, whose motors never move."""
    with make_rig() as rig:
        yield rig.ports[0]


def test_probe_prints_versions_and_response_times(rig: Rig, run: Run) -> None:
    out = run(f"robot probe --port {rig.url}")
    assert f"{rig.url}, 38400 baud" in out
    assert "BIOS 5.02, protocol 5.01" in out
    assert "version 2.1, jumpers 0; arm" in out
    trips = [float(ms) for ms in re.findall(r"([\d.]+) ms round trip", out)]
    assert len(trips) == 5
    assert all(ms > 1 for ms in trips), "at 38400 baud, bytes alone take longer than 1 ms"
    rate = re.search(r"at most ([\d.]+) rounds a second\n", out)
    assert rate is not None
    assert 0 < float(rate[1]) < 57, "61 bytes take 17 ms"


def test_commands_accept_a_line_that_is_too_slow_for_a_laboratory(frozen: VirtualKhepera, run: Run) -> None:
    frozen.faults = Faults(delay=1.0, lateness=(0.12, 0.12))
    run(f"robot drive --port {frozen.url} --seconds 0.2")
    run(f"robot grip open --port {frozen.url}")
    out = run(f"robot selftest --port {frozen.url}", status=1)
    assert re.search(r"^a round +FAIL   \d+ ms", out, re.MULTILINE)
    frozen.faults = Faults()


def test_sensors_prints_lines_without_a_terminal(rig: Rig, run: Run) -> None:
    heading, *lines = run(f"robot sensors --port {rig.url} --rounds 3").splitlines()
    assert len(lines) == 3
    for line in lines:
        proximity, pulses, others = line.split(" | ")
        assert all(0 <= int(v) <= 1023 for v in proximity.split())
        assert len(proximity.split()) == 8
        assert (len(pulses.split()), len(others.split())) == (2, 3)
    assert "arm jaw present" in heading


def test_bars_are_as_long_as_the_readings() -> None:
    shown = bars(Senses((0, 1023, 512, 0, 0, 0, 0, 0), 12, -12, 215, 200, 255)).splitlines()
    assert [line.count("█") for line in shown[:3]] == [0, 50, 25]
    assert "left 45" in shown[1]
    assert "object between the fingers" in shown[8]


def test_drive_turns_the_wheels_and_stops(rig: Rig, run: Run) -> None:
    out = run(f"robot drive --port {rig.url} --left 4 --right -4 --seconds 0.5")
    left, right = (int(pulses) for pulses in re.findall(r"(-?\d+) pulses", out))
    assert (left, right) == (200, -200)
    assert rig.is_stopped()


def test_drive_continues_after_a_restart(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    """The power supply fails for a moment, after half a second."""
    monkeypatch.setattr("khepera_forage.cli.robot.time", Time())
    rounds = iter(range(1000))
    with make_rig() as rig:

        def advance(line: bytes) -> bytes | None:
            if line != b"H":
                return None
            rig.advance()
            return rig.firmware.power_on() if next(rounds) == 5 else None

        rig.intercept(advance)
        out = run(f"robot drive --port {rig.url} --left 4 --right 4 --seconds 1.5")
        true_left = rig.robots[0].sense().left_pulses
    assert "the robot restarted 1 time: check its power supply" in out
    left, right = (int(pulses) for pulses in re.findall(r"(-?\d+) pulses", out))
    assert 0 <= true_left - left <= 2 * 40
    assert left == right


def test_grip_moves_the_jaw_with_a_watchdog_or_without(rig: Rig, monkeypatch: pytest.MonkeyPatch, run: Run) -> None:
    watched: list[str] = []
    monkeypatch.setattr(serial_robot, "start_watchdog", lambda port, *_: watched.append(port))
    assert "jaw at 0, barrier 0" in run(f"robot grip close --port {rig.url} --no-watchdog")
    assert not watched
    assert "jaw at 200, barrier 0" in run(f"robot grip open --port {rig.url}")
    assert watched == [rig.url]


def test_selftest_of_a_working_robot_passes(rig: Rig, run: Run) -> None:
    out = run(f"robot selftest --port {rig.url} --timeout 5")
    assert "10 of 10 passed" in out
    assert out.count(" pass ") == 10
    assert "FAIL" not in out
    (seconds,) = re.findall(r"again: 215 in (.*) s; longer than a round: .* --decision lowering_speed=0\n", out)
    assert float(seconds) >= 0.5, "the arm needs 1 s for 40 positions, and moved by 25"


def test_selftest_of_a_robot_that_does_not_move_fails(
    frozen: VirtualKhepera, run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("khepera_forage.cli.robot.time", Time())
    out = run(f"robot selftest --port {frozen.url} --timeout 5", status=1)
    for part in ("wheels", "arm", "jaw"):
        assert re.search(rf"^{part} +FAIL", out, re.MULTILINE)
    assert "7 of 10 passed" in out


def test_lost_robot_is_reported_in_one_line(frozen: VirtualKhepera, run: Run) -> None:
    frozen.faults = Faults(unplug=1.0)
    assert f"{frozen.url}: no answer to 'B'" in run.refused(f"robot probe --port {frozen.url}")


# ---------------------------------------------------------------- robot virtual


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


def test_signals_are_as_before_after_a_mistake(run: Run) -> None:
    handlers = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    assert "300" in run.refused("robot virtual --baud 300")
    assert (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)) == handlers
