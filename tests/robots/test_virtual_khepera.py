"""A virtual Khepera on a real pseudo-terminal and a real TCP port, accessed through pyserial."""

import os
import select
import socket
import threading
import time
from pathlib import Path

import pytest
import serial

from khepera_forage.robots.serial.khepera_protocol import KHEPERA
from khepera_forage.robots.serial.protocol import Reply
from khepera_forage.robots.virtual.faults import FaultCounts
from khepera_forage.robots.virtual.virtual_khepera import VirtualKhepera
from tests.robots.hosts import WAIT, connected_host, send_until_disconnected
from tests.robots.stage import Stage

pytestmark = pytest.mark.usefixtures("no_leaks")


def test_requests_are_executed_and_answered(stage: Stage, tcp: int | None) -> None:
    with VirtualKhepera(stage.firmware, tcp=tcp, baud=None) as khepera, connected_host(khepera) as host:
        assert khepera.url.startswith("/dev/pts/" if tcp is None else "socket://127.0.0.1:")
        for line, reply in ((b"D,5,5\n", b"d\r\n"), (b"T,1,E,255\r", b"t,1,e\r\n"), (b"H\r\n", b"h,0,0\r\n")):
            host.write(line)
            assert host.readline() == reply
        stage.rounds(12)
        host.write(b"H\nT,1,H,1\nfoo\n")
        assert [host.readline() for _ in range(3)] == [
            b"h,600,600\r\n",
            b"t,1,h,255\r\n",
            b"z,Command not found\r\n",
        ]
        host.write(b"restart\n")
        assert [host.readline().decode().rstrip() for _ in KHEPERA.banner] == list(KHEPERA.banner)
        assert khepera.fault_counts == FaultCounts(replies=7)


def test_bytes_are_not_translated(stage: Stage, tcp: int | None) -> None:
    """No echo, no translation, no interrupt characters."""
    with VirtualKhepera(stage.firmware, tcp=tcp, baud=None) as khepera, connected_host(khepera) as host:
        host.write(bytes(set(range(256)) - {10, 13}) + b"\n")
        assert host.readline() == b"z,Command not found\r\n"
        host.write(b"B\n")
        assert host.readline() == b"b,5.02,5.01\r\n"


def test_pseudo_terminal_works_without_any_configuration(stage: Stage) -> None:
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


def test_hosts_can_reconnect(stage: Stage, tcp: int | None) -> None:
    with VirtualKhepera(stage.firmware, tcp=tcp, baud=None) as khepera:
        for turn in range(3):
            with connected_host(khepera) as host:
                host.write(f"G,{turn},0\n".encode())
                assert host.readline() == b"g\r\n"
                host.write(b"H\n")
                assert host.readline() == f"h,{turn},0\r\n".encode()
        assert khepera.connected


def test_second_tcp_host_is_disconnected(stage: Stage) -> None:
    with VirtualKhepera(stage.firmware, tcp=0, baud=None) as khepera, connected_host(khepera) as host:
        host.write(b"B\n")
        assert host.readline() == b"b,5.02,5.01\r\n"
        with socket.create_connection(("127.0.0.1", int(khepera.url.rpartition(":")[2])), WAIT) as second:
            assert second.recv(1) == b""
        host.write(b"E\n")
        assert host.readline() == b"e,0,0\r\n"


def test_host_that_does_not_read_loses_replies(stage: Stage) -> None:
    with VirtualKhepera(stage.firmware, baud=None) as khepera, connected_host(khepera) as host:
        for _ in range(40):
            host.write(b"O\n" * 20)
            time.sleep(0.001)
        deadline = time.monotonic() + WAIT
        while khepera.fault_counts.replies < 800 and time.monotonic() < deadline:
            time.sleep(0.01)
        assert khepera.fault_counts.replies == 800
        host.reset_input_buffer()
        host.write(b"B\n")
        assert host.readline().endswith(b"b,5.02,5.01\r\n")


class TestLineSpeed:
    @pytest.mark.parametrize("baud", [9600, 115200])
    def test_round_trip_takes_the_transmission_time(self, stage: Stage, tcp: int | None, baud: int) -> None:
        rounds = 400 * baud // 115200
        with VirtualKhepera(stage.firmware, tcp=tcp, baud=baud) as khepera, connected_host(khepera) as host:
            begin, count = time.monotonic(), 0
            for _ in range(rounds):
                host.write(b"N\n")
                count += 2 + len(host.readline())
            took = time.monotonic() - begin
        wire = count * 11 / baud
        assert took >= wire, "no faster than the line"

    def test_unsupported_baud_rate_is_rejected(self, stage: Stage) -> None:
        with pytest.raises(ValueError, match=r"12345.*38400"):
            VirtualKhepera(stage.firmware, baud=12345)


def test_close_disconnects_even_during_a_reply(stage: Stage, tcp: int | None) -> None:
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


def test_replies_are_intact_while_the_world_advances(stage: Stage) -> None:
    """Requests and the simulation run in different threads."""
    stop = threading.Event()

    def advance() -> None:
        while not stop.wait(0.002):
            with stage.lock:
                stage.world.advance()
                stage.firmware.tick()

    world = threading.Thread(target=advance)
    world.start()
    try:
        with VirtualKhepera(stage.firmware, baud=None) as khepera, connected_host(khepera) as host:
            last = 0
            host.write(b"D,1,1\n")
            assert host.readline() == b"d\r\n"
            for _ in range(200):
                host.write(b"H\n")
                reply = KHEPERA.decode_reply(host.readline())
                assert isinstance(reply, Reply)
                left, right = reply.values
                assert isinstance(left, int)
                assert left == right
                assert left >= last
                last = left
    finally:
        stop.set()
        world.join()
    assert last > 0
