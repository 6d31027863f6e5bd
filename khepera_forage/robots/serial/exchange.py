"""One exchange on the line: requests sent once, and the wait for their replies.

A reply is matched to its request by its letter, and by the order in which the robot replies; see `reply_matching`.
"""

import time
from collections.abc import Callable, Sequence

from khepera_forage.robots.serial.errors import RequestInterrupted
from khepera_forage.robots.serial.port import seconds_on_wire
from khepera_forage.robots.serial.protocol import ErrorReply, Reply, Request
from khepera_forage.robots.serial.reply_matching import PendingReplies
from khepera_forage.robots.serial.transport import Transport

_MAX_REPLY_LENGTH = 60
"""Bytes: N has up to 43, K and H fewer than 60."""
_WAIT_AFTER_GARBAGE = 0.02
"""Seconds to wait, in addition to the latency of the line, for the reply once a garbled line has arrived."""
_PATIENCE_AFTER_SYNC = 8
"""How many times longer to wait for late replies after a synchronisation request."""


class NoReply(Exception):  # noqa: N818 (an event, not an error)
    """One exchange brought no reply.

    Attributes:
        heard: Whether something else arrived, such as a garbled line.
    """

    def __init__(self, reason: str, heard: bool) -> None:
        super().__init__(reason)
        self.heard = heard


class Exchange:
    """Sends requests and waits for their replies, without repeating anything.

    Args:
        port: Any argument of `serial.serial_for_url`.
        baud: 9600, 19200, 38400, 57600 or 115200.
        write_timeout: As for `open_port`.

    Attributes:
        transport: The serial port with its statistics.
        pending: Commands to which a reply may still arrive.
        interrupted: Called while a reply is overdue; if it returns true, `RequestInterrupted` is raised.
        while_waiting: Called again and again during a wait.
        deadline: Moment on the monotonic clock at which every wait ends.
        latency: Seconds between a request and its reply, in addition to their transmission, as far as known.
    """

    def __init__(self, port: str, baud: int, write_timeout: float) -> None:
        self.transport = Transport(port, baud, write_timeout)
        self.pending = PendingReplies()
        self.interrupted: Callable[[], bool] = lambda: False
        self.while_waiting: Callable[[], None] = lambda: None
        self.deadline = float("inf")
        self.latency = 0.0
        self._baud = baud

    def send_unanswered(self, request: Request) -> None:
        """Send a request without waiting for its reply, which later exchanges do not mistake for their own."""
        self.pending.sent(request)
        self.transport.send(request)

    def single(self, request: Request, patience: float, late: Request | None = None) -> Reply | ErrorReply:
        """Send a request and wait for the reply.

        Args:
            request: The request.
            patience: Seconds to wait in addition to the transmission of the bytes.
            late: An unanswered earlier request: its late reply also ends the wait.

        Raises:
            NoReply: No matching reply arrived in time.
            RobotRestarted: The banner arrived.
            RequestInterrupted: The reply is overdue, and an urgent task needs the port.
        """
        transport, statistics = self.transport, self.transport.statistics
        transport.discard_input()
        starts_mid_line = transport.mid_line
        self.pending.sent(request)
        reply_time = seconds_on_wire(_MAX_REPLY_LENGTH, self._baud)
        due = time.monotonic() + seconds_on_wire(len(transport.send(request)), self._baud) + reply_time
        deadline = min(due + patience, self.deadline)
        unmatched = b""
        while (now := time.monotonic()) < deadline:
            self._check_wait(now > due + self.latency)
            received = transport.receive_line()
            if received is None:
                continue
            line, reply = received
            if starts_mid_line:
                # The first part of this line arrived before the request was sent, so it is not the reply.
                starts_mid_line = False
            elif isinstance(reply, ErrorReply):
                statistics.rejected += 1
                return reply
            elif reply is None:
                end = time.monotonic() + self.latency + reply_time + _WAIT_AFTER_GARBAGE
                deadline = min(deadline, end)
            elif reply.command == request.command:
                statistics.answered += 1
                self.pending.answered(request)
                return reply
            elif late is not None and reply.command == late.command:
                statistics.answered += 1
                return reply
            else:
                statistics.unmatched += 1
            unmatched = line
        statistics.timeouts += 1
        raise NoReply(self._reason(unmatched), heard=bool(unmatched))

    def batch(
        self, requests: Sequence[Request], patience: float, sent: Sequence[Request] = ()
    ) -> list[Reply | None]:
        """Send several requests at once and collect their replies, which arrive in the same order.

        If an older reply to the first one may still arrive, a synchronisation request precedes them. If some replies
        are late, one follows: once it is answered, what is missing is lost.

        Args:
            requests: A command may occur twice, not directly after itself.
            patience: Seconds to wait for the replies in addition to the transmission of the bytes; again, and longer,
                after the synchronisation request.
            sent: Requests that `send_unanswered` or `single` has sent, when no older reply to them was pending.

        Returns:
            The replies to `sent` and `requests`; None for those that did not arrive. A command that occurs twice counts
            as unanswered if any reply is missing: the remaining one could belong to either.

        Raises:
            RobotRestarted, RequestInterrupted: As for `single`.
        """
        transport, statistics = self.transport, self.transport.statistics
        if not sent:
            transport.discard_input()
        starts_mid_line = transport.mid_line and not sent
        own = [request.command for request in requests]
        stale = self.pending.among(own) - {request.command for request in sent}
        if not sent and own[0] in stale:
            sync = self.pending.sync_request(requests[0])
            if sync is not None and sync.command not in own:
                return self.batch([sync, *requests], patience)[1:]
        expected = [*sent, *requests]
        count = len(expected)
        for request in requests:
            self.pending.sent(request)
        length = len(transport.send(*requests)) + count * _MAX_REPLY_LENGTH
        due = time.monotonic() + seconds_on_wire(length, self._baud)
        deadline = min(due + patience, self.deadline)
        replies: list[Reply | None] = [None] * (count + 1)
        position = 0
        while position < count:
            now = time.monotonic()
            self._check_wait(now > due + self.latency)
            if now > deadline:
                sync = self.pending.sync_request(expected[position])
                if len(expected) > count or sync is None or now > self.deadline:
                    break
                statistics.timeouts += 1
                expected.append(sync)
                self.send_unanswered(sync)
                deadline = min(now + _PATIENCE_AFTER_SYNC * patience, self.deadline)
            received = transport.receive_line()
            if received is None:
                continue
            _, reply = received
            commands = [request.command for request in expected[position:]]
            if starts_mid_line:
                starts_mid_line = False
            elif isinstance(reply, ErrorReply):
                statistics.rejected += 1
            elif reply is not None and reply.command in commands and reply.command not in stale:
                position += commands.index(reply.command)
                replies[position] = reply
                statistics.answered += 1
                self.pending.answered(expected[position])
                position += 1
                stale = frozenset()  # All older replies have arrived before this one.
            elif reply is not None:
                statistics.unmatched += 1
        replies, names = replies[:count], [request.command for request in expected[:count]]
        if None in replies:
            return [None if names.count(name) > 1 else r for name, r in zip(names, replies, strict=True)]
        return replies

    def _check_wait(self, overdue: bool) -> None:
        self.while_waiting()
        if overdue and self.interrupted():
            raise RequestInterrupted

    def _reason(self, unmatched: bytes) -> str:
        statistics = self.transport.statistics
        if not unmatched:
            return "received nothing"
        understood = statistics.answered or statistics.unmatched or statistics.rejected
        hint = "" if understood else f" (is the robot set to {self._baud} baud?)"
        return f"received only {unmatched!r}{hint}"
