"""The far end of a line for byte sequences that no healthy Khepera sends: it says what the test wrote down."""

import os
import pty
import select
import threading
import time
import tty
from collections.abc import Callable
from types import TracebackType
from typing import Self

Said = bytes | float
"""Bytes to send, or seconds to let pass."""


class Peer:
    """Answers each request line with what `answer(request, number)` gives, in order."""

    def __init__(self, answer: Callable[[bytes, int], list[Said]]) -> None:
        self.heard: list[bytes] = []
        self._answer = answer
        self._master, slave = pty.openpty()
        tty.setraw(slave)
        self._slave = slave
        self.url = os.ttyname(slave)
        self._going = True
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def _run(self) -> None:
        begun = b""
        while self._going:
            if not select.select([self._master], [], [], 0.01)[0]:
                continue
            begun += os.read(self._master, 1000)
            *lines, begun = begun.split(b"\n")
            for line in lines:
                self.heard.append(line)
                for said in self._answer(line, len(self.heard) - 1):
                    if isinstance(said, bytes):
                        os.write(self._master, said)
                    else:
                        time.sleep(said)

    def say(self, data: bytes) -> None:
        """Unasked."""
        os.write(self._master, data)

    def hang_up(self) -> None:
        self._going = False
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
            self.hang_up()


class Numbered:
    """A peer's answers that show which request they are for: the first is 1, the second 2.

    Args:
        odd: What is said in place of the answer to the request with this number.
    """

    def __init__(self, odd: dict[int, Callable[[bytes], list[Said]]]) -> None:
        self._odd = odd

    def __call__(self, request: bytes, number: int) -> list[Said]:
        reply = reply_to(request, number + 1)
        return self._odd[number](reply) if number in self._odd else [reply]


def reply_to(request: bytes, value: int) -> bytes:
    """A reply all of whose numbers are this."""
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
