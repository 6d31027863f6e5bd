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
from collections import Counter, deque
from dataclasses import dataclass
from typing import Literal, Self, get_args

import numpy as np

from khepera_forage.robots.serial.protocol import LineSplitter, Protocol, ProtocolError, Reply, seconds_on_wire
from khepera_forage.robots.virtual.firmware import Firmware

_CHUNK = 4096
_PIECE_DURATION = 0.002
"""Seconds of a reply that are written at once: the system cannot wake a thread for every byte."""
Fault = Literal["drop", "delay", "garble", "duplicate", "reset", "unplug"]
FAULTS: tuple[Fault, ...] = get_args(Fault)
_MAX_GARBLED_BYTES = 3
"""Assumption."""


@dataclass(frozen=True, slots=True)
class Faults:
    """Rates of the faults of a line, as shares of all replies; a reply has at most one fault.

    Attributes:
        drop: Lost, with equal probability the request, which the robot then does not execute, or the reply.
        delay: Late by `lateness`; later replies wait behind it, as in the buffers of a radio link.
        garble: One to three bytes changed, deleted or inserted.
        duplicate: Sent twice.
        reset: The power supply fails: wheels stop, settings are lost, the banner replaces the reply or cuts it off.
        unplug: The cable is unplugged for good. It also carries the power supply (assumption), so the wheels stop.
        lateness: Seconds by which a delayed reply is late, uniform between the two: choose more than the host's
            timeout, so that the reply arrives after the host has repeated its request.

    Raises:
        ValueError: A rate outside 0..1, rates that add up to more than 1, or an invalid lateness.
    """

    drop: float = 0.0
    delay: float = 0.0
    garble: float = 0.0
    duplicate: float = 0.0
    reset: float = 0.0
    unplug: float = 0.0
    lateness: tuple[float, float] = (0.3, 1.0)

    def __post_init__(self) -> None:
        for fault in FAULTS:
            rate = getattr(self, fault)
            if not 0 <= rate <= 1:
                raise ValueError(f"rate of fault {fault} is {rate!r}; allowed: 0..1")
        total = sum(getattr(self, fault) for fault in FAULTS)
        if total > 1 + 1e-9:
            raise ValueError(f"rates of faults add up to {total:g}; allowed: at most 1")
        shortest, longest = self.lateness
        if not 0 <= shortest <= longest < float("inf"):
            raise ValueError(f"lateness is {self.lateness!r}; allowed: two times in seconds, the shorter first")

    def draw(self, rng: np.random.Generator) -> Fault | None:
        """The fault of the next reply, or None."""
        drawn = rng.random() if any(getattr(self, fault) for fault in FAULTS) else 1.0
        for fault in FAULTS:
            drawn -= getattr(self, fault)
            if drawn < 0:
                return fault
        return None


class VirtualKhepera:
    """Serves a firmware on a pseudo-terminal or a TCP port, in its own thread, until closed.

    Requests are executed one after the other. A late reply delays the ones behind it, as on a line with a buffer, but
    not the execution of requests. Bytes take as long as on a real line in both directions: a request is
    executed when its last byte would have arrived, and its reply is written no faster than the baud rate.

    Do not hold the firmware's lock while closing: the thread may be waiting for it.

    Args:
        firmware: Executes the requests.
        tcp: Port on 127.0.0.1, 0 for any; a pseudo-terminal by default.
        baud: Speed of the line; None is as fast as possible.
        faults: Rates of the faults; none by default.
        rng: Draws the faults; one with a constant seed by default.

    Attributes:
        faults: Rates of the faults, which may be set at any time.
        fault_counts: How often each fault has occurred, by name; the number of all `replies`, with or without a fault;
            and of garbled ones that are `undetectable`.
        url: Argument of `serial.serial_for_url`: "/dev/pts/5" or "socket://127.0.0.1:40123".
        interrupted: Whether all bytes are lost, in both directions, while the robot keeps its power supply and its last
            command: a broken data wire, or a radio link out of range. May be set at any time.

    Raises:
        ValueError: A baud rate that the robot does not support.
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
        self._firmware, self._rng = firmware, np.random.default_rng(0) if rng is None else rng
        self.faults = Faults() if faults is None else faults
        self.fault_counts: Counter[str] = Counter()
        self._end = _End(tcp)
        self.url = self._end.url
        self.interrupted = False
        self._splitter = LineSplitter()
        self._requests: deque[tuple[float, bytes]] = deque()
        self._replies: deque[tuple[float, bytes]] = deque()
        """Pieces of replies, with the times at which they are due."""
        self._received_until = self._sent_until = 0.0
        self._closing = False
        self._wake_reader, self._wake_writer = os.pipe()
        self._thread = threading.Thread(target=self._serve, name=f"khepera {self.url}", daemon=True)
        self._thread.start()

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
                if self._replies and self._replies[0][0] <= now:
                    data = self._replies.popleft()[1]
                    if not self.interrupted:
                        self._end.write(data)
                elif self._requests and self._requests[0][0] <= now:
                    if not self._execute(self._requests.popleft()[1]):
                        break
                else:
                    dues = [queue[0][0] for queue in (self._requests, self._replies) if queue]
                    self._listen(min(dues) - now if dues else None)
        finally:
            self._end.close()

    def _execute(self, line: bytes) -> bool:
        """Execute a request, with a fault if one is drawn; returns whether the line still works."""
        faults, rng, counts, firmware = self.faults, self._rng, self.fault_counts, self._firmware
        fault = faults.draw(rng)
        counts["replies"] += 1
        if fault is None:
            self._reply(firmware.handle(line))
            return True
        counts[fault] += 1
        if fault == "unplug":
            firmware.power_on()
            return False
        is_lost = fault in ("drop", "reset") and rng.random() < 0.5
        reply = b"" if is_lost else firmware.handle(line)
        if fault == "reset":
            cut_off = reply[: int(rng.integers(1, len(reply)))] if reply else b""
            self._reply(cut_off + firmware.power_on())
        elif fault == "garble":
            data = garbled(reply, rng)
            counts["undetectable"] += is_undetectable(data, reply, firmware.protocol)
            self._reply(data)
        elif fault == "duplicate":
            self._reply(reply + reply)
        elif fault == "delay":
            self._reply(reply, float(rng.uniform(*faults.lateness)))
        return True

    def _reply(self, data: bytes, lateness: float = 0.0) -> None:
        """Queue a reply at the speed of the line. Later ones wait behind it, but requests are executed meanwhile."""
        piece = max(1, round(_PIECE_DURATION / self._byte_time) if self._byte_time else len(data))
        due = max(self._sent_until, time.monotonic() + lateness)
        for i in range(0, len(data), piece):
            self._replies.append((due + min(i + piece, len(data)) * self._byte_time, data[i : i + piece]))
        self._sent_until = due + len(data) * self._byte_time

    def _listen(self, timeout: float | None) -> None:
        """Receive bytes, and compute when each request would have arrived over a real line."""
        ready, _, _ = select.select([self._wake_reader, *self._end.filenos()], [], [], timeout)
        if not ready or self._closing:
            return
        self._received_until = max(self._received_until, time.monotonic())
        received = self._end.read(ready)
        for byte in b"" if self.interrupted else received:
            self._received_until += self._byte_time
            lines = self._splitter.feed(bytes((byte,)))
            self._requests += ((self._received_until, line) for line in lines)


def garbled(reply: bytes, rng: np.random.Generator) -> bytes:
    """A reply with one to three bytes changed, deleted or inserted."""
    data = bytearray(reply)
    kind = rng.integers(3)
    for _ in range(rng.integers(1, _MAX_GARBLED_BYTES + 1)):
        place = int(rng.integers(len(data)))
        if kind == 0:
            data[place] ^= int(rng.integers(1, 256))
        elif kind == 1 and len(data) > 1:
            del data[place]
        else:
            data.insert(place, int(rng.integers(256)))
    return bytes(data)


def is_undetectable(data: bytes, reply: bytes, protocol: Protocol) -> bool:
    """Whether a garbled reply decodes to another reply to the same command: the protocol has no checksum."""
    original = protocol.decode_reply(reply.partition(b"\n")[0])  # the banner, and a version, have further lines
    for line in LineSplitter().feed(data):
        with contextlib.suppress(ProtocolError):
            decoded = protocol.decode_reply(line)
            if isinstance(decoded, Reply) and isinstance(original, Reply):
                return decoded.command == original.command and decoded != original
    return False


class _End:
    """The robot's end of the line: a pseudo-terminal without echo or translation, or a TCP port of this machine.

    The host's end of the terminal stays open here, too, so that it can reconnect. A TCP port has one host at a time: a
    second connection is closed at once.
    """

    def __init__(self, tcp: int | None) -> None:
        self._listener: socket.socket | None = None
        self._host: int | None = None
        self._terminal: int | None = None
        if tcp is not None:
            self._listener = socket.create_server(("127.0.0.1", tcp))
            self._listener.setblocking(False)
            self.url = f"socket://127.0.0.1:{self._listener.getsockname()[1]}"
            return
        try:
            import pty
            import tty
        except ImportError:  # systems without pseudo-terminals can still use a TCP port
            raise OSError(
                "a virtual robot's serial port is a pseudo-terminal, which this system does not have; allowed: Linux, "
                "macOS, or Windows Subsystem for Linux"
            ) from None
        self._host, self._terminal = pty.openpty()
        tty.setraw(self._terminal)
        os.set_blocking(self._host, False)
        self.url = os.ttyname(self._terminal)

    def filenos(self) -> list[int]:
        """Descriptors to wait for."""
        listener = [] if self._listener is None else [self._listener.fileno()]
        return listener if self._host is None else [self._host, *listener]

    def read(self, ready: list[int]) -> bytes:
        """The bytes that have arrived at descriptors; also accepts a new host after the last one has disconnected."""
        data = b""
        if self._host is not None and self._host in ready:
            with contextlib.suppress(OSError):
                data = os.read(self._host, _CHUNK)
            if not data:
                self._disconnect()
        if self._listener is not None and self._listener.fileno() in ready:
            with contextlib.suppress(OSError):  # it has gone
                host, _ = self._listener.accept()
                if self._host is None:
                    host.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                    host.setblocking(False)
                    self._host = host.detach()
                else:
                    host.close()
        return data

    def write(self, data: bytes) -> None:
        """Send bytes; those that exceed the buffer are lost."""
        if self._host is not None:
            try:
                os.write(self._host, data)
            except BlockingIOError:
                pass
            except (BrokenPipeError, ConnectionResetError):
                self._disconnect()

    def close(self) -> None:
        self._disconnect()
        if self._terminal is not None:
            os.close(self._terminal)
        if self._listener is not None:
            self._listener.close()

    def _disconnect(self) -> None:
        if self._host is not None:
            os.close(self._host)
            self._host = None
