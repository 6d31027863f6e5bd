"""A virtual Khepera: firmware behind a port that any program can open, at the speed of a serial line."""

import os
import select
import threading
import time
from collections import deque
from types import TracebackType
from typing import Self

import numpy as np

from khepera_forage.robots.serial.protocol import LineSplitter, seconds_on_wire
from khepera_forage.robots.virtual.endpoints import Endpoint, PtyEndpoint, TcpEndpoint
from khepera_forage.robots.virtual.faults import Fault, FaultCounts, FaultInjector, Faults
from khepera_forage.robots.virtual.firmware import Firmware

_CHUNK_DURATION = 0.002
"""Seconds of a reply that are written at once: the system cannot wake a thread for every byte."""


class VirtualKhepera:
    """Serves a firmware on a pseudo-terminal or a TCP port, in its own thread, until closed.

    Requests are executed one after the other. A late reply delays the ones behind it, as on a line with a buffer, but
    not the execution of requests. Bytes take as long as on a real line in both directions: a request is
    executed when its last byte would have arrived, and its reply is written no faster than the baud rate. The baud rate
    of the host's end is ignored: a pseudo-terminal has none.

    Do not hold the firmware's lock while closing: the thread may be waiting for it.

    Args:
        firmware: Executes the requests.
        tcp: Port on 127.0.0.1, 0 for any; a pseudo-terminal by default.
        baud: Speed of the line; None is as fast as possible.
        faults: Rates of the faults; none by default.
        rng: Draws the faults.

    Raises:
        ValueError: A baud rate that a Khepera does not support, or faults without `rng`.
        OSError: The TCP port is in use.

    Attributes:
        url: Argument of `serial.serial_for_url`: "/dev/pts/5" or "socket://127.0.0.1:40123".
        interrupted: Whether all bytes are lost, in both directions, while the robot keeps its power supply and its last
            command: a broken data wire, or a radio link out of range. May be set at any time.
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
        protocol = firmware.protocol
        if baud is not None and baud not in protocol.baud_rates:
            allowed = ", ".join(map(str, protocol.baud_rates))
            raise ValueError(f"baud is {baud!r}; allowed: {allowed}, or None for unlimited speed")
        self._injector = FaultInjector(protocol, faults, rng)
        self._byte_time = 0.0 if baud is None else seconds_on_wire(1, baud, protocol.stop_bits)
        self._firmware = firmware
        self._endpoint: Endpoint = PtyEndpoint() if tcp is None else TcpEndpoint(tcp)
        self.url = self._endpoint.url
        self.interrupted = False
        self._splitter = LineSplitter()
        self._requests: deque[tuple[bytes, float]] = deque()
        self._replies: deque[tuple[bytes, float]] = deque()
        """With the times at which they are due."""
        self._received_until = self._sent_until = 0.0
        self._closing = False
        self._wake_reader, self._wake_writer = os.pipe()
        self._thread = threading.Thread(target=self._serve, name=f"khepera {self.url}", daemon=True)
        self._thread.start()

    @property
    def faults(self) -> Faults:
        """Rates of the faults; may be set at any time.

        Raises:
            ValueError: Faults were set without `rng`.
        """
        return self._injector.rates

    @faults.setter
    def faults(self, faults: Faults) -> None:
        self._injector.rates = faults

    @property
    def fault_counts(self) -> FaultCounts:
        """Numbers of requests and faults so far."""
        return self._injector.counts

    @property
    def connected(self) -> bool:
        """Whether the line works: neither closed nor unplugged."""
        return self._thread.is_alive()

    def close(self) -> None:
        """Disconnect the host and wait for the thread; the robot keeps its last command. A second call does nothing."""
        if self._closing:
            return
        self._closing = True
        os.write(self._wake_writer, b"x")
        self._thread.join()
        os.close(self._wake_writer)
        os.close(self._wake_reader)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _serve(self) -> None:
        try:
            while not self._closing:
                now = time.monotonic()
                if self._replies and self._replies[0][1] <= now:
                    self._send(self._replies.popleft()[0])
                elif self._requests and self._requests[0][1] <= now:
                    if not self._execute(self._requests.popleft()[0]):
                        break
                else:
                    dues = [queue[0][1] for queue in (self._requests, self._replies) if queue]
                    self._listen(min(dues) - now if dues else None)
        finally:
            self._endpoint.close()

    def _execute(self, line: bytes) -> bool:
        """Execute a request, with a fault if one is drawn; returns whether the line still works."""
        injector = self._injector
        fault: Fault | None = injector.draw()
        if fault == "unplug":
            self._firmware.power_on()
            return False
        if fault == "reset":
            cut_off = b"" if injector.coin_toss() else injector.truncate(self._firmware.handle(line))
            self._reply(cut_off + self._firmware.power_on())
            return True
        if fault == "drop" and injector.coin_toss():
            return True
        reply = self._firmware.handle(line)
        if fault == "garble":
            self._reply(injector.garble(reply))
        elif fault == "duplicate":
            self._reply(reply + reply)
        elif fault == "delay":
            self._reply(reply, injector.lateness())
        elif fault is None:
            self._reply(reply)
        return True

    def _reply(self, data: bytes, lateness: float = 0.0) -> None:
        """Queue a reply. Later ones wait behind it, but requests are executed meanwhile."""
        last = self._replies[-1][1] if self._replies else 0.0
        self._replies.append((data, max(last, time.monotonic() + lateness)))

    def _send(self, reply: bytes) -> None:
        """Write a reply at the speed of the line."""
        if not self._byte_time:
            self._write(reply)
            return
        # Wait for times relative to the beginning of the reply, so that late wake-ups do not add up.
        begin = max(time.monotonic(), self._sent_until)
        chunk_size = max(1, round(_CHUNK_DURATION / self._byte_time))
        for sent in range(0, len(reply), chunk_size):
            chunk = reply[sent : sent + chunk_size]
            self._wait_until(begin + (sent + len(chunk)) * self._byte_time)
            if self._closing:
                return
            self._write(chunk)
        self._sent_until = begin + len(reply) * self._byte_time

    def _write(self, data: bytes) -> None:
        if not self.interrupted:
            self._endpoint.write(data)

    def _wait_until(self, due: float) -> None:
        """Keep receiving until a time."""
        while not self._closing and (left := due - time.monotonic()) > 0:
            self._listen(left)

    def _listen(self, timeout: float | None) -> None:
        """Receive bytes, and compute when each request would have arrived over a real line."""
        ready, _, _ = select.select([self._wake_reader, *self._endpoint.filenos()], [], [], timeout)
        if not ready or self._closing:
            return
        self._received_until = max(self._received_until, time.monotonic())
        received = self._endpoint.read()
        if self.interrupted:
            return
        for byte in received:
            self._received_until += self._byte_time
            lines = self._splitter.feed(bytes((byte,)))
            self._requests += ((line, self._received_until) for line in lines)
