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
from typing import TYPE_CHECKING, NamedTuple

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
DEFAULT_TIMEOUT, MAX_TIMEOUT = 0.1, 10.0
_TRIES, _COST_OF_GARBAGE = 6, 0.25
"""The robot counts as lost after so many tries in a row that bring no reply; a garbled one counts less: it is there."""
_MAX_BACKOFF = 8
"""Timeouts that a try may last: the wait doubles after each silent try, up to this."""
_MAX_ADAPTED_TIMEOUT = 0.5
"""Seconds: limit of the timeout that follows from the latency of the line."""
_OPENING_TIMEOUT, _PATIENCE = 1.9, 0.6
"""Seconds for opening, and for the first reply: a repeated request would distort the measurement."""
_NOT_REPEATABLE = ("G", RESTART)
"""Setting the counters twice loses the counts in between; a restart has no reply."""
_MAX_REPLY_LENGTH = 60
"""Bytes: N has up to 43, K and H fewer than 60."""
_WAIT_AFTER_GARBAGE = 0.02
"""Seconds to wait, in addition to the latency of the line, for further replies once a garbled line has arrived."""
_BANNER_GAP, _MAX_BANNER_DURATION = 0.06, 3.0
"""Seconds without a byte that mark the end of a restart banner; its 17 lines (KNET) take one second at 9600 baud."""
FAST = 0.005
"""Seconds: up to this latency, a command is confirmed before the round goes on."""
_ROUND = (4, 61)
"""Requests, and bytes both ways, of a round in which the gripper rests: a median of `benchmarks/wire.py`."""


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
    """Counts of events on a line since it was opened.

    Attributes:
        timeouts: Tries that left requests without a reply.
        garbled: Received lines that are not part of the protocol.
        unmatched: Well-formed replies to another request, such as late and repeated ones.
        rejected: Error replies (`z,...`).
        unknown: Readings that contradicted each other, so that the previous one was kept.
    """

    sent: int = 0
    answered: int = 0
    timeouts: int = 0
    garbled: int = 0
    unmatched: int = 0
    rejected: int = 0
    restarts: int = 0
    unknown: int = 0


@dataclass(slots=True, eq=False)
class _Slot:
    """A request and its reply."""

    request: Request
    reply: Reply | None = None

    @property
    def command(self) -> str:
        return self.request.command


class Line:
    """Exchanges requests and replies with one robot. Not thread-safe.

    Args:
        port: Any argument of `serial.serial_for_url`: a device, `socket://host:port`, `rfc2217://host:port`.
        protocol: Of the robot.
        baud: One of the protocol's.
        timeout: Seconds that a reply may take in addition to the transmission time of the bytes; two, four and eight
            times as many after silence. The port may take as long to accept a request. `measure` may lengthen it.
        replace: Called with each request before it is sent; returns what is sent, with the same command.
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
        self._pending: list[_Slot] = []
        """Requests to which a reply may still arrive, in the order in which they were sent: the unanswered ones, and
        the last answered one, whose reply may be repeated. Those of earlier exchanges come first: `_stale` of them."""
        self._stale = 0
        self._received: list[Reply] = []
        """Replies to the pending requests."""
        self._ahead: list[_Slot] = []
        """Requests of `send_ahead`, which the next exchange confirms."""

    @property
    def descriptor(self) -> int | None:
        """File descriptor of the open port; None if it has none, as `loop://`."""
        try:  # `rfc2217://` has no `fileno`
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
            if latencies and self.now() + latencies[-1] > begin + _OPENING_TIMEOUT:
                break
            self.deadline = self.now() + max(_OPENING_TIMEOUT, _TRIES * patience)
            latencies.append(self._excess_time(requests))
        # The lower of two medians, and the shortest: the others may contain disturbances. The first is too short where
        # the transmission of its two requests overlaps.
        self.timeout = max(patience, min(2 * statistics.median_low(latencies), _MAX_ADAPTED_TIMEOUT))
        self.timing = self.timing._replace(latency=min(latencies[1:] or latencies))
        # Do all replies to pipelined requests arrive together? Three tries: a stall of the computer looks like a robot
        # that replies to one request after the other.
        pipelined = [query for query in self.protocol.queries if query.command in ("N", "E", "O")]
        for _ in range(3):
            if self.now() + self.timing.latency > begin + _OPENING_TIMEOUT:
                return  # no time to test it
            self.deadline = self.now() + self.timeout + self._on_wire(len(pipelined) * _MAX_REPLY_LENGTH)
            with contextlib.suppress(RobotLost):
                if self._excess_time(pipelined) <= 1.5 * self.timing.latency + 0.01:
                    return
        self.timing = self.timing._replace(pipelined=False)

    def _excess_time(self, requests: Sequence[Request]) -> float:
        """Seconds that requests take in addition to the transmission of all bytes."""
        begin, replies = self.now(), self.exchange(requests)
        took = self.now() - begin
        data = [*map(self.protocol.encode_request, requests), *map(self.protocol.encode_reply, replies)]
        return max(0.0, took - self._on_wire(len(b"".join(data))))

    def _on_wire(self, count: int) -> float:
        return seconds_on_wire(count, self.timing.baud, self.timing.stop_bits)

    def send_ahead(self, requests: Sequence[Request]) -> None:
        """Send requests for whose replies the next exchange waits."""
        self._ahead = [_Slot(request) for request in requests]
        try:
            self._send(self._ahead)
        except OSError as error:
            raise RobotLost(self.port, str(requests[0]), 0, f"the port failed: {error}") from error

    def forget_ahead(self) -> bool:
        """Do not wait for the replies to requests sent ahead; returns whether there were any."""
        had_any, self._ahead = bool(self._ahead), []
        return had_any

    def send_aside(self, request: Request) -> None:
        """Send a request in the middle of an exchange, without waiting for its reply."""
        self._send([_Slot(request)])

    def exchange(self, requests: Sequence[Request]) -> list[Reply]:
        """Send requests and return their replies, in their order; repeats what is not answered.

        Args:
            requests: Different commands, or the same with others in between.

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
            return [self.exchange([request])[0] for request in requests]
        own = [_Slot(request) for request in requests]
        missing, to_send, sent_before = [*self._ahead, *own], own, self.statistics.sent
        failed = rejections = 0.0
        self._forget_answered()
        self._stale = len(self._pending) - len(self._ahead)
        try:
            if not self._ahead:
                self._discard_input()
            while True:
                self._check()
                garbled, rejected, reason = self._try(
                    missing, to_send, self.timeout * min(2 ** int(failed), _MAX_BACKOFF)
                )
                left = [slot for slot in missing if slot.reply is None]
                if not left:
                    break
                failed += _COST_OF_GARBAGE if garbled and not rejected else 1.0
                rejections += rejected
                if len(left) < len(missing):
                    failed = rejections = 0.0
                missing = left
                if failed >= _TRIES or self.now() > self.deadline:
                    self._check()
                    kind = RequestRejected if 0 < rejections == failed else RobotLost
                    raise kind(self.port, str(left[0].request), self.statistics.sent - sent_before, reason)
                # Of equal neighbours only the first: a repeated reply to it could be taken for that to the second.
                others = (slot for last, slot in pairwise(missing) if slot.command != last.command)
                to_send = [missing[0], *others]
        except RobotRestarted:
            self._pending, self._received, self._ahead = [], [], []
            raise
        except RobotLost:
            raise
        except OSError as error:
            tries = self.statistics.sent - sent_before
            raise RobotLost(self.port, str(missing[0].request), tries, f"the port failed: {error}") from error
        self._ahead = []
        return [slot.reply for slot in own if slot.reply is not None]

    def _try(self, missing: list[_Slot], to_send: list[_Slot], patience: float) -> tuple[int, bool, str]:
        """Send requests, and assign the replies that arrive, until all have arrived or the missing ones must be lost.

        Returns the number of garbled lines, whether there were error replies, and what was received instead of a reply.
        """
        garbled, rejected, heard, reason = 0, False, False, ""
        self._forget_answered()
        taken = {slot.command for slot in self._pending}
        if to_send[0].command in taken:
            # A query first: no late reply is then taken for that to the first request. If all queries are taken, the
            # first is as good as any: its reply shows only that there is a robot.
            taken |= {slot.command for slot in to_send}
            queries = self.protocol.queries
            to_send = [_Slot(next((q for q in queries if q.command not in taken), queries[0])), *to_send]
        deadline = self._send(to_send) + patience
        while any(slot.reply is None for slot in missing):
            self._check()
            if not self._lines:
                heard |= bool(self._read(1))
            line = self._lines.popleft() if self._lines else None
            now = self.now()
            if now > (self.deadline if line else min(deadline, self.deadline)):
                self.statistics.timeouts += 1
                break
            reply = None if line is None else self._decode(line)
            if line is None or isinstance(reply, TextLine):
                continue
            if isinstance(reply, Reply):
                place = self._assign(reply)
                if place < self._stale:
                    self.statistics.unmatched += 1
                    reason = self._reason(line)
                elif place == len(self._pending) - 1:
                    break  # no other reply can follow
                continue
            garbled, reason = garbled + 1, self._reason(line)
            if isinstance(reply, ErrorReply):
                rejected = True
                self.statistics.rejected += 1
            rest = max(1, len(to_send) - garbled + 1)
            wait = self._on_wire(rest * _MAX_REPLY_LENGTH) + self.timing.latency + _WAIT_AFTER_GARBAGE
            deadline = min(deadline, now + wait)
        if not reason:
            reason = self._reason(begun) if heard and (begun := self._splitter.incomplete) else "received nothing"
        return garbled, rejected, reason

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
            slot, command = self._pending[low], received[i].command
            if low < self._stale or slot is not self._pending[high] or slot.reply is not None:
                continue
            # Positions of arm and jaw look alike.
            possible = {s.request for s in self._pending[low:high] if s.command == command}
            if len(possible) <= 1 or not received[i].values:
                slot.reply = received[i]
                self.statistics.answered += 1
        return first[-1]

    def _forget_answered(self) -> None:
        """Forget the requests before the last one that was answered."""
        places = _first_places([slot.command for slot in self._pending], self._received)
        count = places[-1] if places else 0
        del self._pending[:count]
        self._stale, self._received = max(0, self._stale - count), []

    def _send(self, slots: Sequence[_Slot]) -> float:
        """Send requests; returns the moment at which their replies have arrived if they are not late.

        A port that is blocked for longer than its time limit loses requests, like a disturbed line.
        """
        from serial import SerialTimeoutException

        self._pending += slots
        data = b"".join(self.protocol.encode_request(self._replace(slot.request)) for slot in slots)
        with contextlib.suppress(SerialTimeoutException):
            self._serial.write(data)
        self.statistics.sent += len(slots)
        replies = len(slots) + len(self._ahead)
        return self.now() + self._on_wire(len(data) + replies * _MAX_REPLY_LENGTH)

    def _discard_input(self) -> None:
        """Discard all received bytes: none of them can belong to the next reply."""
        while waiting := self._serial.in_waiting:
            self._read(waiting)
        while self._lines:
            if isinstance(self._decode(self._lines.popleft()), Reply | ErrorReply):
                self.statistics.unmatched += 1
        self._splitter.skip()

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
        gap_end, end = self.now() + _BANNER_GAP, self.now() + _MAX_BANNER_DURATION
        while self.now() < min(gap_end, end):
            if self._read(1):
                gap_end = self.now() + _BANNER_GAP
        self._lines.clear()

    def _read(self, size: int) -> bytes:
        """Wait for up to `size` bytes, then read all that have arrived."""
        data = self._arrived(size)
        if data and (more := self._serial.in_waiting):
            data += self._arrived(more)
        self._lines.extend(self._splitter.feed(data))
        return data

    def _arrived(self, size: int) -> bytes:
        try:
            data: bytes = self._serial.read(size)
        except OSError:
            # A watchdog that has stopped the robot of a frozen driver may have read the announced bytes. pyserial takes
            # that for a disconnected port; a second attempt tells one from the other.
            data = self._serial.read(size)
        return data

    def _reason(self, unmatched: bytes) -> str:
        """Why there is no reply: what was received instead."""
        if unmatched.startswith(b"z,"):
            return f"it replied {unmatched.decode('latin-1')}"
        counts = self.statistics
        understood = counts.answered or counts.unmatched or counts.rejected
        hint = "" if understood else f" (is the robot set to {self.timing.baud} baud?)"
        return f"received only {unmatched!r}{hint}"


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
            # For `rfc2217://`, pyserial has a fixed write timeout and rejects any other.
            write_timeout=None if port.startswith("rfc2217://") else write_timeout,
            exclusive=True,
        )
    except OSError as error:
        raise ConnectionError(f"{port} cannot be opened: {error}") from error
    # The latency timer of a USB adapter, often 16 ms, would delay every reply. Only Linux devices support this mode.
    with contextlib.suppress(AttributeError, OSError, ValueError):
        opened.set_low_latency_mode(True)
    return opened
