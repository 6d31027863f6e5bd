"""A virtual Khepera: firmware behind a port that any program can open, at the speed of a serial line.

The port is a pseudo-terminal, or a TCP port of this machine. Writing never waits for a host that does not read: bytes
that exceed the buffer are lost, as on a line without flow control.
"""

import contextlib
import os
import select
import socket
import threading
import time
from collections import deque
from dataclasses import replace
from typing import Self

import numpy as np

from khepera_forage.robots.serial.protocol import LineSplitter, seconds_on_wire
from khepera_forage.robots.virtual.faults import FaultCounts, Faults, garbled, is_undetectable
from khepera_forage.robots.virtual.firmware import Firmware

_CHUNK = 4096
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
        faults: Rates of the faults, which may be set at any time; none by default.
        rng: Draws the faults.

    Attributes:
        url: Argument of `serial.serial_for_url`: "/dev/pts/5" or "socket://127.0.0.1:40123".
        interrupted: Whether all bytes are lost, in both directions, while the robot keeps its power supply and its last
            command: a broken data wire, or a radio link out of range. May be set at any time.

    Raises:
        ValueError: A baud rate that a Khepera does not support, or faults without `rng`.
        OSError: The TCP port is in use, or the system has no pseudo-terminals.
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
        self._byte_time = 0.0 if baud is None else seconds_on_wire(1, baud, protocol.stop_bits)
        self._firmware, self._rng = firmware, rng
        self.faults = Faults() if faults is None else faults
        self._counts = FaultCounts()
        self._end = _Pty() if tcp is None else _TcpPort(tcp)
        self.url = self._end.url
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
        """Rates of the faults; may be set at any time, if there is an `rng`."""
        return self._faults

    @faults.setter
    def faults(self, faults: Faults) -> None:
        if faults.total and self._rng is None:
            raise ValueError("faults without a random generator; allowed: rng=numpy.random.default_rng(seed)")
        self._faults = faults

    @property
    def fault_counts(self) -> FaultCounts:
        """Numbers of requests and faults so far."""
        return replace(self._counts)

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

    def __exit__(self, *_: object) -> None:
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
            self._end.close()

    def _execute(self, line: bytes) -> bool:
        """Execute a request, with a fault if one is drawn; returns whether the line still works."""
        faults, rng, counts, firmware = self._faults, self._rng, self._counts, self._firmware
        fault = None if rng is None else faults.draw(rng)
        counts.replies += 1
        if fault is None or rng is None:
            self._reply(firmware.handle(line))
            return True
        setattr(counts, fault, getattr(counts, fault) + 1)
        if fault == "unplug":
            firmware.power_on()
            return False
        if fault == "reset":
            cut_off = b""
            if rng.random() >= 0.5:
                reply = firmware.handle(line)
                cut_off = reply[: int(rng.integers(1, len(reply)))]
            self._reply(cut_off + firmware.power_on())
            return True
        if fault == "drop" and rng.random() < 0.5:
            return True
        reply = firmware.handle(line)
        if fault == "garble":
            data = garbled(reply, rng)
            counts.undetectable += is_undetectable(data, reply, firmware.protocol)
            self._reply(data)
        elif fault == "duplicate":
            self._reply(reply + reply)
        elif fault == "delay":
            self._reply(reply, float(rng.uniform(*faults.lateness)))
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
            due = begin + (sent + len(chunk)) * self._byte_time
            while not self._closing and (left := due - time.monotonic()) > 0:
                self._listen(left)
            if self._closing:
                return
            self._write(chunk)
        self._sent_until = begin + len(reply) * self._byte_time

    def _write(self, data: bytes) -> None:
        if not self.interrupted:
            self._end.write(data)

    def _listen(self, timeout: float | None) -> None:
        """Receive bytes, and compute when each request would have arrived over a real line."""
        ready, _, _ = select.select([self._wake_reader, *self._end.filenos()], [], [], timeout)
        if not ready or self._closing:
            return
        self._received_until = max(self._received_until, time.monotonic())
        received = self._end.read()
        if self.interrupted:
            return
        for byte in received:
            self._received_until += self._byte_time
            lines = self._splitter.feed(bytes((byte,)))
            self._requests += ((line, self._received_until) for line in lines)


class _Pty:
    """A pseudo-terminal without echo or translation. The host's end also stays open here, so that it can reconnect."""

    def __init__(self) -> None:
        try:
            import pty
            import tty
        except ImportError:  # systems without pseudo-terminals can still use `_TcpPort`
            raise OSError(
                "a virtual robot's serial port is a pseudo-terminal, which this system does not have; allowed: Linux, "
                "macOS, or Windows Subsystem for Linux"
            ) from None
        self._master, self._slave = pty.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self.url = os.ttyname(self._slave)

    def filenos(self) -> list[int]:
        """Descriptors that become readable when `read` has bytes to return."""
        return [self._master]

    def read(self) -> bytes:
        with contextlib.suppress(BlockingIOError):
            return os.read(self._master, _CHUNK)
        return b""

    def write(self, data: bytes) -> None:
        with contextlib.suppress(BlockingIOError):
            os.write(self._master, data)

    def close(self) -> None:
        os.close(self._master)
        os.close(self._slave)


class _TcpPort:
    """A TCP port on 127.0.0.1 for one host at a time; a second connection is closed at once."""

    def __init__(self, port: int) -> None:
        self._listener = socket.create_server(("127.0.0.1", port))
        self._listener.setblocking(False)
        self._host: socket.socket | None = None
        self.url = f"socket://127.0.0.1:{self._listener.getsockname()[1]}"

    def filenos(self) -> list[int]:
        return [end.fileno() for end in (self._host, self._listener) if end is not None]

    def read(self) -> bytes:
        """The bytes that have arrived; also accepts a new host after the last one has disconnected."""
        data = b""
        if self._host is not None:
            try:
                data = self._host.recv(_CHUNK)
            except BlockingIOError:
                pass
            except OSError:
                self._disconnect()
            else:
                if not data:
                    self._disconnect()
        with contextlib.suppress(BlockingIOError):
            host, _ = self._listener.accept()
            if self._host is not None:
                host.close()
            else:
                host.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                host.setblocking(False)
                self._host = host
        return data

    def write(self, data: bytes) -> None:
        if self._host is not None:
            try:
                self._host.send(data)
            except BlockingIOError:
                pass
            except (BrokenPipeError, ConnectionResetError):
                self._disconnect()

    def close(self) -> None:
        self._disconnect()
        self._listener.close()

    def _disconnect(self) -> None:
        if self._host is not None:
            self._host.close()
            self._host = None
