"""The host's end of a virtual serial line, through pyserial."""

import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager

import serial

from khepera_forage.robots.virtual.virtual_khepera import VirtualKhepera

WAIT = 5.0
"""Seconds after which an expected event counts as missing."""
SILENCE = 0.1
"""Seconds in which an unexpected reply would have arrived."""


@contextmanager
def connected_host(khepera: VirtualKhepera, timeout: float = WAIT) -> Iterator[serial.Serial]:
    """Open the port of a virtual Khepera."""
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
