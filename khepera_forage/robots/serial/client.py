"""The protocol client: sends a request and returns its reply, with timeouts, retries and reply matching.

The protocol has neither sequence numbers nor checksums. A reply is matched to its request by its letter, and by the
order in which the robot replies. The client therefore never sends a command while an earlier reply to the same command
may still arrive, late or repeated. It first sends a *synchronisation request* (command E, or another one if a reply to
E is pending too). Once that is answered, no older reply can arrive. After a timeout this costs one round trip instead
of waiting for silence; the reply to the request itself also counts if it arrives meanwhile.

Undetectable here: a digit changed into another one in transmission (the session repeats requests with implausible
readings), and replies out of order, which do not occur on a serial line.
"""

import time
from collections.abc import Callable, Sequence
from typing import NoReturn

from khepera_forage.robots.khepera import RobotLost
from khepera_forage.robots.serial.attempt import Attempt
from khepera_forage.robots.serial.command_table import RESTART
from khepera_forage.robots.serial.errors import RequestInterrupted, RequestRejected, RobotRestarted
from khepera_forage.robots.serial.exchange import Exchange, NoReply
from khepera_forage.robots.serial.protocol import Reply, Request, encode_request
from khepera_forage.robots.serial.transport import Transport

DEFAULT_BAUD = 38400
DEFAULT_TIMEOUT = 0.1
MAX_TIMEOUT = 10.0
DEFAULT_TRIES = 6
MAX_ADAPTED_TIMEOUT = 0.5
"""Seconds: limit of the timeout that follows from the latency of the line."""

_NOT_REPEATABLE = ("G", RESTART)
"""Setting the counters twice loses the counts in between; a restart has no reply."""
_COST_OF_GARBAGE = 0.25
"""How much a try counts whose reply was garbled: the robot is there."""
_MAX_BACKOFF = 8
"""Timeouts that a try may last: the wait doubles after each silent try, up to this."""
_MAX_BACKOFF_OF_STOP = 2
"""The same for stopping, where sending the request again matters more than waiting for its reply."""


class ProtocolClient:
    """Requests and replies over a serial port. Not thread-safe.

    Args:
        port: Any argument of `serial.serial_for_url`.
        baud: 9600, 19200, 38400, 57600 or 115200.
        timeout: Seconds that a reply may take in addition to the transmission time of the bytes; two, four and eight
            times as many after silence. The port may take as long to accept a request.
        tries: The robot counts as lost after this number of requests in a row without any reply, or of tries for the
            same request.

    Attributes:
        base_timeout: As the argument `timeout`.
        timeout: The same, or more on a line with a long latency.
        exchange: The line; the robot counts as lost after `exchange.deadline`.
        replace_repeated: Called with a request before each try; returns what is sent.

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
        self.base_timeout = self.timeout = timeout
        self.tries = tries
        self.exchange = Exchange(port, baud, write_timeout=timeout)
        self.replace_repeated: Callable[[Request], Request] = lambda request: request

    @property
    def transport(self) -> Transport:
        """The serial port with its statistics."""
        return self.exchange.transport

    def adapt(self, shortest: float, usual: float) -> None:
        """Adapt to the latency of the line: the timeout becomes at least twice as long, within limits.

        Args:
            shortest: Shortest latency that was measured, in seconds.
            usual: The median.
        """
        self.exchange.latency = shortest
        self.timeout = max(self.base_timeout, min(2 * usual, MAX_ADAPTED_TIMEOUT))

    def request(self, request: Request) -> Reply:
        """Send a request and return its reply; repeats the request as often as needed.

        Raises:
            ValueError: The request cannot be encoded, or is G or restart, which may not be repeated.
            RobotLost: No reply, or the port failed; `RequestRejected` if the robot sent only error replies.
            RobotRestarted: The restart banner arrived; the robot may have executed the request before.
            RequestInterrupted: `exchange.interrupted` returned true.
        """
        return self._repeat(request, False, _MAX_BACKOFF)

    def request_in_turn(self, requests: Sequence[Request]) -> list[Reply]:
        """Send requests one by one while each is answered in time, and then the rest at once: delays do not add up.

        Args:
            requests: As for `request_all`.

        Returns:
            Their replies.

        Raises:
            RobotLost, RobotRestarted, RequestInterrupted: As for `request`.
        """
        replies: list[Reply] = []
        for number, request in enumerate(requests, 1):
            has_more = number < len(requests)
            give_way = has_more and self.exchange.pending.sync_request(request) is None
            try:
                replies.append(self._repeat(request, False, _MAX_BACKOFF, give_way=give_way))
            except NoReply:
                return replies + self.request_all(requests[number:], [request])
        return replies

    def request_at_once(self, request: Request) -> Reply:
        """As `request`, but each try first sends the request without regard to pending replies.

        For stopping: the request arrives as early as possible, even at a robot whose replies are lost.
        """
        return self._repeat(request, True, _MAX_BACKOFF_OF_STOP)

    def send(self, requests: Sequence[Request]) -> bool:
        """Send requests for whose replies `request_all` waits; returns false if an older reply may still arrive.

        Raises:
            RobotLost: The port failed.
            RequestInterrupted: As for `request`.
        """
        if self.exchange.interrupted():
            raise RequestInterrupted
        if self.exchange.pending.among([request.command for request in requests]):
            return False
        try:
            for request in requests:
                self.exchange.send_unanswered(request)
        except OSError as error:
            self._give_up(requests[0], 0, f"the port failed: {error}", RobotLost, error)
        return True

    def request_all(self, requests: Sequence[Request], sent: Sequence[Request] = ()) -> list[Reply]:
        """Send requests without waiting for each reply; those without a reply are repeated one by one.

        Args:
            requests: Different commands, or the same with others in between.
            sent: Requests already sent by `send`.

        Returns:
            The replies to `sent` and `requests`.

        Raises:
            RobotLost, RobotRestarted, RequestInterrupted: As for `request`.
        """
        if self.exchange.interrupted():
            raise RequestInterrupted
        expected = [*sent, *requests]
        try:
            replies = self.exchange.batch(requests, self.timeout, sent)
        except RobotRestarted:
            self.exchange.pending.clear()
            raise
        except OSError as error:
            self._give_up(expected[0], len(sent), f"the port failed: {error}", RobotLost, error)
        return [
            self.request(request) if reply is None else reply
            for request, reply in zip(expected, replies, strict=True)
        ]

    def close(self) -> None:
        """Close the port; a second call does nothing."""
        self.transport.close()

    def _repeat(self, request: Request, at_once: bool, max_backoff: int, *, give_way: bool = False) -> Reply:
        """Send a request until it is answered.

        Args:
            request: The request.
            at_once: As `request_at_once`.
            max_backoff: Timeouts that a try may last.
            give_way: Whether to raise `NoReply` as soon as nothing was received in time.
        """
        if request.command in _NOT_REPEATABLE:
            raise ValueError(
                f"{request.command} cannot be requested here; allowed: commands that may be sent twice"
            )
        statistics = self.transport.statistics
        attempt = Attempt(self.exchange, request, at_once, self.replace_repeated)
        sent_before, rejected, failed, silent = statistics.sent, 0, 0.0, 0.0
        while True:
            if self.exchange.interrupted():
                raise RequestInterrupted
            answered_before, cost = statistics.answered, 1.0
            try:
                reply = attempt(min(2 ** int(silent), max_backoff) * self.timeout)
                if isinstance(reply, Reply):
                    return reply
                rejected, reason = rejected + 1, f"it replied z,{reply.text}"
            except NoReply as failure:
                if give_way and not failure.heard:
                    raise
                reason = str(failure)
                cost = _COST_OF_GARBAGE if failure.heard else 1.0
            except RobotRestarted:
                self.exchange.pending.clear()
                raise
            except OSError as error:
                tries = statistics.sent - sent_before
                self._give_up(request, tries, f"the port failed: {error}", RobotLost, error)
            synchronised = statistics.answered > answered_before
            failed += cost if synchronised or not failed else 0.0
            silent = 0.0 if synchronised else silent + cost
            too_late = time.monotonic() > self.exchange.deadline
            if (max(failed, silent) >= self.tries or too_late) and not self.exchange.interrupted():
                kind = RequestRejected if rejected == failed else RobotLost
                self._give_up(request, statistics.sent - sent_before, reason, kind)

    def _give_up(
        self,
        request: Request,
        tries: int,
        reason: str,
        kind: type[RobotLost],
        cause: Exception | None = None,
    ) -> NoReturn:
        command = encode_request(request).decode().strip()
        raise kind(self.port, command, tries, reason) from cause
