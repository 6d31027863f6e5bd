"""The K-Team protocol: encoding and decoding of every command, and errors for all other bytes."""

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.robots.serial.khepera_protocol import COMMANDS, KHEPERA
from khepera_forage.robots.serial.protocol import (
    MAX_LINE,
    RESTART,
    ArgumentError,
    ErrorReply,
    ProtocolError,
    Reply,
    Request,
    Text,
    TextLine,
    UnknownCommandError,
)

EXAMPLES = [
    (Request("A", (3800, 800, 100)), b"A,3800,800,100\n", Reply("A"), b"a\r\n"),
    (Request("B"), b"B\n", Reply("B", ("5.02", "5.01")), b"b,5.02,5.01\r\n"),
    (Request("C", (-1000, 1000)), b"C,-1000,1000\n", Reply("C"), b"c\r\n"),
    (Request("D", (5, -5)), b"D,5,-5\n", Reply("D"), b"d\r\n"),
    (Request("E"), b"E\n", Reply("E", (5, -4)), b"e,5,-4\r\n"),
    (Request("F", (3000, 20, 4000)), b"F,3000,20,4000\n", Reply("F"), b"f\r\n"),
    (Request("G", (0, -2147483648)), b"G,0,-2147483648\n", Reply("G"), b"g\r\n"),
    (Request("H"), b"H\n", Reply("H", (2147483647, -1)), b"h,2147483647,-1\r\n"),
    (Request("I", (5,)), b"I,5\n", Reply("I", (1023,)), b"i,1023\r\n"),
    (Request("J", (20, 64, 20, 64)), b"J,20,64,20,64\n", Reply("J"), b"j\r\n"),
    (Request("K"), b"K\n", Reply("K", (1, 0, 0, 0, 1, -40)), b"k,1,0,0,0,1,-40\r\n"),
    (Request("L", (1, 2)), b"L,1,2\n", Reply("L"), b"l\r\n"),
    (Request("N"), b"N\n", Reply("N", (0, 1, 2, 3, 4, 5, 6, 1023)), b"n,0,1,2,3,4,5,6,1023\r\n"),
    (Request("O"), b"O\n", Reply("O", (500,) * 8), b"o,500,500,500,500,500,500,500,500\r\n"),
    (Request("P", (-255, 255)), b"P,-255,255\n", Reply("P"), b"p\r\n"),
    (Request("R", (63,)), b"R,63\n", Reply("R", (255,)), b"r,255\r\n"),
    (Request("W", (200, 32)), b"W,200,32\n", Reply("W"), b"w\r\n"),
    (Request("T,1,B"), b"T,1,B\n", Reply("T,1,B", (2, 1)), b"t,1,b,2,1\r\n"),
    (Request("T,1,D", (1,)), b"T,1,D,1\n", Reply("T,1,D"), b"t,1,d\r\n"),
    (Request("T,1,E", (255,)), b"T,1,E,255\n", Reply("T,1,E"), b"t,1,e\r\n"),
    (Request("T,1,F"), b"T,1,F\n", Reply("T,1,F", (0,)), b"t,1,f,0\r\n"),
    (Request("T,1,G"), b"T,1,G\n", Reply("T,1,G", (180,)), b"t,1,g,180\r\n"),
    (Request("T,1,H", (0,)), b"T,1,H,0\n", Reply("T,1,H", (200,)), b"t,1,h,200\r\n"),
    (Request("T,1,J"), b"T,1,J\n", Reply("T,1,J", (0,)), b"t,1,j,0\r\n"),
]
"""Every command as in the drivers of the sources: request, its bytes, reply, its bytes."""


@pytest.mark.parametrize(("request_", "request_bytes", "reply", "reply_bytes"), EXAMPLES)
def test_bytes_of_every_command(
    request_: Request, request_bytes: bytes, reply: Reply, reply_bytes: bytes
) -> None:
    assert KHEPERA.encode_request(request_) == request_bytes
    assert KHEPERA.encode_reply(reply) == reply_bytes
    for ending in (b"", b"\n", b"\r", b"\r\n"):
        assert KHEPERA.decode_request(request_bytes.rstrip() + ending) == request_
        assert KHEPERA.decode_reply(reply_bytes.rstrip() + ending) == reply


def test_examples_cover_every_command() -> None:
    assert {request.command for request, *_ in EXAMPLES} | {RESTART} == set(COMMANDS)


def test_restart_has_no_reply_but_the_banner() -> None:
    assert KHEPERA.encode_request(Request(RESTART)) == b"restart\n"
    assert KHEPERA.decode_request(b"restart") == Request(RESTART)
    with pytest.raises(UnknownCommandError, match="banner"):
        KHEPERA.encode_reply(Reply(RESTART))


@st.composite
def requests(draw: st.DrawFn) -> Request:
    name = draw(st.sampled_from(sorted(COMMANDS)))
    return Request(name, tuple(draw(st.integers(*allowed)) for allowed in COMMANDS[name].arguments))


@st.composite
def replies(draw: st.DrawFn) -> Reply:
    name = draw(st.sampled_from(sorted(set(COMMANDS) - {RESTART})))
    versions = st.from_regex(r"\A[0-9]{1,3}(\.[0-9]{1,3})?\Z")
    values: list[int | str] = [
        draw(versions) if isinstance(allowed, Text) else draw(st.integers(*allowed))
        for allowed in COMMANDS[name].results
    ]
    return Reply(name, tuple(values))


@given(requests())
def test_requests_survive_encoding_and_decoding(request_: Request) -> None:
    line = KHEPERA.encode_request(request_)
    assert line.endswith(b"\n")
    assert b"\r" not in line
    assert KHEPERA.decode_request(line) == request_


@given(replies())
def test_replies_survive_encoding_and_decoding(reply: Reply) -> None:
    line = KHEPERA.encode_reply(reply)
    assert len(line) < 64 < MAX_LINE
    assert KHEPERA.decode_reply(line) == reply


@given(st.text(st.characters(min_codepoint=32, max_codepoint=126)))
def test_error_replies_survive_encoding_and_decoding(text: str) -> None:
    assert KHEPERA.decode_reply(KHEPERA.encode_reply(ErrorReply(text))) == ErrorReply(text)


def near_protocol() -> st.SearchStrategy[bytes]:
    """Any bytes, and bytes that resemble the protocol."""
    parts = [
        *(name.encode() for name in COMMANDS),
        b"t",
        b"d",
        b"z",
        b",",
        b"-",
        b"0",
        b"7",
        b"255",
        b"1,",
        b"\xff",
    ]
    return st.one_of(st.binary(), st.lists(st.sampled_from(parts)).map(b"".join))


@given(near_protocol())
def test_decoded_lines_encode_to_the_same_bytes(line: bytes) -> None:
    with contextlib.suppress(ProtocolError):
        assert KHEPERA.encode_request(KHEPERA.decode_request(line)).rstrip() == line.rstrip(b"\r\n")
    with contextlib.suppress(ProtocolError):
        reply = KHEPERA.decode_reply(line)
        if not isinstance(reply, TextLine):
            assert KHEPERA.encode_reply(reply).rstrip(b"\r\n") == line.rstrip(b"\r\n")


@given(replies(), st.data())
def test_one_wrong_byte_is_rejected_or_gives_another_reply(reply: Reply, data: st.DataObject) -> None:
    line = bytearray(KHEPERA.encode_reply(reply).rstrip())
    place = data.draw(st.integers(0, len(line) - 1))
    if data.draw(st.booleans()):
        del line[place]
    else:
        line[place] = data.draw(st.integers(0, 255))
    with contextlib.suppress(ProtocolError):
        decoded = KHEPERA.decode_reply(bytes(line))
        assert not isinstance(decoded, TextLine), "one byte cannot make a word"


def test_bytes_of_error_replies() -> None:
    assert KHEPERA.encode_reply(ErrorReply("Command not found")) == b"z,Command not found\r\n"
    assert KHEPERA.decode_reply(b"z,Protocol error.\r\n") == ErrorReply("Protocol error.")
    with pytest.raises(ArgumentError, match="printable"):
        KHEPERA.encode_reply(ErrorReply("two\nlines"))


def test_banner_is_decoded_as_text_even_after_a_partial_reply() -> None:
    for text in KHEPERA.banner:
        assert KHEPERA.decode_reply(text.encode()) == TextLine(text)
    partial = b"n,12,3ROM of minirobot KHEPERA, Edoardo Franzi"
    assert KHEPERA.decode_reply(partial) == TextLine(partial.decode())
