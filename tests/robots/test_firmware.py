"""The firmware: replies to every command, byte for byte, and its registers."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.robots.serial.khepera_protocol import KHEPERA
from khepera_forage.robots.serial.protocol import ErrorReply, LineSplitter, Reply, TextLine
from tests.robots.stage import Stage, make_stage

AT_POWER_ON = {
    "A,1,2,3": "a",
    "B": "b,5.02,5.01",
    "C,100,100": "c",
    "D,5,-5": "d",
    "E": "e,0,0",
    "F,1,2,3": "f",
    "G,10,-10": "g",
    "H": "h,0,0",
    "I,3": "i,0",
    "J,10,32,10,32": "j",
    "K": "k,0,0,0,0,0,0",
    "L,0,2": "l",
    "N": "n,0,0,0,0,0,0,0,0",
    "O": "o,500,500,500,500,500,500,500,500",
    "P,40,-40": "p",
    "R,32": "r,0",
    "W,170,32": "w",
    "T,1,B": "t,1,b,2,1",
    "T,1,D,1": "t,1,d",
    "T,1,E,255": "t,1,e",
    "T,1,F": "t,1,f,0",
    "T,1,G": "t,1,g,0",
    "T,1,H,0": "t,1,h,200",
    "T,1,H,1": "t,1,h,215",
    "T,1,J": "t,1,j,0",
}
"""Requests and their replies, each by a robot just after power-on, on open floor."""


@pytest.mark.parametrize("line", AT_POWER_ON)
def test_every_reply_matches_byte_for_byte(stage: Stage, line: str) -> None:
    for ending in ("", "\n", "\r", "\r\n"):
        fresh = make_stage()
        assert fresh.firmware.handle((line + ending).encode()) == AT_POWER_ON[line].encode() + b"\r\n"


@pytest.mark.parametrize("line", ["M", "Q", "d,5,5", "restar", "T,1,C", "T,1,K", "", "\xff", "hello"])
def test_unknown_commands_get_an_error_reply(stage: Stage, line: str) -> None:
    assert stage.firmware.handle(line.encode("latin-1")) == b"z,Command not found\r\n"


@pytest.mark.parametrize(
    "line",
    ["D", "D,5", "D,5,5,5", "D,5,128", "D,5, 5", "N,1", "L,2,0", "T", "T,1", "T,2,N", "T,1,E,256", "T,1,H"],
)
def test_wrong_values_get_an_error_reply(stage: Stage, line: str) -> None:
    assert stage.firmware.handle(line.encode()) == b"z,Protocol error\r\n"


@given(st.one_of(st.binary(max_size=40), st.sampled_from(sorted(AT_POWER_ON)).map(str.encode)))
def test_any_bytes_get_a_reply_that_decodes(line: bytes) -> None:
    replies = _FUZZED.firmware.handle(line)
    assert replies.endswith(b"\r\n")
    for reply in LineSplitter().feed(replies):
        assert isinstance(KHEPERA.decode_reply(reply), Reply | ErrorReply | TextLine)


_FUZZED = make_stage()
