"""Request-reply protocols in lines of ASCII: encoding and decoding, for host and robot. No input or output.

A request is a capital letter followed by decimal numbers, separated by commas; its reply repeats the letter in lower
case and ends with CR LF. The Khepera and the e-puck share this form; a `Protocol` has the commands of one of them.

Decoding is strict: a line that decodes encodes to the same bytes again. There is no checksum, but a plus sign, a space,
a leading zero or a minus zero shows that bytes were lost or changed in transmission.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

MAX_LINE = 256
"""Bytes of a line that `LineSplitter` keeps; the longest replies have fewer than 60."""
NOT_FOUND_TEXT = "Command not found"
PROTOCOL_ERROR_TEXT = "Protocol error"
RESTART = "restart"
"""The only command that is a word; the robot replies with its banner (WEP)."""


class ProtocolError(ValueError):
    """A line that is not part of the protocol, or an unknown command; a robot replies `z,Command not found`."""


class ArgumentError(ProtocolError):
    """Wrong number, format or range of values, or an absent turret; a robot replies `z,Protocol error`."""


class Range(NamedTuple):
    """Whole numbers from `low` to `high`, both allowed."""

    low: int
    high: int


class Text(NamedTuple):
    """A value that is not a number: a regular expression, and an example for messages."""

    pattern: str
    example: str


VERSION = Text(r"[0-9]{1,3}(\.[0-9]{1,3})?", "a version such as 5.02")


class Command(NamedTuple):
    """One command: the ranges of the values in its request and in its reply, and a short description."""

    arguments: tuple[Range, ...]
    results: tuple[Range | Text, ...]
    meaning: str


class Request(NamedTuple):
    """A message from host to robot: a capital letter, a gripper message such as "T,1,G", or "restart"; its values."""

    command: str
    values: tuple[int, ...] = ()

    def __str__(self) -> str:
        return ",".join((self.command, *map(str, self.values)))


class Reply(NamedTuple):
    """The reply to a request with the same command; its values are numbers, or strings such as "5.02"."""

    command: str
    values: tuple[int | str, ...] = ()


class ErrorReply(NamedTuple):
    """An error reported by the robot: the text after `z,`."""

    text: str


class TextLine(NamedTuple):
    """A line of text, such as those of the banner that a robot sends when it starts."""

    text: str


@dataclass(frozen=True)
class Protocol:
    """The protocol of one kind of robot.

    Attributes:
        commands: By the command name of a `Request`.
        banner: Lines that the robot sends when it starts.
        identity: A request that tells this kind of robot from others.
        queries: Requests that change nothing, the shortest first; more than the tries before a robot counts as lost.
        remark: Beginning of a line of text that follows a reply, and has no meaning.
        end: End of a request.
        hint: What to check if no such robot replies.
    """

    commands: Mapping[str, Command]
    banner: tuple[str, ...]
    identity: Request
    queries: tuple[Request, ...]
    baud_rates: tuple[int, ...]
    stop_bits: int
    remark: str = "\n"
    end: bytes = b"\n"
    hint: str = ""

    @cached_property
    def _names(self) -> dict[str, str]:
        """The commands by the beginning of their replies."""
        return {name.lower(): name for name in self.commands if name != RESTART}

    @cached_property
    def _banner_words(self) -> frozenset[str]:
        return frozenset(word for line in self.banner for word in _WORD.findall(line))

    def encode_request(self, request: Request) -> bytes:
        """Encode a request; raises `ProtocolError` for an unknown command, or values that it does not allow."""
        fields = _encoded(request.command, request.values, self._command(request.command).arguments)
        return ",".join([request.command, *fields]).encode() + self.end

    def decode_request(self, line: bytes) -> Request:
        """Decode a request, with or without its ending; raises `ProtocolError`, `ArgumentError` for wrong values."""
        name, fields = _split_command(_text(line))
        values = _decoded(name, fields, self._command(name).arguments)
        return Request(name, tuple(value for value in values if isinstance(value, int)))

    def encode_reply(self, reply: Reply | ErrorReply) -> bytes:
        """Encode a reply, terminated by CR LF; raises `ProtocolError`, also for restart, which has only a banner."""
        if isinstance(reply, ErrorReply):
            if not _printable(reply.text):
                raise ArgumentError(f"error reply {reply.text!r}; allowed: printable ASCII")
            return f"z,{reply.text}\r\n".encode()
        if reply.command == RESTART:
            raise ProtocolError(f"a reply to {RESTART!r}; allowed: the banner")
        fields = _encoded(reply.command, reply.values, self._command(reply.command).results)
        return ",".join([reply.command.lower(), *fields]).encode() + b"\r\n"

    def decode_reply(self, line: bytes) -> Reply | ErrorReply | TextLine:
        """Decode a reply, with or without its ending; raises `ProtocolError` for a line that the robot does not send.

        A line that contains a word is decoded as text, even if it begins like a reply: if the power supply fails while
        the robot is sending a reply, the banner follows on the same line.
        """
        text = _text(line)
        if text.startswith("z,"):
            return ErrorReply(text[2:])
        fields = text.split(",")
        parts = 3 if fields[0] == "t" else 1
        letters = ",".join(fields[:parts])
        try:
            name = self._names.get(letters)
            if name is None:
                raise ProtocolError(f"reply {letters!r}; allowed: {', '.join(self._names)}")
            return Reply(name, _decoded(name, fields[parts:], self.commands[name].results))
        except ProtocolError:
            if NOT_FOUND_TEXT in text or PROTOCOL_ERROR_TEXT in text or not re.search("[A-Za-z]{3}", text):
                raise
            return TextLine(text)

    def is_banner(self, line: TextLine) -> bool:
        """Whether a line contains a whole word of the restart banner, wherever the robot breaks its lines."""
        return not self._banner_words.isdisjoint(_WORD.findall(line.text))

    def _command(self, name: str) -> Command:
        if name not in self.commands:
            raise ProtocolError(f"command {name!r}; allowed: {', '.join(self.commands)}")
        return self.commands[name]


class LineSplitter:
    """Splits bytes into lines, without LF, CR or CR LF; drops empty ones, and cuts longer ones than `MAX_LINE` off."""

    def __init__(self) -> None:
        self._incomplete = bytearray()

    def feed(self, data: bytes) -> list[bytes]:
        """Take the next chunk; returns the lines that it completes, oldest first. Never raises."""
        lines = []
        *ends, rest = re.split(rb"[\r\n]", data)
        for end in ends:
            line = (bytes(self._incomplete) + end)[:MAX_LINE]
            self._incomplete.clear()
            if line:
                lines.append(line)
        self._incomplete += rest[: MAX_LINE - len(self._incomplete)]
        return lines


def seconds_on_wire(count: int, baud: int, stop_bits: int = 2) -> float:
    """Transmission time of a number of bytes, each with a start bit and 8 data bits."""
    return count * (9 + stop_bits) / baud


def wrap_counter(count: int, bits: int = 32) -> int:
    """A count as a signed counter holds it; also the difference of two readings across a wrap-around."""
    half = 1 << (bits - 1)
    return (count + half) % (2 * half) - half


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


def _encoded(name: str, values: Sequence[int | str], allowed: Sequence[Range | Text]) -> list[str]:
    fields = [str(value) for value in values]
    # `_decoded` would accept the string of True, of "5" or of numpy's numbers.
    for value, range_ in zip(values, allowed, strict=False):
        if type(value) is not (str if isinstance(range_, Text) else int):
            raise ArgumentError(f"{name} with {value!r}; allowed: {_allowed_values(range_)}")
    _decoded(name, fields, allowed)
    return fields


def _decoded(name: str, fields: Sequence[str], allowed: Sequence[Range | Text]) -> tuple[int | str, ...]:
    if len(fields) != len(allowed):
        raise ArgumentError(f"{name} with {len(fields)} values; allowed: {len(allowed)}")
    values: list[int | str] = []
    for text, range_ in zip(fields, allowed, strict=True):
        if isinstance(range_, Text):
            valid = re.fullmatch(range_.pattern, text) is not None
        else:  # Check the length first: int() rejects strings of thousands of digits with another error.
            is_number = len(text) <= _MAX_DIGITS and _DECIMAL.fullmatch(text)
            valid = bool(is_number) and range_.low <= int(text) <= range_.high
        if not valid:
            raise ArgumentError(f"{name} with {text[:MAX_LINE]!r}; allowed: {_allowed_values(range_)}")
        values.append(text if isinstance(range_, Text) else int(text))
    return tuple(values)


def _allowed_values(allowed: Range | Text) -> str:
    if isinstance(allowed, Range):
        return f"a whole number {allowed.low}..{allowed.high}"
    return allowed.example


_DECIMAL = re.compile(r"0|-?[1-9][0-9]*")
_WORD = re.compile(r"[A-Za-z-]{4,}")
_MAX_DIGITS = len("-2147483648")
