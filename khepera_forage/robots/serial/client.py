"""The protocol client: sends a request and returns its reply, with timeouts, retries and reply matching.

The protocol has neither sequence numbers nor checksums. A reply is matched to its request by its letter, and by the
order in which the robot replies. The client therefore never sends a command while an earlier reply to the same command
may still arrive, late or repeated. It first sends a *synchronisation request* (command E, or another one if a reply to
E is pending too). Once that is answered, no older reply can arrive. After a timeout this costs one round trip instead
of waiting for silence.

Undetectable here: a digit changed into another one in transmission (the session repeats requests with implausible
readings), and replies out of order, which do not occur on a serial line.
"""

import time
from collections.abc import Callable
from typing import NoReturn

from khepera_forage.robots.khepera import RobotLost
from khepera_forage.robots.serial.command_table import RESTART
from khepera_forage.robots.serial.errors import RequestInterrupted, RequestRejected, RobotRestarted
from khepera_forage.robots.serial.port import seconds_on_wire
from khepera_forage.robots.serial.protocol import ErrorReply, Reply, Request, encode_request
from khepera_forage.robots.serial.reply_matching import PendingReplies
from khepera_forage.robots.serial.transport import Transport

DEFAULT_BAUD = 38400
DEFAULT_TIMEOUT = 0.1
MAX_TIMEOUT = 10.0
DEFAULT_TRIES = 6

_MAX_REPLY_LENGTH = 60
"""Bytes: N has up to 43, K and H fewer than 60."""
_NOT_REPEATABLE = ("G", RESTART)
"""Setting the counters twice loses the counts in between; a restart has no reply."""
_MAX_BACKOFF = 8
"""Timeouts that a try may last: the wait doubles after each silent try, up to this."""
_MAX_BACKOFF_OF_STOP = 2
"""The same for stopping, where sending the request again matters more than waiting for its reply."""
_WAIT_AFTER_GARBAGE = 0.02
"""Seconds to wait for the reply once a garbled line has arrived."""


class _NoReply(Exception):  # noqa: N818 (an event, not an error)
    """One try brought no reply."""


class ProtocolClient:
    """Requests and replies over a serial port. Not thread-safe.

    Args:
        port: Any argument of `serial.serial_for_url`.
        baud: 9600, 19200, 38400, 57600 or 115200.
        timeout: Seconds that a reply may take in addition to the transmission time of the bytes; two, four and eight
            times as many after silence.
        tries: The robot counts as lost after this number of requests in a row without any reply, or of tries for the
            same request.

    Attributes:
        transport: The serial port with its statistics.
        interrupted: Called before every try and while a reply is overdue; if it returns true, `RequestInterrupted` is
            raised.

    Raises:
        ValueError: A baud rate, timeout or number of tries that is not allowed.
        ConnectionError: The port cannot be opened.
        ImportError: pyserial is missing.
    """

    def __init__(
        self,
        port: str,
        *,
        baud: int = DEFAULT_BAUD,
        timeout: float = DEFAULT_TIMEOUT,
        tries: int = DEFAULT_TRIES,
    ) -> None:
        if not 0.0 < timeout <= MAX_TIMEOUT:
            raise ValueError(f"timeout {timeout}; allowed: more than 0 and at most {MAX_TIMEOUT:g} seconds")
        if tries < 1:
            raise ValueError(f"tries {tries}; allowed: at least 1")
        self.port = port
        self.baud = baud
        self.tries = tries
        self.interrupted: Callable[[], bool] = lambda: False
        self.transport = Transport(port, baud)
        self._timeout = timeout
        self._pending = PendingReplies()

    def request(self, request: Request) -> Reply:
        """Send a request and return its reply; repeats the request as often as needed.

        Raises:
            ValueError: The request cannot be encoded, or is G or restart, which may not be repeated.
            RobotLost: No reply, or the port failed; `RequestRejected` if the robot sent only error replies.
            RobotRestarted: The restart banner arrived; the robot may have executed the request before.
            RequestInterrupted: See the attribute `interrupted`.
        """
        return self._repeat(request, self._try, _MAX_BACKOFF)

    def request_at_once(self, request: Request) -> Reply:
        """As `request`, but each try first sends the request without regard to pending replies.

        For stopping: the request arrives as early as possible, even at a robot whose replies are lost.
        """
        return self._repeat(request, self._try_at_once, _MAX_BACKOFF_OF_STOP)

    def close(self) -> None:
        """Close the port; a second call does nothing."""
        self.transport.close()

    def _repeat(
        self, request: Request, attempt: Callable[[Request, int], Reply | ErrorReply], max_backoff: int
    ) -> Reply:
        if request.command in _NOT_REPEATABLE:
            raise ValueError(
                f"{request.command} cannot be requested here; allowed: commands that may be sent twice"
            )
        statistics = self.transport.statistics
        sent_before, rejected, silent = statistics.sent, 0, 0
        failed = 0
        while True:
            if self.interrupted():
                raise RequestInterrupted
            answered_before = statistics.answered
            try:
                reply = attempt(request, min(2**silent, max_backoff))
                if isinstance(reply, Reply):
                    return reply
                rejected, reason = rejected + 1, f"it replied z,{reply.text}"
            except _NoReply as failure:
                reason = str(failure)
            except RobotRestarted:
                self._pending.clear()
                raise
            except OSError as error:
                self._give_up(request, sent_before, f"the port failed: {error}", RobotLost, error)
            synchronised = statistics.answered > answered_before
            failed += 1 if synchronised or not failed else 0
            silent = 0 if synchronised else silent + 1
            if max(failed, silent) >= self.tries:
                kind = RequestRejected if rejected == failed else RobotLost
                self._give_up(request, sent_before, reason, kind)

    def _give_up(
        self,
        request: Request,
        sent_before: int,
        reason: str,
        kind: type[RobotLost],
        cause: Exception | None = None,
    ) -> NoReturn:
        command = encode_request(request).decode().strip()
        raise kind(self.port, command, self.transport.statistics.sent - sent_before, reason) from cause

    def _try(self, request: Request, backoff: int) -> Reply | ErrorReply:
        """One try, preceded by a synchronisation request if a reply to the same command is pending."""
        if (sync := self._pending.sync_request(request)) is not None:
            reply = self._exchange(sync, backoff)
            if isinstance(reply, ErrorReply):
                raise _NoReply(f"it replied z,{reply.text}")
        return self._exchange(request, backoff)

    def _try_at_once(self, request: Request, backoff: int) -> Reply | ErrorReply:
        self._pending.sent(request)
        self.transport.send(request)
        return self._try(request, backoff)

    def _exchange(self, request: Request, backoff: int) -> Reply | ErrorReply:
        """Send a request and wait for the reply.

        Args:
            request: The request.
            backoff: Number of timeouts to wait.

        Raises:
            _NoReply: No matching reply arrived in time.
            RobotRestarted: The banner arrived.
            RequestInterrupted: The reply is overdue, and an urgent task needs the port.
        """
        transport, statistics = self.transport, self.transport.statistics
        transport.discard_input()
        starts_mid_line = transport.mid_line
        self._pending.sent(request)
        reply_time = seconds_on_wire(_MAX_REPLY_LENGTH, self.baud)
        due = time.monotonic() + seconds_on_wire(len(transport.send(request)), self.baud) + reply_time
        deadline = due + backoff * self._timeout
        unmatched = b""
        while (now := time.monotonic()) < deadline:
            if now > due and self.interrupted():
                raise RequestInterrupted
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
                deadline = min(deadline, time.monotonic() + reply_time + _WAIT_AFTER_GARBAGE)
            elif reply.command == request.command:
                statistics.answered += 1
                self._pending.answered(request)
                return reply
            else:
                statistics.unmatched += 1
            unmatched = line
        statistics.timeouts += 1
        raise _NoReply(
            f"received only {unmatched!r} (is the robot set to {self.baud} baud?)"
            if unmatched
            else "received nothing"
        )
