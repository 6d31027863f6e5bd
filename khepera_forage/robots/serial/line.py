"""A serial line: requests to a robot, and their replies.

The protocol has neither sequence numbers nor checksums. A reply is matched to its request by its letter, and by the
order in which the robot replies. Requests are *pipelined*, sent without waiting for each reply, so that the latency of
the line counts once for all of them; PYRO controls real Kheperas in this way. Whatever remains without a reply is sent
again, behind a *query* (command E, or another one) if a reply to the same command may still arrive, late or repeated:
once the query is answered, no older reply can follow.

Undetectable here: a digit changed into another one in transmission, and replies out of order, which do not occur on a
serial line.

Requires pyserial, the extra `robots`; it is imported when a port is opened, not before.
"""

import contextlib
import math
import socket
import statistics
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from time import monotonic
from typing import TYPE_CHECKING, NamedTuple, NoReturn

from khepera_forage.extras import require
from khepera_forage.robots.khepera import RobotLost
from khepera_forage.robots.serial.line_timing import LineTiming
from khepera_forage.robots.serial.protocol import (
    RESTART,
    ErrorReply,
    LineSplitter,
    Protocol,
    ProtocolError,
    Reply,
    Request,
    TextLine,
    seconds_on_wire,
)

if TYPE_CHECKING:
    from serial import Serial

POLL = 0.005
"""Seconds after which a read without input returns. Constant: `rfc2217://` negotiates every change with the server."""
DEFAULT_TIMEOUT = 0.1
MAX_TIMEOUT = 10.0
_TRIES = 6
"""The robot counts as lost after so many tries in a row that bring no reply."""
MAX_ADAPTED_TIMEOUT = 0.5
"""Seconds: limit of the timeout that follows from the latency of the line."""
OPENING_TIMEOUT = 1.9
"""Seconds for opening: then the robot counts as lost, or its line as too slow."""
_NOT_REPEATABLE = ("G", RESTART)
"""Setting the counters twice loses the counts in between; a restart has no reply."""
_COST_OF_GARBAGE = 0.25
"""How much a try counts whose reply was garbled: the robot is there."""
_MAX_BACKOFF, _MAX_BACKOFF_OF_STOP = 8, 2
"""Timeouts that a try may last: the wait doubles after each silent try, up to this."""
_MAX_REPLY_LENGTH = 60
"""Bytes: N has up to 43, K and H fewer than 60."""
_WAIT_AFTER_GARBAGE = 0.02
"""Seconds to wait, in addition to the latency of the line, for further replies once a garbled line has arrived."""
_BANNER_GAP, _MAX_BANNER_DURATION = 0.06, 3.0
"""Seconds without a byte that mark the end of a restart banner; its 17 lines (KNET) take one second at 9600 baud."""
_RFC2217 = "rfc2217://"
"""For these, pyserial has a fixed write timeout and rejects any other."""

_MEASURING_TIMEOUT = 1.2
"""Seconds after which no further measurement begins."""
_PATIENCE = 0.6
"""Seconds to wait for a reply before the latency is known: a repeated request would distort the measurement."""


class RobotRestarted(Exception):  # noqa: N818 (an event, not an error)
    """The robot sent its restart banner: its wheels are stopped and its settings are lost."""


class RequestRejected(RobotLost):
    """The robot sends only error replies: it lacks the command, or the turret that the command addresses."""


class Traffic(NamedTuple):
    """Bytes on a line, `sent` or received by the host."""

    sent: bool
    data: bytes


@dataclass(slots=True)
class LineStatistics:
    """Counts of events on a line since it was opened."""

    sent: int = 0
    answered: int = 0
    timeouts: int = 0
    """Tries that left requests without a reply."""
    garbled: int = 0
    """Received lines that are not part of the protocol."""
    unmatched: int = 0
    """Well-formed replies to another request, such as late and repeated ones."""
    rejected: int = 0
    """Error replies (`z,...`)."""
    restarts: int = 0
    unknown: int = 0
    """Readings that contradicted each other, so that the previous one was kept."""


class _Slot:
    """A request of the present exchange, and its reply."""

    def __init__(self, request: Request) -> None:
        self.request, self.command = request, request.command
        self.reply: Reply | None = None


class _Exchange:
    """The state of one exchange: see `Line.exchange`."""

    def __init__(self, slots: Sequence[_Slot], insist: bool, sent_before: int) -> None:
        self.slots, self.insist, self.sent_before = slots, insist, sent_before
        self.failed = self.rejected = 0.0
        """Tries in a row that brought no reply to a request; those of them with an error reply."""
        self.silent = 0.0
        """Tries in a row without a reply to anything."""

    @property
    def missing(self) -> list[_Slot]:
        """The requests without a reply."""
        return [slot for slot in self.slots if slot.reply is None]

    @property
    def backoff(self) -> int:
        """Timeouts to wait for a reply."""
        return min(1 << int(self.silent), _MAX_BACKOFF_OF_STOP if self.insist else _MAX_BACKOFF)


_STALE, _ASIDE = _Slot(Request("")), _Slot(Request(""))
"""Owners of replies that may still arrive: to requests of an earlier exchange, and to those of `send_aside`."""


class Line:
    """Exchanges requests and replies with one robot. Not thread-safe.

    Args:
        port: Any argument of `serial.serial_for_url`: a device, `socket://host:port`, `rfc2217://host:port`.
        protocol: Of the robot.
        baud: One of the protocol's; a `socket://` ignores it.
        timeout: Seconds that a reply may take in addition to the transmission time of the bytes; two, four and eight
            times as many after silence. The port may take as long to accept a request. `measure` may lengthen it.
        replace: Called with each request before it is sent; returns what is sent.
        check: Called again and again during a wait; may raise an exception to end it.

    Attributes:
        deadline: Moment on the monotonic clock `now` after which the robot counts as lost.
        on_traffic: Called with all bytes that are sent or received.

    Raises:
        ValueError: A baud rate or timeout that is not allowed; a URL that pyserial does not support.
        ConnectionError: The port cannot be opened, or another program uses it.
        ImportError: pyserial is missing.
    """

    def __init__(
        self,
        port: str,
        protocol: Protocol,
        *,
        baud: int,
        timeout: float = DEFAULT_TIMEOUT,
        replace: Callable[[Request], Request] = lambda request: request,
        check: Callable[[], None] = lambda: None,
    ) -> None:
        if not 0.0 < timeout <= MAX_TIMEOUT:
            raise ValueError(f"timeout {timeout}; allowed: more than 0 and at most {MAX_TIMEOUT:g} seconds")
        if baud not in protocol.baud_rates:
            raise ValueError(f"baud {baud}; allowed: {', '.join(map(str, protocol.baud_rates))}")
        self.port, self.protocol, self.timeout = port, protocol, timeout
        self.now = monotonic
        self.timing = LineTiming(baud, protocol.stop_bits, pipelined=True)
        self.deadline = math.inf
        self.statistics = LineStatistics()
        self.on_traffic: Callable[[Traffic], None] | None = None
        self._replace, self._check = replace, check
        self._serial = open_port(port, baud, protocol.stop_bits, timeout)
        self._splitter = LineSplitter()
        self._lines: deque[bytes] = deque()
        self._mid_line = self._skip_line = False
        """Whether the last received byte did not end a line."""
        self._pending: list[tuple[str, _Slot]] = []
        """Commands to which a reply may still arrive, in the order in which they were sent: the unanswered ones, and
        the last answered one, whose reply may be repeated."""
        self._ahead: list[_Slot] = []
        """Requests of `send_ahead`, which the next exchange confirms."""

    @property
    def descriptor(self) -> int | None:
        """File descriptor of the open port; None if it has none, as `loop://`."""
        # `rfc2217://` has no `fileno`.
        connection = getattr(self._serial, "_socket", None)
        if isinstance(connection, socket.socket):
            return connection.fileno()
        try:
            return int(self._serial.fileno())
        except (AttributeError, OSError):
            return None

    def close(self) -> None:
        """Close the port; a second call does nothing."""
        self._serial.close()

    def measure(self, stop: Request, period: float | None) -> bool:
        """Check that the robot replies, stop it, and measure the line; `timing` and `timeout` then follow it.

        After a reply that took long, the next one decides: a single stall of the computer or the robot is no latency.
        Returns whether the robot has confirmed the stop; if not, the line is too slow for the period.
        """
        begin, latencies, patience = self.now(), list[float](), self.timeout
        self.deadline = begin + max(OPENING_TIMEOUT, _TRIES * self.timeout)
        self.timeout = max(patience, _PATIENCE)
        query, identity = self.protocol.queries[0], self.protocol.identity
        for number, request in enumerate((identity, stop, query, identity, query)):
            sent_at = self.now()
            is_late = number > 0 and (min(latencies) > _PATIENCE or sent_at > begin + _MEASURING_TIMEOUT)
            if is_late and number > 1:
                break
            limit = self.deadline
            if is_late and period is not None:
                self.deadline = min(limit, sent_at + _PATIENCE)
            try:
                reply = self.exchange([request])[0]
            except RobotLost:
                if self.deadline == limit or self.now() < self.deadline:
                    raise
                break
            self.deadline = limit
            length = len(self.protocol.encode_request(request) + self.protocol.encode_reply(reply))
            latencies.append(self.now() - sent_at - self._on_wire(length))
        # The shortest: the others may contain disturbances. The lower of two medians, for the same reason.
        latency, usual = max(0.0, min(latencies)), max(0.0, statistics.median_low(latencies))
        self.timeout = max(patience, min(2 * usual, MAX_ADAPTED_TIMEOUT))
        self.timing = self.timing._replace(latency=latency)
        # Again: a stall of the computer looks like a robot that replies to one request after the other.
        together = any(self._answers_together(begin) for _ in range(3))
        self.timing = self.timing._replace(pipelined=together)
        return len(latencies) > 1

    def _answers_together(self, opened: float) -> bool:
        """Whether all replies to pipelined requests arrive together, after one latency."""
        if self.now() > opened + _MEASURING_TIMEOUT:
            return True  # no time to test it
        begin, limit = self.now(), self.deadline
        requests = [query for query in self.protocol.queries if query.command in ("N", "E", "O")]
        self.deadline = min(limit, begin + self.timeout + self._on_wire(len(requests) * _MAX_REPLY_LENGTH))
        try:
            replies = self.exchange(requests)
        except RobotLost:
            return False
        finally:
            self.deadline = limit
        encode_request, encode_reply = self.protocol.encode_request, self.protocol.encode_reply
        length = len(b"".join([*map(encode_request, requests), *map(encode_reply, replies)]))
        return self.now() - begin <= 1.5 * self.timing.latency + 0.01 + self._on_wire(length)

    def send_ahead(self, requests: Sequence[Request]) -> bool:
        """Send requests for whose replies the next exchange waits.

        Returns False if nothing was sent: an older reply may still arrive, or the robot gets requests one by one.
        """
        pending = {command for command, _ in self._pending}
        if self._ahead or not self.timing.pipelined or not pending.isdisjoint(r.command for r in requests):
            return False
        self._ahead = [_Slot(request) for request in requests]
        try:
            self._send(self._ahead)
        except OSError as error:
            self._give_up(
                _Exchange(self._ahead, False, self.statistics.sent), f"the port failed: {error}", error
            )
        return True

    def forget_ahead(self) -> bool:
        """Do not wait for the replies to requests sent ahead; returns whether there were any."""
        had_any, self._ahead = bool(self._ahead), []
        return had_any

    def send_aside(self, request: Request) -> None:
        """Send a request in the middle of an exchange, without waiting for its reply."""
        self._pending.append((request.command, _ASIDE))
        self._write([request])

    def exchange(self, requests: Sequence[Request], *, insist: bool = False) -> list[Reply]:
        """Send requests and return their replies, in their order; repeats what is not answered.

        Args:
            requests: Different commands, or the same with others in between.
            insist: Send the requests themselves after silence, not only a query: to stop a robot as early as possible,
                whose replies may be lost.

        Raises:
            ValueError: A request cannot be encoded, or is G or restart, which may not be repeated.
            RobotLost: No reply, or the port failed; `RequestRejected` if the robot sent only error replies.
            RobotRestarted: The restart banner arrived; the robot may have executed some requests before.
        """
        for request in requests:
            if request.command in _NOT_REPEATABLE:
                raise ValueError(
                    f"{request.command} cannot be requested here; allowed: commands that may be sent twice"
                )
            self.protocol.encode_request(request)
        if not self.timing.pipelined and len(requests) > 1:
            return [self.exchange([request], insist=insist)[0] for request in requests]
        own = [_Slot(request) for request in requests]
        exchange = _Exchange([*self._ahead, *own], insist, self.statistics.sent)
        self._pending = [(name, owner if owner in self._ahead else _STALE) for name, owner in self._pending]
        try:
            if not self._ahead:
                self._discard_input()
            to_send = own
            while exchange.missing:
                self._check()
                self._batch(exchange, to_send)
                missing = exchange.missing
                # Of equal neighbours only the first: a repeated reply to it could be taken for that to the second.
                different = (slot for last, slot in pairwise(missing) if slot.command != last.command)
                to_send = [*missing[:1], *different]
        except RobotRestarted:
            self._pending.clear()
            self._ahead = []
            raise
        except RobotLost:
            raise
        except OSError as error:
            self._give_up(exchange, f"the port failed: {error}", error)
        self._ahead = []
        return [slot.reply for slot in own if slot.reply is not None]

    def _batch(self, exchange: "_Exchange", to_send: list[_Slot]) -> None:
        """Send requests, and assign the replies that arrive, until all have arrived or the missing ones must be lost.

        After silence, a query follows: once it is answered, what is missing is lost.
        """
        counts, missing_before = self.statistics, len(exchange.missing)
        rejected_before, garbled, reason = counts.rejected, 0, "received nothing"
        sent = list(to_send)
        if sent and sent[0].command in {command for command, _ in self._pending}:
            # A query first: no late reply is then taken for that to the first request.
            sent.insert(0, self._fresh_query(to_send))
        expected = [*(slot for slot in exchange.missing if slot not in to_send), *sent]
        count = len(expected)
        due = self.now() + self._on_wire(self._send(sent) + count * _MAX_REPLY_LENGTH)
        deadline = due + exchange.backoff * self.timeout
        received: list[Reply] = []
        while exchange.missing:
            self._check()
            line = self._receive_line()
            now = self.now()
            if now > (self.deadline if line else min(deadline, self.deadline)):
                counts.timeouts += 1
                exchange.silent += _COST_OF_GARBAGE if garbled else 1.0
                if exchange.silent >= _TRIES or now > self.deadline:
                    self._give_up(exchange, reason)
                if garbled or exchange.insist:
                    break
                expected.append(self._fresh_query(expected))
                due = now + self._on_wire(self._send(expected[-1:]) + _MAX_REPLY_LENGTH)
                deadline = due + exchange.backoff * self.timeout
            if line is None:
                continue
            reply = self._decode(line)
            if self._skip_line:  # its first part arrived before the requests were sent
                self._skip_line = False
            elif isinstance(reply, Reply):
                matched, is_last = self._assign(reply)
                if not matched:
                    reason = self._reason(line)
                    continue
                exchange.silent = 0.0
                received.append(reply)
                # Replies in exactly the order of the requests also tell two with the same letter apart.
                commands = [reply.command for reply in received]
                if len(commands) >= count and commands == [
                    slot.command for slot in expected[: len(commands)]
                ]:
                    for slot, reply in zip(expected, received, strict=False):
                        slot.reply = reply
                if is_last:
                    break
            elif not isinstance(reply, TextLine):
                garbled, reason = garbled + 1, self._reason(line)
                if isinstance(reply, ErrorReply):
                    counts.rejected += 1
                    if garbled + len(received) == len(expected):
                        break
                rest = max(1, len(expected) - len(received) - garbled + 1)
                wait = self._on_wire(rest * _MAX_REPLY_LENGTH) + self.timing.latency + _WAIT_AFTER_GARBAGE
                deadline = min(deadline, now + wait)
        if len(exchange.missing) < missing_before:
            exchange.failed = exchange.rejected = 0.0
            return
        was_rejected = counts.rejected > rejected_before
        exchange.rejected += was_rejected
        exchange.failed += _COST_OF_GARBAGE if garbled and not was_rejected else 1.0
        if exchange.failed >= _TRIES:
            self._give_up(exchange, reason)

    def _assign(self, reply: Reply) -> tuple[bool, bool]:
        """Assign a reply to the request that it must belong to, if there is only one.

        Returns whether it belongs to this exchange, and whether no other reply can follow.
        """
        places = [i for i, (command, _) in enumerate(self._pending) if command == reply.command]
        owners = {self._pending[place][1] for place in places}
        is_last = places == [len(self._pending) - 1]
        del self._pending[: places[0] if places else 0]
        if not owners or _STALE in owners:
            self.statistics.unmatched += 1
            return False, False
        self.statistics.answered += 1
        owners.discard(_ASIDE)
        if len(owners) == 1:
            owners.pop().reply = reply
        return True, is_last

    def _fresh_query(self, expected: list[_Slot]) -> _Slot:
        """A query whose reply cannot be taken for another."""
        taken = {command for command, _ in self._pending} | {slot.command for slot in expected}
        # If all are taken, the first is as good as any: its reply shows only that there is a robot.
        queries = self.protocol.queries
        return _Slot(next((query for query in queries if query.command not in taken), queries[0]))

    def _send(self, slots: Sequence[_Slot]) -> int:
        requests = [self._replace(slot.request) for slot in slots]
        self._pending += zip((request.command for request in requests), slots, strict=True)
        return self._write(requests)

    def _write(self, requests: Sequence[Request]) -> int:
        """Send requests; returns the number of bytes.

        A port that is blocked for longer than its time limit loses requests, like a disturbed line.
        """
        from serial import SerialTimeoutException

        data = b"".join(map(self.protocol.encode_request, requests))
        if data:
            if self.on_traffic is not None:
                self.on_traffic(Traffic(True, data))
            with contextlib.suppress(SerialTimeoutException):
                self._serial.write(data)
            self.statistics.sent += len(requests)
        return len(data)

    def _discard_input(self) -> None:
        """Discard all received bytes: none of them can belong to the next reply."""
        while waiting := self._serial.in_waiting:
            self._read(waiting)
        while self._lines:
            if isinstance(self._decode(self._lines.popleft()), Reply | ErrorReply):
                self.statistics.unmatched += 1
        self._skip_line = self._mid_line

    def _receive_line(self) -> bytes | None:
        """The next line; None without one within `POLL` seconds."""
        if not self._lines:
            self._read(1)
        return self._lines.popleft() if self._lines else None

    def _decode(self, line: bytes) -> Reply | ErrorReply | TextLine | None:
        """The reply in a line, or a remark without a meaning; None if it is garbled.

        Raises `RobotRestarted` if the line belongs to the banner.
        """
        try:
            reply = self.protocol.decode_reply(line)
        except ProtocolError:
            reply = TextLine("")
        if not isinstance(reply, TextLine):
            return reply
        if self.protocol.is_banner(reply):
            self._discard_banner()
            raise RobotRestarted
        if reply.text.startswith(self.protocol.remark):
            return reply
        self.statistics.garbled += 1
        return None

    def _discard_banner(self) -> None:
        """Read to the end of the banner: the robot would lose a request sent before."""
        self.statistics.restarts += 1
        gap_end = self.now() + _BANNER_GAP
        end = gap_end - _BANNER_GAP + _MAX_BANNER_DURATION
        while self.now() < min(gap_end, end):
            if self._read(1):
                gap_end = self.now() + _BANNER_GAP
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
            self._mid_line = data[-1] not in b"\r\n"
        return data

    def _arrived(self, size: int) -> bytes:
        try:
            data: bytes = self._serial.read(size)
        except OSError:
            # A watchdog that has stopped the robot of a frozen driver may have read the announced bytes. pyserial takes
            # that for a disconnected port; a second attempt tells one from the other.
            data = self._serial.read(size)
        return data

    def _on_wire(self, count: int) -> float:
        return seconds_on_wire(count, self.timing.baud, self.timing.stop_bits)

    def _reason(self, unmatched: bytes) -> str:
        """Why there is no reply: what was received instead."""
        if not unmatched:
            return "received nothing"
        if unmatched.startswith(b"z,"):
            return f"it replied {unmatched.decode('latin-1')}"
        counts = self.statistics
        understood = counts.answered or counts.unmatched or counts.rejected
        hint = "" if understood else f" (is the robot set to {self.timing.baud} baud?)"
        return f"received only {unmatched!r}{hint}"

    def _give_up(self, exchange: "_Exchange", reason: str, cause: Exception | None = None) -> NoReturn:
        if cause is None:
            self._check()
        is_rejected = 0.0 < exchange.rejected == exchange.failed
        tries = self.statistics.sent - exchange.sent_before
        kind = RequestRejected if is_rejected else RobotLost
        raise kind(self.port, str(exchange.missing[0].request), tries, reason) from cause


def open_port(port: str, baud: int, stop_bits: int, write_timeout: float) -> "Serial":
    """Open a port with 8 data bits and no parity."""
    require("a serial port", "robots")
    import serial

    try:
        opened = serial.serial_for_url(
            port,
            baudrate=baud,
            stopbits=stop_bits,
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
