"""A line to a Khepera: one request, its reply, and nothing else taken for it.

The protocol has no numbers and no checksums. What a reply belongs to is told by its letter, and by the one thing that
a line guarantees: a robot answers in order. So no command is sent while an answer to the same command may still come,
late or a second time: something else is asked first, a *fence* (command E, or another if E is in doubt itself). Once
the fence is answered nothing older can come. After a timeout this costs one round trip and no waiting for silence.

What cannot be told: a digit that was changed on the way into another one (the robot's driver asks again where a value
is surprising), and a reply that overtakes another, which no line does.
"""

import time
from collections.abc import Callable
from typing import NoReturn

from khepera_forage.robots.khepera import RobotLost
from khepera_forage.robots.serial.command_table import RESTART
from khepera_forage.robots.serial.line_events import Interrupted, Refused, Restarted
from khepera_forage.robots.serial.line_reader import Wire
from khepera_forage.robots.serial.port import seconds_on_wire
from khepera_forage.robots.serial.protocol import Refusal, Reply, Request, encode_request
from khepera_forage.robots.serial.reply_matching import Unsettled

_LONGEST_REPLY = 60
"""Bytes: N has up to 43, K and H fewer than 60."""
_NEVER_TWICE = ("G", RESTART)
"""Presetting counters that count loses what they counted; a restart is answered by no reply."""
_MOST_PATIENCE = 8
"""Timeouts that a try may take: after each silent one the next is waited for twice as long, up to this."""
_PATIENCE_OF_STOP = 2
"""The same for stopping, where sending it once more matters more than hearing of it."""
_AFTER_GARBAGE = 0.02
"""Seconds that a reply is still waited for once a garbled line has come in its place."""


class _Unanswered(Exception):  # noqa: N818 (an event, not a mistake)
    """One request brought no reply."""


class SerialLink:
    """Requests and replies over a serial port. Not for several threads at once.

    Args:
        port: What `serial.serial_for_url` takes.
        baud: 9600, 19200, 38400, 57600 or 115200.
        timeout: Seconds that a reply may take beyond the time that the bytes need on the wire; after silence, twice,
            four and eight times as many.
        tries: The robot is lost when so many requests in a row bring no answer, or so many for the same thing.

    Attributes:
        wire: What is beneath.
        interrupted: Asked before every try and while an answer is overdue; if true, `Interrupted` is raised.

    Raises:
        ValueError: A baud rate, timeout or number of tries that is not allowed.
        ConnectionError: The port cannot be opened.
        ImportError: pyserial is missing.
    """

    def __init__(
        self,
        port: str,
        *,
        baud: int = 38400,
        timeout: float = 0.1,
        tries: int = 6,
    ) -> None:
        if not 0.0 < timeout <= 10.0:
            raise ValueError(f"timeout {timeout}; allowed: more than 0 and at most 10 seconds")
        if tries < 1:
            raise ValueError(f"tries {tries}; allowed: at least 1")
        self.port = port
        self.baud = baud
        self.tries = tries
        self.interrupted: Callable[[], bool] = lambda: False
        self.wire = Wire(port, baud)
        self._timeout = timeout
        self._unsettled = Unsettled()

    def ask(self, request: Request) -> Reply:
        """Send a request and return its reply; it is sent again as often as needed.

        Raises:
            ValueError: The request cannot be encoded, or is G or restart, which may not be repeated.
            RobotLost: No answer, or the line is gone; `Refused` if all that came was an error reply.
            Restarted: The restart banner came; the request may have been carried out before, or not.
            Interrupted: See the attribute of the class.
        """
        return self._until_answered(request, self._try, _MOST_PATIENCE)

    def insist(self, request: Request) -> Reply:
        """As `ask`, but before each try the request is sent blindly too, whatever may be outstanding.

        For stopping: a robot that hears but is not heard gets it as well, and gets it first.
        """
        return self._until_answered(request, self._insist, _PATIENCE_OF_STOP)

    def close(self) -> None:
        """Close the port; a second call does nothing."""
        self.wire.close()

    def _until_answered(
        self, request: Request, attempt: Callable[[Request, int], Reply | Refusal], most_patience: int
    ) -> Reply:
        if request.command in _NEVER_TWICE:
            raise ValueError(f"{request.command} is not asked for here; allowed: what may be sent twice")
        sent, refused, silent = self.wire.counts.sent, 0, 0
        failed = 0
        while True:
            if self.interrupted():
                raise Interrupted
            answered = self.wire.counts.answered
            try:
                answer = attempt(request, min(2**silent, most_patience))
                if isinstance(answer, Reply):
                    return answer
                refused, reason = refused + 1, f"it answers z,{answer.text}"
            except _Unanswered as trouble:
                reason = str(trouble)
            except Restarted:
                # It owes no answer now.
                self._unsettled.clear()
                raise
            except OSError as error:
                self._give_up(request, sent, f"the line is gone: {error}", RobotLost, error)
            fenced = self.wire.counts.answered > answered
            failed += 1 if fenced or not failed else 0
            silent = 0 if fenced else silent + 1
            if max(failed, silent) >= self.tries:
                self._give_up(request, sent, reason, Refused if refused == failed else RobotLost)

    def _give_up(
        self, request: Request, sent: int, reason: str, kind: type[RobotLost], cause: Exception | None = None
    ) -> NoReturn:
        command = encode_request(request).decode().strip()
        raise kind(self.port, command, self.wire.counts.sent - sent, reason) from cause

    def _try(self, request: Request, patience: int) -> Reply | Refusal:
        """One try, with a fence before it where an answer to the same command may be on its way."""
        if (fence := self._unsettled.fence_for(request)) is not None:
            answer = self._exchange(fence, patience)
            if isinstance(answer, Refusal):
                raise _Unanswered(f"it answers z,{answer.text}")
        return self._exchange(request, patience)

    def _insist(self, request: Request, patience: int) -> Reply | Refusal:
        self._unsettled.sent(request)
        self.wire.write(request)
        return self._try(request, patience)

    def _exchange(self, request: Request, patience: int) -> Reply | Refusal:
        """Send, and wait for the reply.

        Args:
            request: What to send.
            patience: How many timeouts to wait.

        Raises:
            _Unanswered: Nothing came, or nothing of use.
            Restarted: The banner came.
            Interrupted: The answer is overdue, and something more urgent wants the line.
        """
        wire = self.wire
        wire.drain()
        stale_tail = wire.mid_line
        self._unsettled.sent(request)
        longest_reply = seconds_on_wire(_LONGEST_REPLY, self.baud)
        due = time.monotonic() + seconds_on_wire(len(wire.write(request)), self.baud) + longest_reply
        deadline = due + patience * self._timeout
        instead = b""
        while (now := time.monotonic()) < deadline:
            if now > due and self.interrupted():
                raise Interrupted
            came = wire.line()
            if came is None:
                continue
            line, answer = came
            if stale_tail:
                # What was half here before the request was sent is no answer to it.
                stale_tail = False
            elif isinstance(answer, Refusal):
                wire.counts.refused += 1
                return answer
            elif answer is None:
                deadline = min(deadline, time.monotonic() + longest_reply + _AFTER_GARBAGE)
            elif answer.command == request.command:
                wire.counts.answered += 1
                self._unsettled.answered(request)
                return answer
            else:
                wire.counts.foreign += 1
            instead = line
        wire.counts.unanswered += 1
        raise _Unanswered(f"only {instead!r} came (is it set to {self.baud} baud?)" if instead else "silence")
