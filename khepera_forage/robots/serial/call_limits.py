"""Limits of the time that a call may take: first the wheels are stopped, then the robot counts as lost."""

import time
from collections.abc import Callable

from khepera_forage.robots.serial.client import ProtocolClient
from khepera_forage.robots.serial.protocol import Request

STOP = Request("D", (0, 0))
MOTION_COMMANDS = ("C", "D", "P")
"""Position control, speed and pulse-width modulation of the wheels."""
HOLD_AFTER = 0.5
"""Seconds after which a call that is not complete stops the wheels."""
MAX_DURATION = 4.0
"""Seconds after which a robot whose call is not complete counts as lost."""
_MAX_TIMEOUTS = 40
"""The same in timeouts, for a user who has chosen a long one."""


def turns_wheels(request: Request) -> bool:
    """Whether a request sets the wheels in motion."""
    return request.command in MOTION_COMMANDS and (request.command == "C" or any(request.values))


class CallLimits:
    """Limits the time of the calls on one line.

    A robot whose replies are lost or late drives on at its last speed. After `HOLD_AFTER`, or one timeout if that is
    longer, the wheels are therefore stopped, and again and again until the call is complete; requests that would turn
    them are repeated as a stop meanwhile. The next command starts them again, or the same one once the robot replies.

    Args:
        client: The connection to the robot.
        may_be_moving: Whether the wheels may be turning.

    Attributes:
        holds: How often the wheels were stopped.
    """

    def __init__(self, client: ProtocolClient, may_be_moving: Callable[[], bool]) -> None:
        self.holds = 0
        self._client = client
        self._may_be_moving = may_be_moving
        self._hold_at = float("inf")
        self._hold_after = max(HOLD_AFTER, client.base_timeout)
        self._max_duration = max(MAX_DURATION, _MAX_TIMEOUTS * client.base_timeout)
        self._holding = self._resumed = False
        client.exchange.while_waiting = self._check
        client.replace_repeated = self._replaced

    def begin(self) -> None:
        """Begin a call."""
        now = time.monotonic()
        self._client.exchange.deadline = now + self._max_duration
        self._holding = self._resumed = False
        self._hold_at = now + self._hold_after

    def resume(self) -> None:
        """Let requests turn the wheels again, for one time-out and once in a call: the robot has replied."""
        if not self._resumed:
            self._holding, self._resumed = False, True
            self._hold_at = time.monotonic() + self._client.timeout

    def _check(self) -> None:
        now = time.monotonic()
        if now >= self._hold_at and self._may_be_moving():
            self._hold_at = now + self._hold_after
            self.holds += 1
            self._holding = True
            self._client.exchange.send_unanswered(STOP)

    def _replaced(self, request: Request) -> Request:
        return STOP if self._holding and turns_wheels(request) else request
