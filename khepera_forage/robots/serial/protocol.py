"""Request-reply protocols in lines of ASCII, and that of the Khepera: encoding and decoding. No input or output.

A request is a capital letter followed by decimal numbers, separated by commas; its reply repeats the letter in lower
case and ends with CR LF. The Khepera and the e-puck share this form; a `Protocol` has the commands of one of them.

Decoding is strict: a line that decodes encodes to the same bytes again. There is no checksum, but a plus sign, a space,
a leading zero or a minus zero shows that bytes were lost or changed in transmission.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
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

    def __str__(self) -> str:
        return f"a whole number {self.low}..{self.high}"


class Text(NamedTuple):
    """A value that is not a number: a regular expression, and an example for messages."""

    pattern: str
    example: str

    def __str__(self) -> str:
        return self.example


VERSION = Text(r"[0-9]{1,3}(\.[0-9]{1,3})?", "a version such as 5.02")


class Command(NamedTuple):
    """One command: the ranges of the values in its request and in its reply."""

    arguments: tuple[Range, ...]
    results: tuple[Range | Text, ...]


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
        baud: The usual one of `baud_rates`.
        counters: The command that reads the counters, and their bits.
        lamps: Arguments of command L that switch all lamps.
        hint: What to check if no such robot replies.
        remark: Beginning of a line of text that follows a reply, and has no meaning.
        end: End of a request.
    """

    commands: Mapping[str, Command]
    banner: tuple[str, ...]
    identity: Request
    queries: tuple[Request, ...]
    baud_rates: tuple[int, ...]
    baud: int
    stop_bits: int
    counters: tuple[str, int]
    lamps: tuple[int, ...]
    hint: str
    remark: str = "\n"
    end: bytes = b"\n"

    def encode_request(self, request: Request) -> bytes:
        """Encode a request; raises `ProtocolError` for an unknown command, or values that it does not allow."""
        return _encoded(request.command, request, self._command(request.command).arguments) + self.end

    def decode_request(self, line: bytes) -> Request:
        """Decode a request, with or without its ending; raises `ProtocolError`, `ArgumentError` for wrong values."""
        text = _text(line)
        name, *fields = text.split(",")
        if name == "T":
            if len(fields) < 2 or fields[0] != "1":
                raise ArgumentError(f"{text!r} addresses an absent turret; allowed: T,1 and a gripper message")
            name, fields = f"T,1,{fields[1]}", fields[2:]
        values = _decoded(name, fields, self._command(name).arguments)
        return Request(name, tuple(value for value in values if isinstance(value, int)))

    def encode_reply(self, reply: Reply | ErrorReply) -> bytes:
        """Encode a reply, terminated by CR LF; raises `ProtocolError`. Restart has no reply but the banner."""
        if isinstance(reply, ErrorReply):
            return f"z,{reply.text}\r\n".encode()
        return _encoded(reply.command.lower(), reply, self._command(reply.command).results) + b"\r\n"

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
            name = next((n for n in self.commands if n.lower() == letters and n != RESTART), "")
            return Reply(name, _decoded(name, fields[parts:], self._command(name).results))
        except ProtocolError:
            if NOT_FOUND_TEXT in text or PROTOCOL_ERROR_TEXT in text or not re.search("[A-Za-z]{3}", text):
                raise
            return TextLine(text)

    def is_banner(self, line: TextLine) -> bool:
        """Whether a line contains a whole word of the restart banner, wherever the robot breaks its lines."""
        return not set(_WORD.findall(line.text)).isdisjoint(_WORD.findall("\n".join(self.banner)))

    def _command(self, name: str) -> Command:
        if name not in self.commands:
            raise ProtocolError(f"command {name!r}; allowed: {', '.join(self.commands)}")
        return self.commands[name]


class LineSplitter:
    """Splits bytes into lines, without LF, CR or CR LF; drops empty ones, and cuts longer ones than `MAX_LINE` off.

    Attributes:
        incomplete: The beginning of the next line.
    """

    def __init__(self) -> None:
        self.incomplete = b""
        self._skips = False

    def feed(self, data: bytes) -> list[bytes]:
        """Take the next chunk; returns the lines that it completes, oldest first. Never raises."""
        *lines, rest = re.split(rb"[\r\n]", self.incomplete + data)
        self.incomplete = rest[:MAX_LINE]
        if lines and self._skips:
            del lines[0]
            self._skips = False
        return [line[:MAX_LINE] for line in lines if line]

    def skip(self) -> None:
        """Drop the line that is not complete yet."""
        self._skips = bool(self.incomplete)


def seconds_on_wire(count: int, baud: int, stop_bits: int = 2) -> float:
    """Transmission time of a number of bytes, each with a start bit and 8 data bits."""
    return count * (9 + stop_bits) / baud


def wrap_counter(count: int, bits: int = 32) -> int:
    """A count as a signed counter holds it; also the difference of two readings across a wrap-around."""
    half = 1 << (bits - 1)
    return (count + half) % (2 * half) - half


def _text(line: bytes) -> str:
    """The line without its ending."""
    text = re.sub(r"(\r\n|\r|\n)\Z", "", line.decode("latin-1"))
    if not re.fullmatch("[ -~]+", text):
        raise ProtocolError(f"line {line[:MAX_LINE]!r}; allowed: printable ASCII")
    return text


def _encoded(name: str, message: Request | Reply, allowed: Sequence[Range | Text]) -> bytes:
    fields = [str(value) for value in message.values]
    # `_decoded` would accept the string of True, of "5" or of numpy's numbers.
    for value, wanted in zip(message.values, allowed, strict=False):
        if type(value) is not (str if isinstance(wanted, Text) else int):
            raise ArgumentError(f"{name} with {value!r}; allowed: {wanted}")
    _decoded(name, fields, allowed)
    return ",".join([name, *fields]).encode()


def _decoded(name: str, fields: Sequence[str], allowed: Sequence[Range | Text]) -> tuple[int | str, ...]:
    if len(fields) != len(allowed):
        raise ArgumentError(f"{name} with {len(fields)} values; allowed: {len(allowed)}")
    values: list[int | str] = []
    for text, wanted in zip(fields, allowed, strict=True):
        if isinstance(wanted, Text) and re.fullmatch(wanted.pattern, text):
            values.append(text)
        elif isinstance(wanted, Range) and _DECIMAL.fullmatch(text) and wanted.low <= int(text) <= wanted.high:
            values.append(int(text))
        else:
            raise ArgumentError(f"{name} with {text[:MAX_LINE]!r}; allowed: {wanted}")
    return tuple(values)


_DECIMAL = re.compile(r"0|-?[1-9][0-9]{0,9}")
_WORD = re.compile(r"[A-Za-z-]{4,}")

# K-Team's protocol: the commands of a Khepera with a gripper that set and read speeds, counters, sensors, lamps and the
# gripper, as the manuals and drivers describe them. "Assumption" marks a range without a source.

SPEED = Range(-127, 127)
"""Speed units, pulses in 10 ms: 8 mm/s (K-Team)."""
COUNTER = Range(-(2**31), 2**31 - 1)
"""Pulses: 32 bits (RN)."""
TEN_BITS = Range(0, 1023)
BYTE = Range(0, 255)
SWITCH = Range(0, 1)

BAUD_RATES = (9600, 19200, 38400, 57600, 115200)
"""Settings of a Khepera's mode switch."""

COMMANDS: dict[str, Command] = {
    "B": Command((), (VERSION, VERSION)),  # versions of the BIOS and of the protocol
    "D": Command((SPEED,) * 2, ()),  # set the speeds, left and right
    "E": Command((), (SPEED,) * 2),  # measured speeds
    "G": Command((COUNTER,) * 2, ()),  # set the encoder counters
    "H": Command((), (COUNTER,) * 2),  # read the encoder counters
    "I": Command((Range(0, 5),), (TEN_BITS,)),  # read an analogue input, 4 mV a bit
    # Position control: target reached, mode, error; left, right. No source defines the codes, hence wide ranges.
    "K": Command((), (SWITCH, BYTE, COUNTER) * 2),
    "L": Command((SWITCH, Range(0, 2)), ()),  # switch an LED: off, on, toggle
    "N": Command((), (TEN_BITS,) * 8),  # proximity, clockwise from the left
    "O": Command((), (TEN_BITS,) * 8),  # ambient light, in the same order; low is bright
    "T,1,B": Command((), (BYTE, BYTE)),  # gripper: version and revision of its software
    "T,1,D": Command((SWITCH,), ()),  # gripper: open the jaw (0) or close it (1)
    "T,1,E": Command((BYTE,), ()),  # gripper: set the target position of the arm
    "T,1,F": Command((), (BYTE,)),  # gripper: resistivity sensor; above 20 if the fingers conduct (PYRO)
    "T,1,G": Command((), (BYTE,)),  # gripper: optical barrier; about 0 without an object, above 100 with one
    # Position of the jaw (0) or of the arm (1). The reply does not repeat the argument (NIC-IF, KNET): only the request
    # distinguishes them.
    "T,1,H": Command((SWITCH,), (BYTE,)),
    "T,1,J": Command((), (BYTE,)),  # gripper: jumpers
    RESTART: Command((), ()),  # as after power-on
}
"""By the command name of a `Request`: a letter, a gripper message, or the word restart."""

KHEPERA = Protocol(
    COMMANDS,
    # The text is K-Team's; the line breaks are an assumption.
    banner=(
        "ROM of minirobot KHEPERA, Edoardo Franzi",
        "K-Team S.A.",
        "October 22, 1998",
        "Rev. 5.01",
        "Serial Communication Protocol",
    ),
    identity=Request("B"),
    queries=(*map(Request, "EBK"), Request("I", (0,)), *map(Request, "HON")),
    baud_rates=BAUD_RATES,
    baud=38400,
    stop_bits=2,
    counters=("H", 32),
    lamps=(0, 1),
    hint="is this the port of a Khepera, switched on, with its mode switch at this baud rate?",
)
