"""A virtual Khepera: its firmware behind a line that any program can open as a serial port, at a serial line's pace."""

import os
import select
import threading
import time
from collections import deque
from types import TracebackType
from typing import Self

import numpy as np

from khepera_forage.robots.serial.port import BAUDS, seconds_on_wire
from khepera_forage.robots.serial.protocol import Lines
from khepera_forage.robots.virtual.firmware import Firmware
from khepera_forage.robots.virtual.line_faults import Fault, FaultCounts, Faults, FaultSource
from khepera_forage.robots.virtual.virtual_line import PtyLine, TcpLine, VirtualLine

_BURST = 0.002
"""Seconds of a reply that are written at once: the system cannot wake a thread for every byte."""


class VirtualKhepera:
    """Serves a firmware on a pseudo-terminal or a TCP port, in a thread of its own, until closed.

    Requests are answered one after the other. Bytes take their time in both directions: a request is carried out when
    its last byte would have come over a real line, and its reply is written no faster than such a line would carry it.
    The baud of the host's end is not looked at: a pseudo-terminal has none.

    To be closed without holding the firmware's lock: the thread may be waiting for it.

    Args:
        firmware: What answers.
        tcp: Port on 127.0.0.1, 0 for any; without it a pseudo-terminal is used.
        baud: Pace of the line; None is as fast as it goes.
        faults: What goes wrong how often; nothing by default.
        rng: For the faults.

    Raises:
        ValueError: A baud that a Khepera does not have, or faults without `rng`.
        OSError: The TCP port is taken.

    Attributes:
        url: What `serial.serial_for_url` takes: "/dev/pts/5" or "socket://127.0.0.1:40123".
    """

    def __init__(
        self,
        firmware: Firmware,
        *,
        tcp: int | None = None,
        baud: int | None = 38400,
        faults: Faults | None = None,
        rng: np.random.Generator | None = None,
    ) -> None:
        if baud is not None and baud not in BAUDS:
            raise ValueError(f"baud is {baud!r}; allowed: {', '.join(map(str, BAUDS))}, or None for no pace")
        self._source = FaultSource(faults, rng)
        self._byte_time = 0.0 if baud is None else seconds_on_wire(1, baud)
        self._firmware = firmware
        self._line: VirtualLine = PtyLine() if tcp is None else TcpLine(tcp)
        self.url = self._line.url
        self._lines = Lines()
        self._heard: deque[tuple[bytes, float]] = deque()
        self._heard_until = self._said_until = 0.0
        self._closing = False
        self._waking, self._wake = os.pipe()
        self._thread = threading.Thread(target=self._serve, name=f"khepera {self.url}", daemon=True)
        self._thread.start()

    @property
    def faults(self) -> Faults:
        """What goes wrong how often; may be set at any time.

        Raises:
            ValueError: When set to some, and there is no `rng`.
        """
        return self._source.rates

    @faults.setter
    def faults(self, faults: Faults) -> None:
        self._source.rates = faults

    @property
    def counts(self) -> FaultCounts:
        """What has gone wrong so far, and how many requests came."""
        return self._source.counts

    @property
    def plugged(self) -> bool:
        """Whether the line is still there: neither closed nor unplugged."""
        return self._thread.is_alive()

    def close(self) -> None:
        """Cut the line and wait for the thread; the robot is left as it is. A second call does nothing."""
        if self._closing:
            return
        self._closing = True
        os.write(self._wake, b"x")
        self._thread.join()
        os.close(self._wake)
        os.close(self._waking)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _serve(self) -> None:
        try:
            while not self._closing:
                if not self._heard:
                    self._listen(None)
                    continue
                line, due = self._heard.popleft()
                self._wait_until(due)
                if not self._closing and not self._answer(line):
                    break
        finally:
            self._line.close()

    def _answer(self, line: bytes) -> bool:
        """Carry out a request; returns whether the line is still there."""
        source = self._source
        fault: Fault | None = source.next()
        if fault == "unplug":
            self._firmware.power_on()
            return False
        if fault == "reset":
            begun = b"" if source.either() else source.cut(self._firmware.answer(line))
            self._say(begun + self._firmware.power_on())
            return True
        if fault == "drop" and source.either():
            return True
        reply = self._firmware.answer(line)
        if fault == "garble":
            self._say(source.garble(reply))
        elif fault == "duplicate":
            self._say(reply + reply)
        elif fault == "delay":
            self._wait_until(time.monotonic() + source.lateness())
            self._say(reply)
        elif fault is None:
            self._say(reply)
        return True

    def _say(self, reply: bytes) -> None:
        """Write a reply at the line's pace."""
        if not self._byte_time:
            self._line.write(reply)
            return
        # Every wait is for a time reckoned from the reply's beginning, so that late wake-ups do not add up.
        begin = max(time.monotonic(), self._said_until)
        burst = max(1, round(_BURST / self._byte_time))
        for sent in range(0, len(reply), burst):
            piece = reply[sent : sent + burst]
            self._wait_until(begin + (sent + len(piece)) * self._byte_time)
            if self._closing:
                return
            self._line.write(piece)
        self._said_until = begin + len(reply) * self._byte_time

    def _wait_until(self, due: float) -> None:
        """Let time pass, and go on listening."""
        while not self._closing and (left := due - time.monotonic()) > 0:
            self._listen(left)

    def _listen(self, seconds: float | None) -> None:
        """Take what comes within a time, and reckon when each request would have come over a real line."""
        ready, _, _ = select.select([self._waking, *self._line.filenos()], [], [], seconds)
        if not ready or self._closing:
            return
        self._heard_until = max(self._heard_until, time.monotonic())
        for byte in self._line.read():
            self._heard_until += self._byte_time
            self._heard += ((line, self._heard_until) for line in self._lines.feed(bytes((byte,))))
