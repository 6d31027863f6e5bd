"""The K-Team ASCII protocol: encoding and decoding of requests and replies, for host and robot. No input or output.

A request is a capital letter followed by decimal numbers, separated by commas and terminated by LF. Its reply repeats
the letter in lower case and ends with CR LF. `command_table` lists the commands.

Decoding is strict: a line that decodes encodes to the same bytes again. The protocol has no checksum, but a plus
sign, a space, a leading zero or a minus zero shows that bytes were lost or changed in transmission.
"""

import re
from collections.abc import Sequence
from typing import NamedTuple

from khepera_forage.robots.serial.command_table import COMMANDS, RESTART, Command, Range, Version
from khepera_forage.robots.serial.framing import MAX_LINE

BANNER = (
    "ROM of minirobot KHEPERA, Edoardo Franzi",
    "K-Team S.A.",
    "October 22, 1998",
    "Rev. 5.01",
    "Serial Communication Protocol",
)
"""Lines that the robot sends when it starts. The text is K-Team's; the line breaks are an assumption."""

NOT_FOUND_TEXT = "Command not found"
PROTOCOL_ERROR_TEXT = "Protocol error"


class ProtocolError(ValueError):
    """A line that is not part of the protocol, or values that a command does not allow."""


class UnknownCommandError(ProtocolError):
    """An unknown letter or gripper message; a Khepera replies `z,Command not found`."""


class ArgumentError(ProtocolError):
    """Wrong number, format or range of values, or an absent turret; a Khepera replies `z,Protocol error`."""


class Request(NamedTuple):
    """A message from host to robot.

    Attributes:
        command: A key of `COMMANDS`: a capital letter, a gripper message such as "T,1,G", or "restart".
        values: Arguments.
    """

    command: str
    values: tuple[int, ...] = ()


class Reply(NamedTuple):
    """The robot's message in response to a request.

    Attributes:
        command: The command of the request, in the same form.
        values: Results: numbers; for B two strings such as "5.02".
    """

    command: str
    values: tuple[int | str, ...] = ()


class ErrorReply(NamedTuple):
    """An error reported by the robot: the text after `z,`."""

    text: str


class TextLine(NamedTuple):
    """A line of text, such as those of the banner that a robot sends when it starts."""

    text: str


def encode_request(request: Request) -> bytes:
    """Encode a request, terminated by LF.

    Raises:
        UnknownCommandError: The command is not in the table.
        ArgumentError: Wrong number of values, or a value out of range or not a whole number.
    """
    fields = _encode_fields(request.command, request.values, _command(request.command).arguments)
    return ",".join([request.command, *fields]).encode() + b"\n"


def decode_request(line: bytes) -> Request:
    """Decode a request.

    Args:
        line: With or without its ending.

    Raises:
        UnknownCommandError: The command is not in the table.
        ArgumentError: Wrong number of values, or a value out of range or not a whole number; an absent turret.
        ProtocolError: The line is not printable ASCII.
    """
    name, fields = _split_command(_text(line))
    allowed = _command(name).arguments
    _check_count(name, fields, allowed)
    return Request(
        name, tuple(_decode_number(name, field, r) for field, r in zip(fields, allowed, strict=True))
    )


def encode_reply(reply: Reply | ErrorReply) -> bytes:
    """Encode a reply, terminated by CR LF.

    Raises:
        UnknownCommandError: The command is not in the table, or is restart: the robot sends its banner instead.
        ArgumentError: Wrong number of values, a value out of range or of the wrong type, or an error text that is
            not printable ASCII.
    """
    if isinstance(reply, ErrorReply):
        if not _printable(reply.text):
            raise ArgumentError(f"error reply {reply.text!r}; allowed: printable ASCII")
        return f"z,{reply.text}\r\n".encode()
    if reply.command == RESTART:
        raise UnknownCommandError(f"a reply to {RESTART!r}; allowed: the banner")
    fields = _encode_fields(reply.command, reply.values, _command(reply.command).results)
    return ",".join([reply.command.lower(), *fields]).encode() + b"\r\n"


def decode_reply(line: bytes) -> Reply | ErrorReply | TextLine:
    """Decode a reply.

    A line that contains a word is decoded as text, even if it begins like a reply: if the power supply fails
    while the robot is sending a reply, the banner follows on the same line.

    Args:
        line: With or without its ending.

    Raises:
        ProtocolError: The line is not one that a Khepera sends.
    """
    text = _text(line)
    if text.startswith("z,"):
        return ErrorReply(text[2:])
    if re.search("[A-Za-z]{3}", text):
        if NOT_FOUND_TEXT in text or PROTOCOL_ERROR_TEXT in text:
            raise ProtocolError(f"reply {text!r}; allowed: an error reply begins with z")
        return TextLine(text)
    if text != text.lower():
        raise UnknownCommandError(f"reply {text!r}; allowed: lower case")
    name, fields = _split_command(text.upper())
    allowed = _command(name).results
    _check_count(name, fields, allowed)
    return Reply(
        name, tuple(_decode_result(name, field, r) for field, r in zip(fields, allowed, strict=True))
    )


def is_banner(line: TextLine) -> bool:
    """Whether a line contains a whole word of the restart banner, wherever the robot breaks its lines."""
    return not _BANNER_WORDS.isdisjoint(_WORD.findall(line.text))


def _command(name: str) -> Command:
    if name not in COMMANDS:
        raise UnknownCommandError(f"command {name!r}; allowed: {', '.join(COMMANDS)}")
    return COMMANDS[name]


def _split_command(text: str) -> tuple[str, list[str]]:
    """The command name, which has three parts for a turret, and the fields after it."""
    letter, *fields = text.split(",")
    if letter != "T":
        return letter, fields
    if len(fields) < 2 or fields[0] != "1":
        raise ArgumentError(f"{text!r} addresses an absent turret; allowed: T,1 and a gripper message")
    return ",".join((letter, *fields[:2])), fields[2:]


def _text(line: bytes) -> str:
    """The line without its ending."""
    text = re.sub(r"(\r\n|\r|\n)\Z", "", line.decode("latin-1"))
    if not text or not _printable(text):
        raise ProtocolError(f"line {line[:MAX_LINE]!r}; allowed: printable ASCII")
    return text


def _printable(text: str) -> bool:
    return all(" " <= character <= "~" for character in text)


def _check_count(name: str, values: Sequence[object], allowed: Sequence[object]) -> None:
    if len(values) != len(allowed):
        raise ArgumentError(f"{name} with {len(values)} values; allowed: {len(allowed)}")


def _encode_fields(name: str, values: Sequence[int | str], allowed: Sequence[Range | Version]) -> list[str]:
    _check_count(name, values, allowed)
    for value, range_ in zip(values, allowed, strict=True):
        # isinstance would accept True; 5.0 and numpy's numbers would not be encoded as plain digits.
        if type(value) is not (str if isinstance(range_, Version) else int):
            raise ArgumentError(f"{name} with {value!r}; allowed: {_allowed_values(range_)}")
        _decode_result(name, str(value), range_)
    return [str(value) for value in values]


def _decode_result(name: str, field: str, allowed: Range | Version) -> int | str:
    if isinstance(allowed, Range):
        return _decode_number(name, field, allowed)
    if not _VERSION.fullmatch(field):
        raise ArgumentError(f"{name} with {field!r}; allowed: {_allowed_values(allowed)}")
    return field


def _decode_number(name: str, field: str, allowed: Range) -> int:
    # Check the length first: int() rejects strings of thousands of digits with another error.
    if (
        len(field) > _MAX_DIGITS
        or not _DECIMAL.fullmatch(field)
        or not allowed.low <= int(field) <= allowed.high
    ):
        raise ArgumentError(f"{name} with {field[:MAX_LINE]!r}; allowed: {_allowed_values(allowed)}")
    return int(field)


def _allowed_values(allowed: Range | Version) -> str:
    if isinstance(allowed, Range):
        return f"a whole number {allowed.low}..{allowed.high}"
    return "a version such as 5.02"


_DECIMAL = re.compile(r"0|-?[1-9][0-9]*")
_WORD = re.compile(r"[A-Za-z-]{4,}")
_BANNER_WORDS = frozenset(word for line in BANNER for word in _WORD.findall(line))
_VERSION = re.compile(r"[0-9]{1,3}(\.[0-9]{1,3})?")
_MAX_DIGITS = len("-2147483648")
