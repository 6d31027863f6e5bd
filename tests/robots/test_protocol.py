"""The K-Team protocol: encoding and decoding of every command, and errors for all other bytes."""

import contextlib

import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.robots.serial.protocol import (
    COMMANDS,
    KHEPERA,
    MAX_LINE,
    RESTART,
    ArgumentError,
    ProtocolError,
    Reply,
    Request,
    Text,
    TextLine,
)


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


@given(requests(), replies())
def test_messages_survive_encoding_and_decoding(request_: Request, reply: Reply) -> None:
    line = KHEPERA.encode_request(request_)
    assert line.endswith(b"\n")
    assert b"\r" not in line
    assert KHEPERA.decode_request(line) == request_
    line = KHEPERA.encode_reply(reply)
    assert len(line) < 64 < MAX_LINE
    assert KHEPERA.decode_reply(line) == reply


def near_protocol() -> st.SearchStrategy[bytes]:
    """Any bytes, and bytes that resemble the protocol."""
    parts = [*(name.encode() for name in COMMANDS), *b"t d z , - 0 7 255 1, \xff".split()]
    return st.one_of(st.binary(), st.lists(st.sampled_from(parts)).map(b"".join))


@given(near_protocol())
def test_decoded_lines_encode_to_the_same_bytes(line: bytes) -> None:
    with contextlib.suppress(ProtocolError):
        assert KHEPERA.encode_request(KHEPERA.decode_request(line)).rstrip() == line.rstrip(b"\r\n")
    with contextlib.suppress(ProtocolError):
        reply = KHEPERA.decode_reply(line)
        if not isinstance(reply, TextLine):
            assert KHEPERA.encode_reply(reply).rstrip(b"\r\n") == line.rstrip(b"\r\n")


NUMBERS = ("+5", " 5", "5_0", "--5", "-", "", "05", "00", "-0", "5.0", "1e1", "٣", "9" * 5000, "128", "-128")
NOT_PRINTABLE = ("", "\n", "{},5,5\0", "ÿ{},5,5", "{}\n,5,5", "{},5,5\n\n")


@pytest.mark.parametrize("line", [*(f"{{}},{number},5" for number in NUMBERS), *NOT_PRINTABLE])
def test_lines_with_other_than_plain_decimals_in_range_and_printable_bytes_are_rejected(line: str) -> None:
    for decode, letter in ((KHEPERA.decode_request, "D"), (KHEPERA.decode_reply, "e")):
        with pytest.raises(ProtocolError, match="printable" if line in NOT_PRINTABLE else None):
            decode(line.format(letter).encode())


@pytest.mark.parametrize("value", [True, 5.0, float("nan"), "5", None])
def test_values_of_the_wrong_type_are_rejected(value: object) -> None:
    with pytest.raises(ArgumentError, match=r"whole number.*-127\.\.127"):
        KHEPERA.encode_request(Request("D", (value, 5)))  # type: ignore[arg-type]
    with pytest.raises(ArgumentError, match="version"):
        KHEPERA.encode_reply(Reply("B", (5, "5.01")))
