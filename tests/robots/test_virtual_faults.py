"""What a host sees of each fault of a virtual line, and what the robot does meanwhile."""

import time

import numpy as np
import pytest
import serial

from khepera_forage.robots.serial.protocol import BANNER, BannerLine, decode_reply
from khepera_forage.robots.virtual.line_faults import FaultCounts, Faults
from khepera_forage.robots.virtual.virtual_port import VirtualKhepera
from tests.robots.hosts import SILENCE, WAIT, ask_for_ever, opened
from tests.robots.stage import Stage

pytestmark = pytest.mark.usefixtures("nothing_left_behind")


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def test_drop_loses_half_the_requests_and_half_the_replies(stage: Stage) -> None:
    done = 0
    with (
        VirtualKhepera(stage.firmware, baud=None, faults=Faults(drop=1.0), rng=rng()) as khepera,
        opened(khepera, timeout=SILENCE) as host,
    ):
        for address in range(64):
            host.write(f"W,1,{address}\n".encode())
        assert host.read(1) == b""
        khepera.faults = Faults()
        host.timeout = WAIT
        for address in range(64):
            host.write(f"R,{address}\n".encode())
            done += host.readline() == b"r,1\r\n"
        assert khepera.counts.drop == 64
    assert 16 < done < 48


def test_delay_comes_after_the_host_has_asked_again(stage: Stage) -> None:
    faults = Faults(delay=1.0, lateness=(0.15, 0.2))
    with (
        VirtualKhepera(stage.firmware, baud=None, faults=faults, rng=rng()) as khepera,
        opened(khepera, timeout=0.05) as host,
    ):
        host.write(b"B\n")
        assert host.readline() == b""
        khepera.faults = Faults()
        host.write(b"E\n")
        host.timeout = WAIT
        assert [host.readline(), host.readline()] == [b"b,5.02,5.01\r\n", b"e,0,0\r\n"]
        assert khepera.counts.delay == 1


def test_duplicate_comes_twice(stage: Stage, tcp: int | None) -> None:
    with (
        VirtualKhepera(
            stage.firmware, tcp=tcp, baud=None, faults=Faults(duplicate=1.0), rng=rng()
        ) as khepera,
        opened(khepera) as host,
    ):
        host.write(b"E\n")
        assert [host.readline(), host.readline()] == [b"e,0,0\r\n"] * 2


def test_garble_changes_the_reply_and_not_what_the_robot_does(stage: Stage) -> None:
    with (
        VirtualKhepera(stage.firmware, baud=None, faults=Faults(garble=1.0), rng=rng()) as khepera,
        opened(khepera, timeout=0.02) as host,
    ):
        intact = 0
        for value in range(40):
            host.write(f"W,{value},7\n".encode())
            intact += host.read(100) == b"w\r\n"
        assert intact < 4
        assert stage.numbers("R,7") == [39]
        assert khepera.counts.garble == 40


def test_reset_stops_the_robot_and_shows_the_banner(stage: Stage, tcp: int | None) -> None:
    with (
        VirtualKhepera(stage.firmware, tcp=tcp, baud=None, rng=rng()) as khepera,
        opened(khepera) as host,
    ):
        beginnings = set()
        for _ in range(12):
            host.write(b"D,5,5\n")
            assert host.readline() == b"d\r\n"
            stage.rounds(1)
            khepera.faults = Faults(reset=1.0)
            host.write(b"H\n")
            first, *rest = (host.readline().rstrip() for _ in BANNER)
            khepera.faults = Faults()
            read = decode_reply(first)
            assert isinstance(read, BannerLine)
            assert read.text.endswith(BANNER[0])
            beginnings.add(read.text.removesuffix(BANNER[0]))
            assert rest == [line.encode() for line in BANNER[1:]]
            stage.rounds(2)
            host.write(b"H\n")
            assert host.readline() == b"h,0,0\r\n", "stopped, counters at 0"
    assert "" in beginnings
    assert len(beginnings) > 2
    assert all("h,50,50\r\n".startswith(beginning.replace("\r", "")) for beginning in beginnings)


def test_unplug_is_for_good_and_the_robot_stands(stage: Stage, tcp: int | None) -> None:
    with (
        VirtualKhepera(stage.firmware, tcp=tcp, baud=None, rng=rng()) as khepera,
        opened(khepera) as host,
    ):
        host.write(b"D,5,5\n")
        assert host.readline() == b"d\r\n"
        khepera.faults = Faults(unplug=1.0)
        with pytest.raises(serial.SerialException):
            ask_for_ever(host)
        deadline = time.monotonic() + WAIT
        while khepera.plugged and time.monotonic() < deadline:
            time.sleep(0.01)
        assert not khepera.plugged
        assert khepera.counts.unplug == 1
        before = stage.robot.sense()
        stage.rounds(3)
        assert stage.robot.sense().left_pulses == before.left_pulses
        with pytest.raises(serial.SerialException), opened(khepera):
            pass


def test_same_seed_same_bytes(stage: Stage) -> None:
    faults = Faults(drop=0.1, garble=0.3, duplicate=0.2, reset=0.1)
    runs: list[tuple[bytes, FaultCounts]] = []
    for _ in range(2):
        with (
            VirtualKhepera(stage.firmware, baud=None, faults=faults, rng=rng(4)) as khepera,
            opened(khepera) as host,
        ):
            host.write(b"H\nT,1,H,0\nN\nB\n" * 10)
            deadline = time.monotonic() + WAIT
            while khepera.counts.replies < 40 and time.monotonic() < deadline:
                time.sleep(0.005)
            khepera.faults = Faults()
            host.write(b"\nI,3\n")
            runs.append((host.read_until(b"i,0\r\n"), khepera.counts))
    assert runs[0] == runs[1]
    assert runs[0][0].endswith(b"i,0\r\n")
