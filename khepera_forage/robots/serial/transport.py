"""The transport: requests to a serial port, and replies from it.

Discards garbled lines and recognises the restart banner.
"""

import time
from collections import deque
from collections.abc import Callable
from contextlib import suppress

from khepera_forage.robots.serial.errors import RobotRestarted
from khepera_forage.robots.serial.framing import LineSplitter
from khepera_forage.robots.serial.port import descriptor_of, open_port
from khepera_forage.robots.serial.protocol import (
    ErrorReply,
    ProtocolError,
    Reply,
    Request,
    TextLine,
    decode_reply,
    encode_request,
    is_banner,
)
from khepera_forage.robots.serial.traffic import LineStatistics, Traffic

_BANNER_GAP = 0.06
"""Seconds without a byte that mark the end of a restart banner."""
_MAX_BANNER_DURATION = 3.0
"""Seconds: 17 lines (KNET) take one at 9600 baud."""
_LINE_ENDS = b"\r\n"


class Transport:
    """Sends requests over a serial port and receives lines from it.

    Args:
        port: Any argument of `serial.serial_for_url`.
        baud: 9600, 19200, 38400, 57600 or 115200.
        write_timeout: As for `open_port`.

    Attributes:
        statistics: Counts of events so far.
        on_traffic: Called with all bytes that are sent or received.
        mid_line: Whether the last received byte did not end a line.

    Raises:
        ValueError, ConnectionError, ImportError: See `open_port`. All methods raise `OSError` when the port fails.
    """

    def __init__(self, port: str, baud: int, write_timeout: float) -> None:
        self.statistics = LineStatistics()
        self.on_traffic: Callable[[Traffic], None] | None = None
        self.mid_line = False
        self._serial = open_port(port, baud, write_timeout)
        self._splitter = LineSplitter()
        self._lines: deque[bytes] = deque()

    @property
    def descriptor(self) -> int | None:
        """File descriptor of the open port, if it has one."""
        return descriptor_of(self._serial)

    def close(self) -> None:
        """Close the port; a second call does nothing."""
        self._serial.close()

    def send(self, *requests: Request) -> bytes:
        """Send requests; returns their bytes.

        A port that is blocked, or a process that is not scheduled, for longer than the port's time limit loses a
        request like a disturbed line does: without its reply, it is sent again.
        """
        from serial import SerialTimeoutException

        data = b"".join(map(encode_request, requests))
        self.statistics.sent += len(requests)
        if self.on_traffic is not None:
            self.on_traffic(Traffic(True, data))
        with suppress(SerialTimeoutException):
            self._serial.write(data)
        return data

    def discard_input(self) -> None:
        """Discard all received bytes: none of them can be the reply to the next request.

        Raises:
            RobotRestarted: They contain the banner.
        """
        while waiting := self._serial.in_waiting:
            self._read(waiting)
        while self._lines:
            if self._decode(self._lines.popleft()) is not None:
                self.statistics.unmatched += 1

    def receive_line(self) -> tuple[bytes, Reply | ErrorReply | None] | None:
        """The next line with its reply, which is None if garbled; None without a line within `POLL` seconds.

        Raises:
            RobotRestarted: The line belongs to the banner.
        """
        if not self._lines:
            self._read(1)
        if not self._lines:
            return None
        line = self._lines.popleft()
        return line, self._decode(line)

    def _decode(self, line: bytes) -> Reply | ErrorReply | None:
        try:
            reply = decode_reply(line)
        except ProtocolError:
            reply = None
        if isinstance(reply, TextLine):
            if is_banner(reply):
                self._discard_banner()
                raise RobotRestarted
            reply = None
        if reply is None:
            self.statistics.garbled += 1
        return reply

    def _discard_banner(self) -> None:
        """Read to the end of the banner; the robot would lose a request sent before, or mix its reply with it."""
        self.statistics.restarts += 1
        end = time.monotonic() + _MAX_BANNER_DURATION
        gap_end = time.monotonic() + _BANNER_GAP
        while time.monotonic() < min(gap_end, end):
            if self._read(1):
                gap_end = time.monotonic() + _BANNER_GAP
        self._lines.clear()

    def _read(self, size: int) -> bytes:
        """Wait for up to `size` bytes, then read all that have arrived."""
        data = self._arrived(size)
        if data and (more := self._serial.in_waiting):
            data += self._arrived(more)
        if data:
            if self.on_traffic is not None:
                self.on_traffic(Traffic(False, data))
            self._lines.extend(self._splitter.feed(data))
            self.mid_line = data[-1] not in _LINE_ENDS
        return data

    def _arrived(self, size: int) -> bytes:
        """Up to `size` bytes.

        A watchdog that has stopped the robot of a frozen driver may have read bytes that were announced to this
        process. pyserial takes that for a disconnected port; a second attempt tells one from the other.
        """
        try:
            data: bytes = self._serial.read(size)
        except OSError:
            data = self._serial.read(size)
        return data
