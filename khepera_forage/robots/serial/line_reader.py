"""A serial line as requests written and replies read: what is garbage and what is a restart banner is told here."""

import time
from collections import deque
from collections.abc import Callable

from khepera_forage.robots.serial.line_events import LineCounts, Restarted, Traffic, is_of_banner
from khepera_forage.robots.serial.port import open_port
from khepera_forage.robots.serial.protocol import (
    BannerLine,
    CodecError,
    Lines,
    Refusal,
    Reply,
    Request,
    decode_reply,
    encode_request,
)

_QUIET = 0.06
"""Seconds without a byte after which a restart banner is over."""
_LONGEST_BANNER = 3.0
"""Seconds: 17 lines (KNET) take one at 9600 baud."""
_LINE_ENDS = b"\r\n"


class Wire:
    """A port, and the lines that come from it.

    Args:
        port: What `serial.serial_for_url` takes.
        baud: 9600, 19200, 38400, 57600 or 115200.

    Attributes:
        counts: What happened so far.
        traffic: Handed all bytes that pass.
        mid_line: Whether the last byte that came did not end a line.

    Raises:
        ValueError, ConnectionError, ImportError: See `open_port`. All methods raise `OSError` when the line is gone.
    """

    def __init__(self, port: str, baud: int) -> None:
        self.counts = LineCounts()
        self.traffic: Callable[[Traffic], None] | None = None
        self.mid_line = False
        self._serial = open_port(port, baud)
        self._lines = Lines()
        self._arrived: deque[bytes] = deque()

    def close(self) -> None:
        """Close the port; a second call does nothing."""
        self._serial.close()

    def write(self, request: Request) -> bytes:
        """Send a request; returns its bytes."""
        data = encode_request(request)
        self.counts.sent += 1
        if self.traffic is not None:
            self.traffic(Traffic(True, data))
        self._serial.write(data)
        return data

    def drain(self) -> None:
        """Take what came unasked, or late: none of it can be the answer to what is sent next.

        Raises:
            Restarted: The banner was among it.
        """
        while waiting := self._serial.in_waiting:
            self._read(waiting)
        while self._arrived:
            if self._decoded(self._arrived.popleft()) is not None:
                self.counts.foreign += 1

    def line(self) -> tuple[bytes, Reply | Refusal | None] | None:
        """The next line and what it says, which is nothing if it is garbled; None if none came within `POLL`.

        Raises:
            Restarted: It was a line of the banner.
        """
        if not self._arrived:
            self._read(1)
        if not self._arrived:
            return None
        line = self._arrived.popleft()
        return line, self._decoded(line)

    def _decoded(self, line: bytes) -> Reply | Refusal | None:
        try:
            answer = decode_reply(line)
        except CodecError:
            answer = None
        if isinstance(answer, BannerLine):
            if is_of_banner(answer.text):
                self._sit_out_banner()
                raise Restarted
            answer = None
        if answer is None:
            self.counts.garbled += 1
        return answer

    def _sit_out_banner(self) -> None:
        """Read until the robot has said all of its banner; requests before that would be lost, or cut into it."""
        self.counts.restarts += 1
        end = time.monotonic() + _LONGEST_BANNER
        quiet = time.monotonic() + _QUIET
        while time.monotonic() < min(quiet, end):
            if self._read(1):
                quiet = time.monotonic() + _QUIET
        self._arrived.clear()

    def _read(self, size: int) -> bytes:
        """Read what has arrived: up to `size` bytes, waited for, and all that came with them."""
        data = self._serial.read(size)
        if data and (more := self._serial.in_waiting):
            data += self._serial.read(more)
        if data:
            if self.traffic is not None:
                self.traffic(Traffic(False, data))
            self._arrived.extend(self._lines.feed(data))
            self.mid_line = data[-1] not in _LINE_ENDS
        return data
