"""The K-Team ASCII protocol: bytes to values and back, for both ends of the line. No input or output.

A request is a capital letter and decimal numbers between commas, ended by LF; its reply repeats the letter in lower
case and ends with CR LF. The table of commands is in `codec_table`.

Numbers are read as strictly as they are written: what decodes is what encodes, byte for byte. There is no checksum;
a plus sign, a space, a leading zero or a minus zero shows that something was lost or changed on the way.
"""

import re
from collections.abc import Sequence
from typing import NamedTuple

from khepera_forage.robots.serial.command_table import COMMANDS, RESTART, Command, Range, Version

MAX_LINE = 256
"""Bytes of a line that `Lines` keeps; the longest reply, of H and K, has fewer than 60."""

BANNER = (
    "ROM of minirobot KHEPERA, Edoardo Franzi",
    "K-Team S.A.",
    "October 22, 1998",
    "Rev. 5.01",
    "Serial Communication Protocol",
)
"""What the robot writes when it starts (K-Team). The text is K-Team's, where its lines end is an assumption."""

NOT_FOUND = "Command not found"
PROTOCOL_ERROR = "Protocol error"


class CodecError(ValueError):
    """A line that is nothing of the protocol, or values that do not go with a command."""


class UnknownCommandError(CodecError):
    """No such letter or gripper message; a Khepera answers `z,Command not found`."""


class ArgumentError(CodecError):
    """Wrong number, format or range of values, or no such turret; a Khepera answers `z,Protocol error`."""


class Request(NamedTuple):
    """What a host asks.

    Attributes:
        command: A capital letter of the table, a gripper message such as "T,1,G", or "restart".
        values: Its arguments.
    """

    command: str
    values: tuple[int, ...] = ()


class Reply(NamedTuple):
    """What a robot answers.

    Attributes:
        command: That of the request, in the same form.
        values: Numbers; for B two strings such as "5.02".
    """

    command: str
    values: tuple[int | str, ...] = ()


class Refusal(NamedTuple):
    """An error reported by the robot: what follows `z,`."""

    text: str


class BannerLine(NamedTuple):
    """A line of the text that a robot writes when it starts."""

    text: str


def encode_request(request: Request) -> bytes:
    """A request as it goes over the line, ended by LF.

    Raises:
        UnknownCommandError: No such command.
        ArgumentError: Wrong number of values, or one that is out of range or no whole number.
    """
    fields = _written(request.command, request.values, _command(request.command).arguments)
    return ",".join([request.command, *fields]).encode() + b"\n"


def decode_request(line: bytes) -> Request:
    """A request as the robot reads it.

    Args:
        line: With or without its ending.

    Raises:
        UnknownCommandError: No such command.
        ArgumentError: Wrong number of values, or one that is out of range or no whole number; no such turret.
        CodecError: A line that is not printable ASCII.
    """
    name, fields = _split(_text(line))
    allowed = _command(name).arguments
    _check_count(name, fields, allowed)
    return Request(name, tuple(_number(name, field, r) for field, r in zip(fields, allowed, strict=True)))


def encode_reply(reply: Reply | Refusal) -> bytes:
    """A reply as it goes over the line, ended by CR LF.

    Raises:
        UnknownCommandError: No such command, or restart, which is answered by the banner.
        ArgumentError: Wrong number of values, one that is out of range or of the wrong kind, or a refusal that is not
            printable ASCII.
    """
    if isinstance(reply, Refusal):
        if not _printable(reply.text):
            raise ArgumentError(f"refusal {reply.text!r}; allowed: printable ASCII")
        return f"z,{reply.text}\r\n".encode()
    if reply.command == RESTART:
        raise UnknownCommandError(f"a reply to {RESTART!r}; allowed: the banner")
    fields = _written(reply.command, reply.values, _command(reply.command).results)
    return ",".join([reply.command.lower(), *fields]).encode() + b"\r\n"


def decode_reply(line: bytes) -> Reply | Refusal | BannerLine:
    """A reply as the host reads it.

    A line that holds a word is taken for the banner, also when it begins as a reply: that is what a robot writes whose
    supply failed in the middle of an answer.

    Args:
        line: With or without its ending.

    Raises:
        CodecError: Anything that no Khepera writes.
    """
    text = _text(line)
    if text.startswith("z,"):
        return Refusal(text[2:])
    if re.search("[A-Za-z]{3}", text):
        if NOT_FOUND in text or PROTOCOL_ERROR in text:
            raise CodecError(f"reply {text!r}; allowed: a refusal begins with z")
        return BannerLine(text)
    if text != text.lower():
        raise UnknownCommandError(f"reply {text!r}; allowed: lower case")
    name, fields = _split(text.upper())
    allowed = _command(name).results
    _check_count(name, fields, allowed)
    return Reply(name, tuple(_result(name, field, r) for field, r in zip(fields, allowed, strict=True)))


class Lines:
    """Bytes as they come, in whatever chunks, into lines without their endings: LF, CR or CR LF.

    Empty lines are dropped. Of a line that does not end, the first `MAX_LINE` bytes are kept.
    """

    def __init__(self) -> None:
        self._begun = bytearray()

    def feed(self, data: bytes) -> list[bytes]:
        """Take what has arrived; returns the lines that it completes, oldest first. Never raises."""
        lines = []
        *ends, rest = re.split(rb"[\r\n]", data)
        for end in ends:
            line = (bytes(self._begun) + end)[:MAX_LINE]
            self._begun.clear()
            if line:
                lines.append(line)
        self._begun += rest[: MAX_LINE - len(self._begun)]
        return lines

    def clear(self) -> None:
        """Forget a line that has begun."""
        self._begun.clear()


def _command(name: str) -> Command:
    if name not in COMMANDS:
        raise UnknownCommandError(f"command {name!r}; allowed: {', '.join(COMMANDS)}")
    return COMMANDS[name]


def _split(text: str) -> tuple[str, list[str]]:
    """The name of the command, which has three parts if it is a turret's, and the fields behind it."""
    letter, *fields = text.split(",")
    if letter != "T":
        return letter, fields
    if len(fields) < 2 or fields[0] != "1":
        raise ArgumentError(
            f"{text!r} is for no turret that there is; allowed: T,1 and a message to the gripper"
        )
    return ",".join((letter, *fields[:2])), fields[2:]


def _text(line: bytes) -> str:
    """The line without its ending."""
    text = re.sub(r"(\r\n|\r|\n)\Z", "", line.decode("latin-1"))
    if not text or not _printable(text):
        raise CodecError(f"line {line[:MAX_LINE]!r}; allowed: printable ASCII")
    return text


def _printable(text: str) -> bool:
    return all(" " <= character <= "~" for character in text)


def _check_count(name: str, values: Sequence[object], allowed: Sequence[object]) -> None:
    if len(values) != len(allowed):
        raise ArgumentError(f"{name} with {len(values)} values; allowed: {len(allowed)}")


def _written(name: str, values: Sequence[int | str], allowed: Sequence[Range | Version]) -> list[str]:
    _check_count(name, values, allowed)
    for value, range_ in zip(values, allowed, strict=True):
        # True is an int to Python, and 5.0 and numpy's numbers would be written as something else than digits.
        if type(value) is not (str if isinstance(range_, Version) else int):
            raise ArgumentError(f"{name} with {value!r}; allowed: {_kind(range_)}")
        _result(name, str(value), range_)
    return [str(value) for value in values]


def _result(name: str, field: str, allowed: Range | Version) -> int | str:
    if isinstance(allowed, Range):
        return _number(name, field, allowed)
    if not _VERSION.fullmatch(field):
        raise ArgumentError(f"{name} with {field!r}; allowed: {_kind(allowed)}")
    return field


def _number(name: str, field: str, allowed: Range) -> int:
    # The length first: Python itself refuses to read thousands of digits.
    if len(field) > _DIGITS or not _DECIMAL.fullmatch(field) or not allowed.low <= int(field) <= allowed.high:
        raise ArgumentError(f"{name} with {field[:MAX_LINE]!r}; allowed: {_kind(allowed)}")
    return int(field)


def _kind(allowed: Range | Version) -> str:
    if isinstance(allowed, Range):
        return f"a whole number {allowed.low}..{allowed.high}"
    return "a version such as 5.02"


_DECIMAL = re.compile(r"0|-?[1-9][0-9]*")
_VERSION = re.compile(r"[0-9]{1,3}(\.[0-9]{1,3})?")
_DIGITS = len("-2147483648")
