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
import statistics
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from time import monotonic
from typing import TYPE_CHECKING, NamedTuple, NoReturn

from khepera_forage.extras import require
from khepera_forage.robots.khepera import RobotLost
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

FAST = 0.005
"""Seconds: up to this latency, a command is confirmed before the round goes on."""
MAX_ROUND_BYTES, MAX_ROUND_REQUESTS = 170, 8
"""Bytes and requests of a round in which arm and jaw move and all numbers have the maximum number of digits."""
_SHORTEST_ANSWERS, _LONGEST_ANSWERS = (3, 45), (5, 129)
"""Requests of `receive` and bytes both ways: without positions of the gripper and with numbers of one digit, or with
both positions and with all digits."""
_ROUND, _GRIPPER_ROUND = (4, 61), (6, 103)
"""The same for a round in which the gripper rests (D, N, T,1,G and H), or moves: medians of `benchmarks/wire.py`."""

_PATIENCE = 0.6
"""Seconds to wait for a reply before the latency is known: a repeated request would distort the measurement."""


class RobotRestarted(Exception):  # noqa: N818 (an event, not an error)
    """The robot sent its restart banner: its wheels are stopped and its settings are lost."""


class RequestRejected(RobotLost):
    """The robot sends only error replies: it lacks the command, or the turret that the command addresses."""


class LineTooSlow(ConnectionError):  # noqa: N818
    """The latency of a line does not allow rounds of the required duration."""


class LineTiming(NamedTuple):
    """The timing of a line, and the rounds that it allows.

    Attributes:
        latency: Seconds that a reply takes in addition to the transmission of its bytes: under 2 ms on a serial port,
            up to 16 ms with a USB adapter, more over radio or a network.
        pipelined: Whether the robot answers requests that are sent together; if not, it gets them one by one.
    """

    baud: int
    stop_bits: int = 2
    latency: float = 0.0
    pipelined: bool = False

    @property
    def round_time(self) -> float:
        """Seconds that the exchange of a round takes while the gripper rests."""
        return self.duration(*_ROUND)

    def duration(self, requests: int, length: int) -> float:
        """Seconds that requests take whose bytes, with those of the replies, have this length."""
        waits = requests if not self.pipelined else 1 if self.latency > FAST else min(requests, 2)
        return waits * self.latency + seconds_on_wire(length, self.baud, self.stop_bits)

    def longest_round(self, period: float) -> float:
        """Seconds from the end of a round to the end of the next one, at most, at a fixed rate without late replies."""
        variation = self.duration(*_LONGEST_ANSWERS) - self.duration(*_SHORTEST_ANSWERS)
        usual = period + max(self.latency, variation)
        if self.duration(*_GRIPPER_ROUND) <= period:
            return usual
        # A clock that such rounds have delayed by half a period skips the rest of it.
        return max(usual, 1.5 * period + variation)

    def latest_end(self, period: float) -> float:
        """Seconds from the beginning of a period to the end of its exchange, at most: the period and one latency.

        The readings are requested at the beginning of each period; the exchange ends when the next commands have been
        sent. This holds without late replies if a round in which the gripper moves takes at most half a period and one
        latency.
        """
        return period + self.latency

    def check(self, port: str, period: float) -> None:
        """Raise `LineTooSlow` if a round does not fit into its period."""
        if self.round_time <= period:
            return
        waits = 1 if self.pipelined else _ROUND[0]
        possible = math.ceil(100 * self.round_time) / 100
        longest = max(0.0, (period - self._replace(latency=0.0).round_time) / waits)
        raise LineTooSlow(
            f"{port} is too slow for rounds of {period:g} s: a reply takes {1000 * self.latency:.0f} ms longer than "
            f"its transmission, and a round {1000 * self.round_time:.0f} ms; required: at most {1000 * longest:.0f} ms "
            f"for a reply at {self.baud} baud. Lengthen the period to {possible:.2f} s or more, raise the baud "
            "rate, or shorten the latency (latency timer of a USB adapter, radio, network)"
        )


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


@dataclass(slots=True, eq=False)
class _Slot:
    """A request, the command that was really sent for it, and its reply."""

    request: Request
    command: str = ""
    reply: Reply | None = None


@dataclass(slots=True)
class _Exchange:
    """The state of one exchange: tries in a row that brought no reply, and those of them with an error reply."""

    slots: list[_Slot]
    insist: bool
    sent_before: int
    failed: float = 0.0
    rejected: float = 0.0

    @property
    def missing(self) -> list[_Slot]:
        """The requests without a reply."""
        return [slot for slot in self.slots if slot.reply is None]

    @property
    def backoff(self) -> int:
        """Timeouts to wait for a reply."""
        return min(1 << int(self.failed), _MAX_BACKOFF_OF_STOP if self.insist else _MAX_BACKOFF)


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
        self._replace, self._check = replace, check
        self._serial = open_port(port, baud, protocol.stop_bits, timeout)
        self._splitter = LineSplitter()
        self._lines: deque[bytes] = deque()
        self._mid_line = self._skip_line = False
        """Whether the last received byte did not end a line."""
        self._pending: list[_Slot] = []
        """Requests to which a reply may still arrive, in the order in which they were sent: the unanswered ones, and
        the last answered one, whose reply may be repeated. Those of earlier exchanges come first: `_stale` of them."""
        self._stale = 0
        self._received: list[Reply] = []
        """Replies of this exchange."""
        self._ahead: list[_Slot] = []
        """Requests of `send_ahead`, which the next exchange confirms."""

    @property
    def descriptor(self) -> int | None:
        """File descriptor of the open port; None if it has none, as `loop://`."""
        try:
            # `rfc2217://` has no `fileno`.
            return int((getattr(self._serial, "_socket", None) or self._serial).fileno())
        except (AttributeError, OSError):
            return None

    def close(self) -> None:
        """Close the port; a second call does nothing."""
        self._serial.close()

    def measure(self, stop: Request) -> None:
        """Check that the robot replies, stop it, and measure the line; `timing` and `timeout` then follow it."""
        begin, patience, latencies = self.now(), self.timeout, list[float]()
        query, identity = self.protocol.queries[0], self.protocol.identity
        self.timeout = max(patience, _PATIENCE)
        for requests in ([identity, stop], [query], [identity], [query], [identity]):
            if latencies and self.now() + latencies[-1] > begin + OPENING_TIMEOUT:
                break
            self.deadline = self.now() + max(OPENING_TIMEOUT, _TRIES * patience)
            latencies.append(self._excess_time(requests))
        # The lower of two medians, and the shortest: the others may contain disturbances. The first is too short where
        # the transmission of its two requests overlaps.
        self.timeout = max(patience, min(2 * statistics.median_low(latencies), MAX_ADAPTED_TIMEOUT))
        self.timing = self.timing._replace(latency=min(latencies[1:] or latencies))
        # Again: a stall of the computer looks like a robot that replies to one request after the other.
        together = any(self._answers_together(begin) for _ in range(3))
        self.timing = self.timing._replace(pipelined=together)

    def _answers_together(self, opened: float) -> bool:
        """Whether all replies to pipelined requests arrive together, after one latency."""
        if self.now() + self.timing.latency > opened + OPENING_TIMEOUT:
            return True  # no time to test it
        requests = [query for query in self.protocol.queries if query.command in ("N", "E", "O")]
        self.deadline = self.now() + self.timeout + self._on_wire(len(requests) * _MAX_REPLY_LENGTH)
        try:
            return self._excess_time(requests) <= 1.5 * self.timing.latency + 0.01
        except RobotLost:
            return False

    def _excess_time(self, requests: Sequence[Request]) -> float:
        """Seconds that requests take in addition to the transmission of all bytes."""
        begin, replies = self.now(), self.exchange(requests)
        took = self.now() - begin
        data = [*map(self.protocol.encode_request, requests), *map(self.protocol.encode_reply, replies)]
        return max(0.0, took - self._on_wire(len(b"".join(data))))

    def send_ahead(self, requests: Sequence[Request]) -> None:
        """Send requests for whose replies the next exchange waits."""
        self._ahead = [_Slot(request) for request in requests]
        sent_before = self.statistics.sent
        try:
            self._send(self._ahead, 0)
        except OSError as error:
            tries = self.statistics.sent - sent_before
            raise RobotLost(self.port, str(requests[0]), tries, f"the port failed: {error}") from error

    def forget_ahead(self) -> bool:
        """Do not wait for the replies to requests sent ahead; returns whether there were any."""
        had_any, self._ahead = bool(self._ahead), []
        return had_any

    def send_aside(self, request: Request) -> None:
        """Send a request in the middle of an exchange, without waiting for its reply."""
        self._send([_Slot(request)], 0)

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
        self._forget_answered()
        self._stale = len(self._pending) - len(self._ahead)
        try:
            if not self._ahead:
                self._discard_input()
            to_send = own
            while exchange.missing:
                self._check()
                self._try(exchange, to_send)
                missing = exchange.missing
                # Of equal neighbours only the first: a repeated reply to it could be taken for that to the second.
                others = (slot for last, slot in pairwise(missing) if slot.command != last.command)
                to_send = [*missing[:1], *others]
        except RobotRestarted:
            self._pending, self._received, self._ahead = [], [], []
            raise
        except RobotLost:
            raise
        except OSError as error:
            self._give_up(exchange, f"the port failed: {error}", error)
        self._ahead = []
        return [slot.reply for slot in own if slot.reply is not None]

    def _try(self, exchange: _Exchange, to_send: list[_Slot]) -> None:
        """Send requests, and assign the replies that arrive, until all have arrived or the missing ones must be lost.

        After silence, a query follows: once it is answered, what is missing is lost.
        """
        missing_before, failed_before = len(exchange.missing), exchange.failed
        garbled, rejected, reason = 0, False, "received nothing"
        answers_left = missing_before
        self._forget_answered()
        if to_send[0].request.command in {slot.command for slot in self._pending}:
            # A query first: no late reply is then taken for that to the first request.
            to_send = [self._fresh_query(to_send), *to_send]
            answers_left += 1
        deadline = self._send(to_send, answers_left) + exchange.backoff * self.timeout
        while exchange.missing:
            self._check()
            line = self._receive_line()
            now = self.now()
            if now > (self.deadline if line else min(deadline, self.deadline)):
                self.statistics.timeouts += 1
                exchange.failed += _COST_OF_GARBAGE if garbled and not rejected else 1.0
                exchange.rejected += rejected
                if exchange.failed >= _TRIES or now > self.deadline:
                    self._give_up(exchange, reason)
                if garbled or exchange.insist:
                    break
                deadline = self._send([self._fresh_query([])], 1) + exchange.backoff * self.timeout
                answers_left += 1
            if line is None:
                continue
            reply = self._decode(line)
            if self._skip_line:  # its first part arrived before the requests were sent
                self._skip_line = False
            elif isinstance(reply, Reply):
                place = self._assign(reply)
                if place < self._stale:
                    self.statistics.unmatched += 1
                    reason = self._reason(line)
                    continue
                answers_left -= 1
                exchange.failed = min(exchange.failed, failed_before + 1.0)
                if place == len(self._pending) - 1:
                    break  # no other reply can follow
            elif not isinstance(reply, TextLine):
                garbled, reason = garbled + 1, self._reason(line)
                if isinstance(reply, ErrorReply):
                    rejected = True
                    self.statistics.rejected += 1
                rest = max(1, answers_left - garbled + 1)
                wait = self._on_wire(rest * _MAX_REPLY_LENGTH) + self.timing.latency + _WAIT_AFTER_GARBAGE
                deadline = min(deadline, now + wait)
        if len(exchange.missing) < missing_before:
            exchange.failed = exchange.rejected = 0.0

    def _assign(self, reply: Reply) -> int:
        """Take a reply, and assign all replies so far that can belong to one request only.

        Returns the first place among the pending requests that it can belong to; -1 if there is none.
        """
        commands = [slot.command for slot in self._pending]
        received = [*self._received, reply]
        first = _first_places(commands, received)
        if len(first) < len(received):
            return -1
        self._received = received
        backwards = _first_places(commands[::-1], received[::-1])
        last = [len(commands) - 1 - place for place in reversed(backwards)]
        for i, (low, high) in enumerate(zip(first, last, strict=True)):
            slot = self._pending[low]
            if low >= self._stale and slot is self._pending[high] and slot.reply is None:
                slot.reply = received[i]
                self.statistics.answered += 1
        return first[-1]

    def _forget_answered(self) -> None:
        """Forget the requests before the last one that was answered."""
        places = _first_places([slot.command for slot in self._pending], self._received)
        count = places[-1] if places else 0
        del self._pending[:count]
        self._stale, self._received = max(0, self._stale - count), []

    def _fresh_query(self, to_send: list[_Slot]) -> _Slot:
        """A query whose reply cannot be taken for another."""
        taken = {slot.command for slot in self._pending} | {slot.request.command for slot in to_send}
        # If all are taken, the first is as good as any: its reply shows only that there is a robot.
        queries = self.protocol.queries
        return _Slot(next((query for query in queries if query.command not in taken), queries[0]))

    def _send(self, slots: Sequence[_Slot], replies: int) -> float:
        """Send requests; returns the moment at which a number of replies has arrived if they are not late.

        A port that is blocked for longer than its time limit loses requests, like a disturbed line.
        """
        from serial import SerialTimeoutException

        requests = [self._replace(slot.request) for slot in slots]
        for slot, request in zip(slots, requests, strict=True):
            slot.command = request.command
        self._pending += slots
        data = b"".join(map(self.protocol.encode_request, requests))
        with contextlib.suppress(SerialTimeoutException):
            self._serial.write(data)
        self.statistics.sent += len(requests)
        return self.now() + self._on_wire(len(data) + replies * _MAX_REPLY_LENGTH)

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

    def _give_up(self, exchange: _Exchange, reason: str, cause: Exception | None = None) -> NoReturn:
        if cause is None:
            self._check()
        is_rejected = 0.0 < exchange.rejected == exchange.failed
        tries = self.statistics.sent - exchange.sent_before
        kind = RequestRejected if is_rejected else RobotLost
        raise kind(self.port, str(exchange.missing[0].request), tries, reason) from cause


def _first_places(commands: Sequence[str], replies: Sequence[Reply]) -> list[int]:
    """The first place among commands to which each reply can belong, as far as they can: a reply may be repeated."""
    places, place = list[int](), 0
    for reply in replies:
        place = next((i for i in range(place, len(commands)) if commands[i] == reply.command), -1)
        if place < 0:
            break
        places.append(place)
    return places


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
