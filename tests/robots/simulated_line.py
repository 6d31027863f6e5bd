"""A serial line with a clock of its own: what a test measures does not depend on the machine's load."""

from collections.abc import Callable
from typing import Self

import pytest

from khepera_forage.robots.serial import line
from khepera_forage.robots.serial.protocol import KHEPERA, LineSplitter, Reply, Text, seconds_on_wire

Action = bytes | float
"""Bytes to send, or seconds to wait."""
Script = Callable[[bytes, bytes], list[Action]]
"""The actions for a request and its reply, whose values are the number of the request, from 1."""


def first_replies(*actions: Callable[[bytes], list[Action]]) -> Script:
    """A script of the actions for the first replies; the others are sent as they are."""
    remaining = iter(actions)
    return lambda request, reply: next(remaining, lambda reply: [reply])(reply)


def reply_with(request: bytes, value: int) -> bytes:
    """The reply to a request of a Khepera, with all values equal to `value`, as far as they are allowed."""
    command = KHEPERA.decode_request(request).command
    results = KHEPERA.commands[command].results
    values = tuple("5.02" if isinstance(result, Text) else min(value, result.high) for result in results)
    return KHEPERA.encode_reply(Reply(command, values))


class SimulatedLine:
    """The host's port; time passes only while the host waits for bytes, or in `sleep`.

    Args:
        script: Sends the replies by default.
        baud: Of both directions.
        latency: Seconds that each reply takes in addition.

    Attributes:
        now: Seconds since the beginning.
        requests: The requests that have arrived, with their times.
        script: Returns bytes to send and seconds to wait.
    """

    def __init__(self, script: Script | None = None, *, baud: int = 38400, latency: float = 0.0) -> None:
        self.now, self.latency = 0.0, latency
        self.requests: list[tuple[float, bytes]] = []
        self.script = first_replies() if script is None else script
        self._baud, self._splitter = baud, LineSplitter()
        self._arrived_until = self._sent_until = 0.0
        self._replies: list[tuple[float, bytes]] = []

    def install(self, monkeypatch: pytest.MonkeyPatch) -> Self:
        """Let drivers open this line instead of a port."""
        monkeypatch.setattr(line, "open_port", lambda *arguments: self)
        monkeypatch.setattr(line, "monotonic", lambda: self.now)
        return self

    def sleep(self, until: float) -> None:
        self.now = max(self.now, until)

    @property
    def commands(self) -> list[bytes]:
        """The requests without their times."""
        return [request for _, request in self.requests]

    def say(self, data: bytes) -> None:
        """Send bytes without a request."""
        self._replies += [(self.now, bytes((value,))) for value in data]

    def sent_since(self, begin: float, prefix: bytes = b"") -> list[bytes]:
        """The requests that arrived after a moment."""
        return [request for at, request in self.requests if at > begin and request.startswith(prefix)]

    # What the driver calls.

    @property
    def in_waiting(self) -> int:
        return sum(due <= self.now for due, _ in self._replies)

    def read(self, size: int) -> bytes:
        due = [(at, byte) for at, byte in self._replies if at <= self.now][:size]
        if not due:
            self.now = min([self.now + line.POLL, *(at for at, _ in self._replies if at > self.now)])
            due = [(at, byte) for at, byte in self._replies if at <= self.now][:size]
        del self._replies[: len(due)]
        return b"".join(byte for _, byte in due)

    def write(self, data: bytes) -> int:
        for byte in data:
            self._arrived_until = max(self.now, self._arrived_until) + seconds_on_wire(1, self._baud)
            for request in self._splitter.feed(bytes((byte,))):
                self._execute(request)
        return len(data)

    def close(self) -> None:
        """Nothing is open."""

    def _execute(self, request: bytes) -> None:
        self.requests.append((self._arrived_until, request))
        at = self._arrived_until + self.latency
        for action in self.script(request, reply_with(request, len(self.requests))):
            if isinstance(action, bytes):
                for value in action:
                    at = max(at, self._sent_until) + seconds_on_wire(1, self._baud)
                    self._sent_until = at
                    self._replies.append((at, bytes((value,))))
            else:
                at += action
