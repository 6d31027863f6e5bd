"""Each fault of a virtual line: what the host receives, and what the robot does."""

import time
from difflib import SequenceMatcher

import numpy as np
import pytest
import serial

from khepera_forage.robots.serial.khepera_protocol import KHEPERA
from khepera_forage.robots.serial.protocol import Reply, TextLine
from khepera_forage.robots.virtual.faults import FAULTS, FaultCounts, Faults, garbled, is_undetectable
from khepera_forage.robots.virtual.virtual_khepera import VirtualKhepera
from tests.robots.hosts import SILENCE, WAIT, connected_host, send_until_disconnected
from tests.robots.stage import Stage

pytestmark = pytest.mark.usefixtures("no_leaks")


def rng(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


def test_drop_loses_requests_and_replies_equally(stage: Stage) -> None:
    done = 0
    with (
        VirtualKhepera(stage.firmware, baud=None, faults=Faults(drop=1.0), rng=rng()) as khepera,
        connected_host(khepera, timeout=SILENCE) as host,
    ):
        for address in range(64):
            host.write(f"W,1,{address}\n".encode())
        assert host.read(1) == b""
        khepera.faults = Faults()
        host.timeout = WAIT
        for address in range(64):
            host.write(f"R,{address}\n".encode())
            done += host.readline() == b"r,1\r\n"
        assert khepera.fault_counts.drop == 64
    assert 16 < done < 48


def test_delayed_reply_arrives_after_the_next_request(stage: Stage) -> None:
    faults = Faults(delay=1.0, lateness=(0.15, 0.2))
    with (
        VirtualKhepera(stage.firmware, baud=None, faults=faults, rng=rng()) as khepera,
        connected_host(khepera, timeout=0.05) as host,
    ):
        host.write(b"B\n")
        assert host.readline() == b""
        khepera.faults = Faults()
        host.write(b"E\n")
        host.timeout = WAIT
        assert [host.readline(), host.readline()] == [b"b,5.02,5.01\r\n", b"e,0,0\r\n"]
        assert khepera.fault_counts.delay == 1


def test_garble_changes_the_reply_but_not_the_execution(stage: Stage) -> None:
    with (
        VirtualKhepera(stage.firmware, baud=None, faults=Faults(garble=1.0), rng=rng()) as khepera,
        connected_host(khepera, timeout=0.02) as host,
    ):
        intact = 0
        for value in range(40):
            host.write(f"W,{value},7\n".encode())
            intact += host.read(100) == b"w\r\n"
        assert intact < 4
        assert stage.numbers("R,7") == [39]
        assert khepera.fault_counts.garble == 40


def test_reset_stops_the_robot_and_sends_the_banner(stage: Stage, tcp: int | None) -> None:
    with (
        VirtualKhepera(stage.firmware, tcp=tcp, baud=None, rng=rng()) as khepera,
        connected_host(khepera) as host,
    ):
        beginnings = set()
        for _ in range(12):
            host.write(b"D,5,5\n")
            assert host.readline() == b"d\r\n"
            stage.rounds(1)
            khepera.faults = Faults(reset=1.0)
            host.write(b"H\n")
            first, *rest = (host.readline().rstrip() for _ in KHEPERA.banner)
            khepera.faults = Faults()
            read = KHEPERA.decode_reply(first)
            assert isinstance(read, TextLine)
            assert read.text.endswith(KHEPERA.banner[0])
            beginnings.add(read.text.removesuffix(KHEPERA.banner[0]))
            assert rest == [line.encode() for line in KHEPERA.banner[1:]]
            stage.rounds(2)
            host.write(b"H\n")
            assert host.readline() == b"h,0,0\r\n", "stopped, counters at 0"
    assert "" in beginnings
    assert len(beginnings) > 2
    assert all("h,50,50\r\n".startswith(beginning.replace("\r", "")) for beginning in beginnings)


def test_unplug_is_permanent_and_stops_the_robot(stage: Stage, tcp: int | None) -> None:
    with (
        VirtualKhepera(stage.firmware, tcp=tcp, baud=None, rng=rng()) as khepera,
        connected_host(khepera) as host,
    ):
        host.write(b"D,5,5\n")
        assert host.readline() == b"d\r\n"
        khepera.faults = Faults(unplug=1.0)
        with pytest.raises(serial.SerialException):
            send_until_disconnected(host)
        deadline = time.monotonic() + WAIT
        while khepera.connected and time.monotonic() < deadline:
            time.sleep(0.01)
        assert not khepera.connected
        assert khepera.fault_counts.unplug == 1
        before = stage.robot.sense()
        stage.rounds(3)
        assert stage.robot.sense().left_pulses == before.left_pulses
        with pytest.raises(serial.SerialException), connected_host(khepera):
            pass


def test_same_seed_sends_the_same_bytes(stage: Stage) -> None:
    faults = Faults(drop=0.1, garble=0.3, duplicate=0.2, reset=0.1)
    runs: list[tuple[bytes, FaultCounts]] = []
    for _ in range(2):
        with (
            VirtualKhepera(stage.firmware, baud=None, faults=faults, rng=rng(4)) as khepera,
            connected_host(khepera) as host,
        ):
            host.write(b"H\nT,1,H,0\nN\nB\n" * 10)
            deadline = time.monotonic() + WAIT
            while khepera.fault_counts.replies < 40 and time.monotonic() < deadline:
                time.sleep(0.005)
            khepera.faults = Faults()
            host.write(b"\nI,3\n")
            runs.append((host.read_until(b"i,0\r\n"), khepera.fault_counts))
    assert runs[0] == runs[1]
    assert runs[0][0].endswith(b"i,0\r\n")


REPLY = KHEPERA.encode_reply(Reply("N", (12, 345, 6, 1023, 77, 0, 8, 910)))


def test_faults_occur_at_their_rates() -> None:
    faults = Faults(drop=0.05, delay=0.1, garble=0.15, duplicate=0.2, reset=0.02, unplug=0.01)
    generator = rng()
    drawn = [faults.draw(generator) for _ in range(20_000)]
    for fault in FAULTS:
        assert abs(drawn.count(fault) / len(drawn) - getattr(faults, fault)) < 0.01


def test_faults_without_a_random_generator_are_rejected(stage: Stage) -> None:
    with pytest.raises(ValueError, match="default_rng"):
        VirtualKhepera(stage.firmware, faults=Faults(garble=0.1))
    with VirtualKhepera(stage.firmware) as khepera, pytest.raises(ValueError, match="default_rng"):
        khepera.faults = Faults(drop=0.1)


@pytest.mark.parametrize(
    ("rates", "message"),
    [
        ({"drop": -0.1}, "drop is -0.1"),
        ({"reset": 1.5}, "reset is 1.5"),
        ({"garble": float("nan")}, "garble is nan"),
        ({"drop": 0.6, "delay": 0.6}, "add up to 1.2"),
        ({"lateness": (1.0, 0.3)}, "lateness"),
        ({"lateness": (-1.0, 0.3)}, "lateness"),
    ],
)
def test_invalid_rates_are_rejected(rates: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Faults(**rates)  # type: ignore[arg-type]


def test_garbled_replies_differ_in_at_most_three_bytes_and_some_are_undetectable() -> None:
    generator, undetectable = rng(), 0
    for _ in range(2000):
        data = garbled(REPLY, generator)
        matcher = SequenceMatcher(None, REPLY, data, autojunk=False)
        assert sum(block.size for block in matcher.get_matching_blocks()) >= len(REPLY) - 6
        assert abs(len(data) - len(REPLY)) <= 3
        undetectable += is_undetectable(data, REPLY, KHEPERA)
    assert 100 < undetectable < 1000
    assert not is_undetectable(REPLY, REPLY, KHEPERA)
