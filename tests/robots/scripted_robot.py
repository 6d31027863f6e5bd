"""A scripted robot on a pseudo-terminal, for byte sequences that no intact Khepera sends."""

import os
import pty
import select
import threading
import time
import tty
from collections.abc import Callable
from types import TracebackType
from typing import Self

Action = bytes | float
"""Bytes to send, or seconds to wait."""


class ScriptedRobot:
    """Performs, for each request line, the actions that `script(request, number)` returns."""

    def __init__(self, script: Callable[[bytes, int], list[Action]]) -> None:
        self.requests: list[bytes] = []
        self._script = script
        self._master, slave = pty.openpty()
        tty.setraw(slave)
        self._slave = slave
        self.url = os.ttyname(slave)
        self._running = True
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        incomplete = b""
        while self._running:
            if not select.select([self._master], [], [], 0.01)[0]:
                continue
            incomplete += os.read(self._master, 1000)
            *lines, incomplete = incomplete.split(b"\n")
            for line in lines:
                self.requests.append(line)
                for action in self._script(line, len(self.requests) - 1):
                    if isinstance(action, bytes):
                        os.write(self._master, action)
                    else:
                        time.sleep(action)

    def disconnect(self) -> None:
        self._running = False
        self._thread.join()
        for end in (self._master, self._slave):
            if end >= 0:
                os.close(end)
        self._master = self._slave = -1

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._master >= 0:
            self.disconnect()


class NumberedReplies:
    """A script of replies whose values are the number of the request, from 1.

    Args:
        exceptions: By request number, from 0: the actions that replace the reply.
    """

    def __init__(self, exceptions: dict[int, Callable[[bytes], list[Action]]]) -> None:
        self._exceptions = exceptions

    def __call__(self, request: bytes, number: int) -> list[Action]:
        reply = reply_with(request, number + 1)
        return self._exceptions[number](reply) if number in self._exceptions else [reply]


def reply_with(request: bytes, value: int) -> bytes:
    """The reply to a request, with all values equal to `value`."""
    letter = request.split(b",")[0]
    v = str(value).encode()
    if request.startswith((b"T,1,H", b"T,1,G")):
        return b"t,1," + request[4:5].lower() + b"," + v + b"\r\n"
    if request.startswith((b"T,1,D", b"T,1,E")):
        return b"t,1," + request[4:5].lower() + b"\r\n"
    counts = {b"N": 8, b"O": 8, b"H": 2, b"E": 2, b"I": 1}
    if letter == b"B":
        return b"b,5.02,5.01\r\n"
    if letter == b"K":
        return b"k,0,0," + v + b",0,0," + v + b"\r\n"
    return b",".join([letter.lower(), *[v] * counts.get(letter, 0)]) + b"\r\n"
