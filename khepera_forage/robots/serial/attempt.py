"""The tries of one request, each with the synchronisation that it needs."""

from collections.abc import Callable

from khepera_forage.robots.serial.exchange import Exchange, NoReply
from khepera_forage.robots.serial.protocol import ErrorReply, Reply, Request


class Attempt:
    """The tries of one request.

    Each is preceded by a synchronisation request if a reply to the same command is pending.

    Args:
        exchange: The line.
        request: The request.
        at_once: Whether each try first sends the request without regard to pending replies.
        replace: Called with the request before each try; returns what is sent.
    """

    def __init__(
        self, exchange: Exchange, request: Request, at_once: bool, replace: Callable[[Request], Request]
    ) -> None:
        self._exchange, self._request, self._at_once, self._replace = exchange, request, at_once, replace
        self._sent = False
        """Whether all replies to this command that may still arrive belong to this request."""

    def __call__(self, patience: float) -> Reply | ErrorReply:
        """The reply to one try.

        Args:
            patience: Seconds to wait for it in addition to the transmission of the bytes.

        Raises:
            NoReply, RobotRestarted, RequestInterrupted: As for `Exchange.single`.
        """
        request = self._replace(self._request)
        if self._at_once:
            self._exchange.send_unanswered(request)
        sync = self._exchange.pending.sync_request(request)
        if sync is not None:
            reply = self._exchange.single(sync, patience, request if self._sent else None)
            if isinstance(reply, ErrorReply):
                raise NoReply(f"it replied z,{reply.text}", heard=False)
            if reply.command == request.command:
                return reply
        self._sent = True
        # The wheels may have been stopped meanwhile.
        return self._exchange.single(self._replace(self._request), patience)
