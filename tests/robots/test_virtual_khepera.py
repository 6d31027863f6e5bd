"""A virtual Khepera on a real pseudo-terminal and a real TCP port, accessed through pyserial."""

import os
import select
import socket
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from difflib import SequenceMatcher
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import serial

from khepera_forage.robots.epuck.driver import PROTOCOL as E_PUCK
from khepera_forage.robots.serial.protocol import KHEPERA, Reply
from khepera_forage.robots.virtual.virtual_khepera import FAULTS, Faults, VirtualKhepera, garbled, is_undetectable
from tests.robots.driver_process import wait_for
from tests.robots.rig import Rig

pytestmark = pytest.mark.usefixtures("no_leaks")

WAIT = 20.0
"""Seconds after which an expected event counts as missing."""
SILENCE = 0.1
"""Seconds in which an unexpected reply would have arrived."""


@contextmanager
def connected_host(khepera: VirtualKhepera, timeout: float = WAIT) -> Iterator[serial.Serial]:
    """The host's end of the line, through pyserial."""
    host = serial.serial_for_url(khepera.url, baudrate=38400, stopbits=serial.STOPBITS_TWO, timeout=timeout)
    # pyserial does not close a socket that the other side has reset.
    connection: socket.socket | None = getattr(host, "_socket", None)
    try:
        yield host
    finally:
        host.close()
        if connection is not None:
            connection.close()


def send_until_disconnected(host: serial.Serial) -> None:
    """Send requests until pyserial reports the disconnection, or for `WAIT` seconds."""
    begin = time.monotonic()
    while time.monotonic() < begin + WAIT:
        host.write(b"H\n")
        host.read(1)


@contextmanager
def connected(stage: Rig, *, timeout: float = WAIT, **options: Any) -> Iterator[tuple[VirtualKhepera, serial.Serial]]:
    """A virtual robot, as fast as possible by default, and its host."""
    with (
        VirtualKhepera(stage.firmware, **{"baud": None, **options}) as khepera,
        connected_host(khepera, timeout) as host,
    ):
        yield khepera, host


def asked(host: serial.Serial, line: bytes) -> bytes:
    """The reply to a request."""
    host.write(line)
    reply: bytes = host.readline()
    return reply


def test_requests_are_executed_and_answered(stage: Rig, tcp: int | None) -> None:
    with connected(stage, tcp=tcp) as (khepera, host):
        assert khepera.url.startswith("/dev/pts/" if tcp is None else "socket://127.0.0.1:")
        for line, reply in ((b"D,5,5\n", b"d\r\n"), (b"T,1,E,255\r", b"t,1,e\r\n"), (b"H\r\n", b"h,0,0\r\n")):
            assert asked(host, line) == reply
        stage.advance(12)
        host.write(b"H\nT,1,H,1\nfoo\n")
        assert [host.readline() for _ in range(3)] == [b"h,600,600\r\n", b"t,1,h,255\r\n", b"z,Command not found\r\n"]
        host.write(b"restart\n")
        assert [host.readline().decode().rstrip() for _ in KHEPERA.banner] == list(KHEPERA.banner)
        assert asked(host, b"E\n") == b"e,0,0\r\n"
        stage.advance(2)
        assert asked(host, b"H\n") == b"h,0,0\r\n", "the wheels are stopped"
        assert khepera.fault_counts == {"replies": 9}


def test_pseudo_terminal_works_without_any_configuration(stage: Rig) -> None:
    """The terminal itself neither echoes nor translates, so programs can open it as a file."""
    with VirtualKhepera(stage.firmware, baud=None) as khepera:
        terminal = os.open(khepera.url, os.O_RDWR | os.O_NOCTTY)
        try:
            os.write(terminal, b"B\r")
            read = b""
            while not read.endswith(b"\n"):
                assert select.select([terminal], [], [], WAIT)[0], read
                read += os.read(terminal, 100)
        finally:
            os.close(terminal)
    assert read == b"b,5.02,5.01\r\n"


def test_hosts_can_connect_one_after_the_other_but_not_together(stage: Rig, tcp: int | None) -> None:
    with VirtualKhepera(stage.firmware, tcp=tcp, baud=None) as khepera:
        for turn in range(3):
            with connected_host(khepera) as host:
                assert asked(host, f"G,{turn},0\n".encode()) == b"g\r\n"
                if tcp is not None:
                    with socket.create_connection(("127.0.0.1", int(khepera.url.rpartition(":")[2])), WAIT) as second:
                        assert second.recv(1) == b""
                assert asked(host, b"H\n") == f"h,{turn},0\r\n".encode()
        assert khepera.connected


def test_host_that_does_not_read_loses_replies(stage: Rig) -> None:
    with connected(stage) as (khepera, host):
        for _ in range(40):
            host.write(b"O\n" * 20)
            time.sleep(0.001)
        wait_for(lambda: khepera.fault_counts["replies"] == 800)
        host.reset_input_buffer()
        host.write(b"B\n")
        # Some replies may still have been under way.
        assert any(line.endswith(b"b,5.02,5.01\r\n") for line in iter(host.readline, b""))


@pytest.mark.parametrize("baud", [9600, 115200])
def test_round_trip_takes_the_transmission_time(stage: Rig, tcp: int | None, baud: int) -> None:
    with connected(stage, tcp=tcp, baud=baud) as (_, host):
        begin, count = time.monotonic(), 0
        for _ in range(400 * baud // 115200):
            count += 2 + len(asked(host, b"N\n"))
        assert time.monotonic() - begin >= count * 11 / baud, "no faster than the line"


def test_close_disconnects_even_during_a_reply(stage: Rig, tcp: int | None) -> None:
    khepera = VirtualKhepera(stage.firmware, tcp=tcp, baud=9600)
    with connected_host(khepera) as host:
        host.write(b"O\n" * 50)
        host.read(1)
        khepera.close()
        khepera.close()
        with pytest.raises(serial.SerialException):
            send_until_disconnected(host)
    if tcp is None:
        assert not Path(khepera.url).exists()


def test_drop_loses_requests_and_replies_equally(stage: Rig) -> None:
    executed = stage.intercept()
    with connected(stage, faults=Faults(drop=1.0), timeout=SILENCE) as (khepera, host):
        host.write(b"B\n" * 64)
        assert host.read(1) == b""
        wait_for(lambda: khepera.fault_counts["drop"] == 64)
    assert 16 < len(executed) < 48


def test_delayed_reply_arrives_after_the_next_request(stage: Rig) -> None:
    faults = Faults(delay=1.0, lateness=(0.5, 0.6))
    with connected(stage, faults=faults, timeout=0.05) as (khepera, host):
        assert asked(host, b"B\n") == b""
        khepera.faults = Faults()
        host.timeout = WAIT
        assert [asked(host, b"E\n"), host.readline()] == [b"b,5.02,5.01\r\n", b"e,0,0\r\n"]
        assert khepera.fault_counts["delay"] == 1


def test_garble_changes_the_reply_but_not_the_execution(stage: Rig) -> None:
    with connected(stage, faults=Faults(garble=1.0), timeout=SILENCE) as (khepera, host):
        for value in range(40):
            host.write(f"G,{value},7\n".encode())
        wait_for(lambda: khepera.fault_counts["garble"] == 40)
        assert stage.request("H") == "h,39,7"
        assert b"g\r\n" * 4 not in host.read(1000)


def test_reset_stops_the_robot_and_sends_the_banner(stage: Rig, tcp: int | None) -> None:
    with connected(stage, tcp=tcp) as (khepera, host):
        beginnings = set()
        for _ in range(12):
            assert asked(host, b"D,5,5\n") == b"d\r\n"
            stage.advance(1)
            khepera.faults = Faults(reset=1.0)
            host.write(b"H\n")
            first, *rest = (host.readline().decode().rstrip() for _ in KHEPERA.banner)
            khepera.faults = Faults()
            assert first.endswith(KHEPERA.banner[0])
            beginnings.add(first.removesuffix(KHEPERA.banner[0]))
            assert rest == list(KHEPERA.banner[1:])
            stage.advance(2)
            assert asked(host, b"H\n") == b"h,0,0\r\n", "stopped, counters at 0"
    assert "" in beginnings
    assert len(beginnings) > 2, "parts of the reply"


def test_same_seed_sends_the_same_bytes(stage: Rig) -> None:
    faults = Faults(drop=0.1, garble=0.3, duplicate=0.2, reset=0.1)
    runs: list[tuple[bytes, Counter[str]]] = []
    for _ in range(2):
        with connected(stage, faults=faults, rng=np.random.default_rng(4)) as (khepera, host):
            host.write(b"H\nT,1,H,0\nN\nB\n" * 10)
            wait_for(lambda khepera=khepera: khepera.fault_counts["replies"] == 40)  # type: ignore[misc]
            khepera.faults = Faults()
            host.write(b"\nI,3\n")
            runs.append((host.read_until(b"i,0\r\n"), khepera.fault_counts))
    assert runs[0] == runs[1]
    assert runs[0][0].endswith(b"i,0\r\n")


def test_faults_occur_at_their_rates() -> None:
    faults = Faults(drop=0.05, delay=0.1, garble=0.15, duplicate=0.2, reset=0.02, unplug=0.01)
    generator = np.random.default_rng(0)
    drawn = [faults.draw(generator) for _ in range(20_000)]
    for fault in FAULTS:
        assert abs(drawn.count(fault) / len(drawn) - getattr(faults, fault)) < 0.01


def test_garbled_replies_differ_in_at_most_three_bytes_and_some_are_undetectable() -> None:
    reply = KHEPERA.encode_reply(Reply("N", (12, 345, 6, 1023, 77, 0, 8, 910)))
    generator, undetectable = np.random.default_rng(0), 0
    for _ in range(2000):
        data = garbled(reply, generator)
        matcher = SequenceMatcher(None, reply, data, autojunk=False)
        assert sum(block.size for block in matcher.get_matching_blocks()) >= len(reply) - 6
        assert abs(len(data) - len(reply)) <= 3
        undetectable += is_undetectable(data, reply, KHEPERA)
    assert 100 < undetectable < 1000
    version = b"v,Version 2.0\r\nHW version: E\r\n"
    assert is_undetectable(version.replace(b"2", b"3"), version, E_PUCK)
    assert not is_undetectable(b"?", b"".join(line.encode() + b"\r\n" for line in KHEPERA.banner), KHEPERA)
