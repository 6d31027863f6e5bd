"""A host's end of a virtual line, for tests."""

import socket
import time
from collections.abc import Iterator
from contextlib import contextmanager

import serial

from khepera_forage.robots.virtual.virtual_port import VirtualKhepera

WAIT = 5.0
"""Seconds after which something that should have come will not."""
SILENCE = 0.1
"""Seconds in which something that should not come would have."""


@contextmanager
def opened(khepera: VirtualKhepera, timeout: float = WAIT) -> Iterator[serial.Serial]:
    """The port of a virtual Khepera, through pyserial."""
    host = serial.serial_for_url(khepera.url, baudrate=38400, stopbits=serial.STOPBITS_TWO, timeout=timeout)
    # pyserial forgets a socket that the other side has reset instead of closing it.
    connection: socket.socket | None = getattr(host, "_socket", None)
    try:
        yield host
    finally:
        host.close()
        if connection is not None:
            connection.close()


def ask_for_ever(host: serial.Serial) -> None:
    """Until the line says that it is no more."""
    begin = time.monotonic()
    while time.monotonic() < begin + WAIT:
        host.write(b"H\n")
        host.read(1)
