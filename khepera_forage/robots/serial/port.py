"""Opening a serial line as a Khepera wants it: 8 data bits, no parity, 2 stop bits, one of five speeds.

Needs pyserial, the extra `robots`; it is imported when a port is opened, not before.
"""

import contextlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from serial import Serial

BAUDS = (9600, 19200, 38400, 57600, 115200)
"""The speeds that a Khepera's mode switch chooses from."""
BITS_PER_BYTE = 11
"""1 start, 8 data and 2 stop bits (K-Team)."""
POLL = 0.005
"""Seconds after which a read that got nothing comes back. Fixed: over `rfc2217://` a change is negotiated anew."""
_WRITE_TIMEOUT = 0.5
_RFC2217 = "rfc2217://"
"""pyserial has a timeout of its own for writing to these, and takes no other."""


def seconds_on_wire(count: int, baud: int) -> float:
    """How long so many bytes take at a baud rate."""
    return count * BITS_PER_BYTE / baud


def open_port(port: str, baud: int) -> "Serial":
    """Open a port.

    Args:
        port: A device, or what else `serial.serial_for_url` takes: `socket://host:port`, `rfc2217://host:port`.
        baud: One of `BAUDS`. A `socket://` has no speed of its own.

    Raises:
        ValueError: Another baud rate, or a URL that pyserial does not know.
        ConnectionError: The port cannot be opened, or another program has it.
        ImportError: pyserial is missing.
    """
    if baud not in BAUDS:
        raise ValueError(f"baud {baud}; allowed: {', '.join(map(str, BAUDS))}")
    try:
        import serial
    except ImportError as error:
        raise ImportError("a serial port needs pyserial: pip install 'khepera-forage[robots]'") from error
    try:
        opened = serial.serial_for_url(
            port,
            baudrate=baud,
            bytesize=serial.EIGHTBITS,
            parity=serial.PARITY_NONE,
            stopbits=serial.STOPBITS_TWO,
            timeout=POLL,
            write_timeout=None if port.startswith(_RFC2217) else _WRITE_TIMEOUT,
            exclusive=True,
        )
    except OSError as error:
        raise ConnectionError(f"{port} cannot be opened: {error}") from error
    # An adapter's latency timer, often 16 ms, would be added to every reply. Only a device under Linux can do this.
    with contextlib.suppress(AttributeError, OSError, ValueError):
        opened.set_low_latency_mode(True)
    return opened
