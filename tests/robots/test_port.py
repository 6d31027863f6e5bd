"""Opening a serial port: errors, and the transmission time of bytes."""

import contextlib
import os
import sys
import time

import pytest

from khepera_forage.robots.serial.client import ProtocolClient
from khepera_forage.robots.serial.port import open_port, seconds_on_wire
from khepera_forage.robots.serial.protocol import Request
from khepera_forage.robots.virtual.virtual_khepera import VirtualKhepera
from tests.robots.stage import Stage


def test_missing_port_is_reported() -> None:
    with pytest.raises(ConnectionError, match=r"/dev/nowhere cannot be opened"):
        open_port("/dev/nowhere", 38400, 0.1)


def test_port_in_use_is_reported(stage: Stage) -> None:
    with VirtualKhepera(stage.firmware) as khepera:
        port = open_port(khepera.url, 38400, 0.1)
        with pytest.raises(ConnectionError, match="cannot be opened"):
            open_port(khepera.url, 38400, 0.1)
        port.close()


def test_missing_pyserial_is_reported_with_the_command_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "serial", None)
    with pytest.raises(ImportError, match=r"pip install 'khepera-forage\[robots\]'"):
        open_port("/dev/nowhere", 38400, 0.1)


def test_transmission_time_counts_eleven_bits_per_byte() -> None:
    assert seconds_on_wire(9600, 9600) == 11.0, "1 start, 8 data, 2 stop bits"


@pytest.mark.parametrize("timeout", [0.05, 0.8])
def test_blocked_port_loses_a_request_after_the_timeout(timeout: float) -> None:
    """Nothing reads the other end: its buffer is full after some kilobytes."""
    controller, terminal = os.openpty()
    try:
        client = ProtocolClient(os.ttyname(terminal), timeout=timeout)
        os.set_blocking(terminal, False)
        for _ in range(10):  # the system moves bytes on for some time
            with contextlib.suppress(BlockingIOError):
                while True:
                    os.write(terminal, b"n")
            time.sleep(0.01)
        begin = time.monotonic()
        client.exchange.send_unanswered(Request("N"))
        assert timeout <= time.monotonic() - begin < timeout + 0.4
        client.close()
    finally:
        os.close(controller)
        os.close(terminal)
