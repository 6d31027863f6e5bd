"""Opening a serial port: errors, and the transmission time of bytes."""

import sys

import pytest

from khepera_forage.robots.serial.port import open_port, seconds_on_wire
from khepera_forage.robots.virtual.virtual_khepera import VirtualKhepera
from tests.robots.stage import Stage


def test_missing_port_is_reported() -> None:
    with pytest.raises(ConnectionError, match=r"/dev/nowhere cannot be opened"):
        open_port("/dev/nowhere", 38400)


def test_port_in_use_is_reported(stage: Stage) -> None:
    with VirtualKhepera(stage.firmware) as khepera:
        port = open_port(khepera.url, 38400)
        with pytest.raises(ConnectionError, match="cannot be opened"):
            open_port(khepera.url, 38400)
        port.close()


def test_missing_pyserial_is_reported_with_the_command_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "serial", None)
    with pytest.raises(ImportError, match=r"pip install 'khepera-forage\[robots\]'"):
        open_port("/dev/nowhere", 38400)


def test_transmission_time_counts_eleven_bits_per_byte() -> None:
    assert seconds_on_wire(9600, 9600) == 11.0, "1 start, 8 data, 2 stop bits"
