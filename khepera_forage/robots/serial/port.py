"""Opening a serial port for a Khepera: 8 data bits, no parity, 2 stop bits, one of five baud rates.

Requires pyserial, the extra `robots`; it is imported when a port is opened, not before.
"""

import contextlib
import socket
from typing import TYPE_CHECKING

from khepera_forage.extras import require

if TYPE_CHECKING:
    from serial import Serial

BAUD_RATES = (9600, 19200, 38400, 57600, 115200)
"""Settings of a Khepera's mode switch."""
BITS_PER_BYTE = 11
"""1 start, 8 data and 2 stop bits (K-Team)."""
POLL = 0.005
"""Seconds after which a read without input returns. Constant: `rfc2217://` negotiates every change with the server."""
_RFC2217 = "rfc2217://"
"""For these, pyserial has a fixed write timeout and rejects any other."""


def seconds_on_wire(count: int, baud: int) -> float:
    """Transmission time of a number of bytes at a baud rate."""
    return count * BITS_PER_BYTE / baud


def open_port(port: str, baud: int, write_timeout: float) -> "Serial":
    """Open a port.

    Args:
        port: Any argument of `serial.serial_for_url`: a device, `socket://host:port`, `rfc2217://host:port`.
        baud: One of `BAUD_RATES`. A `socket://` ignores it.
        write_timeout: Seconds that the port may take to accept the bytes of a request. An `rfc2217://` ignores it.

    Raises:
        ValueError: Another baud rate, or a URL that pyserial does not support.
        ConnectionError: The port cannot be opened, or another program uses it.
        ImportError: pyserial is missing.
    """
    if baud not in BAUD_RATES:
        raise ValueError(f"baud {baud}; allowed: {', '.join(map(str, BAUD_RATES))}")
    require("a serial port", "robots")
    import serial

    try:
        opened = serial.serial_for_url(
            port,
            baudrate=baud,
            bytesize=serial.EIGHTBITS,
            parity=serial.PARITY_NONE,
            stopbits=serial.STOPBITS_TWO,
            timeout=POLL,
            write_timeout=None if port.startswith(_RFC2217) else write_timeout,
            exclusive=True,
        )
    except OSError as error:
        raise ConnectionError(f"{port} cannot be opened: {error}") from error
    # The latency timer of a USB adapter, often 16 ms, would delay every reply. Only Linux devices support this mode.
    with contextlib.suppress(AttributeError, OSError, ValueError):
        opened.set_low_latency_mode(True)
    return opened


def descriptor_of(port: "Serial") -> int | None:
    """The file descriptor of an open port; None if it has none, as `loop://`."""
    # `rfc2217://` has no `fileno`. Its protocol needs no preparation of bytes below 255.
    connection = getattr(port, "_socket", None)
    if isinstance(connection, socket.socket):
        return connection.fileno()
    try:
        return int(port.fileno())
    except (AttributeError, OSError):
        return None
