"""A robot on a pseudo-terminal that replies as scripted: with what no intact Khepera sends, or not at all."""

from collections.abc import Callable

from khepera_forage.robots.virtual.firmware import Firmware
from khepera_forage.robots.virtual.virtual_khepera import VirtualKhepera

Action = bytes | float
"""Bytes to send, or seconds to wait, which only `SimulatedLine` does."""
Script = Callable[[bytes, int], list[Action]]
"""The actions for a request and its number."""


class _Scripted(Firmware):
    def __init__(self, script: Script) -> None:
        self.requests: list[bytes] = []
        self._script = script

    def handle(self, line: bytes) -> bytes:
        self.requests.append(line)
        actions = self._script(line, len(self.requests) - 1)
        return b"".join(action for action in actions if isinstance(action, bytes))


class ScriptedRobot(VirtualKhepera):
    """A virtual robot whose replies follow a script; `requests` are those that it has received."""

    def __init__(self, script: Script) -> None:
        firmware = _Scripted(script)
        self.requests = firmware.requests
        super().__init__(firmware, baud=None)


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
