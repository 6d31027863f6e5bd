"""Reply matching: telling the reply to the current request from late replies to earlier ones.

Replies carry no number, but a robot replies in order. Once it has replied to a command that was not pending before, no
reply to an older request can follow.
"""

from collections.abc import Iterable

from khepera_forage.robots.serial.protocol import Request

_SYNC_REQUESTS = tuple(
    Request(*request) for request in (("E",), ("B",), ("K",), ("I", (0,)), ("H",), ("O",), ("N",))
)
"""Requests that change nothing, the shortest first; more than the number of tries before a robot counts as lost."""


class PendingReplies:
    """Commands to which a reply may still arrive: the unanswered ones, and the last answered one (a repeated reply).

    They are kept in the order in which they were sent.
    """

    def __init__(self) -> None:
        self._commands: list[str] = []

    def sent(self, request: Request) -> None:
        """Record that a request was sent."""
        self._commands.append(request.command)

    def answered(self, request: Request) -> None:
        """Record a reply to the oldest request with this command: no older reply can follow."""
        self._commands = self._commands[self._commands.index(request.command) :]

    def among(self, commands: Iterable[str]) -> frozenset[str]:
        """Those of some commands to which an older reply may still arrive."""
        return frozenset(commands).intersection(self._commands)

    def clear(self) -> None:
        """Record a restart of the robot: it sends no reply to earlier requests."""
        self._commands.clear()

    def sync_request(self, request: Request) -> Request | None:
        """The request to send first, so that late replies cannot be taken for the reply to this one; often None.

        If all synchronisation requests are pending, the first one is as good as any: its reply shows only that there is
        a robot.
        """
        if request.command not in self._commands:
            return None
        return next(
            (sync for sync in _SYNC_REQUESTS if sync.command not in self._commands), _SYNC_REQUESTS[0]
        )
