"""The firmware: replies to every command, byte for byte; wheels, counters, gripper, another body."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from khepera_forage.robots.serial.protocol import KHEPERA, ErrorReply, LineSplitter, Reply, TextLine
from khepera_forage.sim.arena import Point, Pose
from khepera_forage.sim.world import Layout
from tests.robots.rig import Rig, make_stage

REPLIES = {
    **dict.fromkeys(["M", "Q", "C,5,5", "d,5,5", "restar", "T,1,C", "T,1,K", "", "\xff"], "z,Command not found"),
    **dict.fromkeys(["D", "D,5", "D,5,5,5", "D,5,128", "D,5, 5", "N,1", "L,2,0"], "z,Protocol error"),
    **dict.fromkeys(["T", "T,1", "T,2,N", "T,1,E,256", "T,1,H"], "z,Protocol error"),
    "B": "b,5.02,5.01",
    "D,5,-5": "d",
    "E": "e,0,0",
    "G,10,-10": "g",
    "H": "h,0,0",
    "I,3": "i,0",
    "K": "k,0,0,0,0,0,0",
    "L,0,2": "l",
    "N": "n,0,0,0,0,0,0,0,0",
    "O": "o,500,500,500,500,500,500,500,500",
    "T,1,B": "t,1,b,2,1",
    "T,1,D,1": "t,1,d",
    "T,1,E,255": "t,1,e",
    "T,1,F": "t,1,f,0",
    "T,1,G": "t,1,g,0",
    "T,1,H,0": "t,1,h,200",
    "T,1,H,1": "t,1,h,215",
    "T,1,J": "t,1,j,0",
}
"""Requests, right and wrong, and their replies, each by a robot just after power-on, on open floor."""


@pytest.mark.parametrize("line", REPLIES)
def test_every_reply_matches_byte_for_byte(stage: Rig, line: str) -> None:
    assert stage.firmware.handle(line.encode("latin-1")) == REPLIES[line].encode() + b"\r\n"


@given(st.one_of(st.binary(max_size=40), st.sampled_from(sorted(REPLIES)).map(str.encode)))
def test_any_bytes_get_a_reply_that_decodes(line: bytes) -> None:
    replies = _FUZZED.firmware.handle(line)
    assert replies.endswith(b"\r\n")
    for reply in LineSplitter().feed(replies):
        assert isinstance(KHEPERA.decode_reply(reply), Reply | ErrorReply | TextLine)


_FUZZED = make_stage()


def test_speed_holds_until_the_next_one(stage: Rig) -> None:
    stage.request("D,5,10")
    stage.advance(30)
    assert stage.request("H") == "h,1500,3000"
    assert stage.request("E") == "e,5,10"
    stage.request("D,0,0")
    assert stage.request("E") == "e,5,10", "the speeds of the last period"
    stage.advance(1)
    assert stage.request("E") == "e,0,0"
    stage.advance(5)
    assert stage.request("H") == "h,1500,3000"
    stage.request("G,1000,-1000")
    stage.request("D,5,-5")
    stage.advance(4)
    assert stage.request("H") == "h,1200,-1200", "counted from the set values"


def test_gripper_closes_on_food_which_does_not_conduct() -> None:
    stage = make_stage(food_ahead=57.0)
    assert stage.request("T,1,G") == "t,1,g,0", "the raised arm is above it"
    stage.request("T,1,E,255")
    stage.advance(12)
    assert stage.request("T,1,G") == "t,1,g,200"
    stage.request("T,1,D,1")
    stage.advance(20)
    assert stage.request("T,1,H,0") == "t,1,h,126", "closed on 35 mm"
    assert stage.request("T,1,F") == "t,1,f,0"
    empty = make_stage()
    empty.request("T,1,D,1")
    empty.advance(20)
    assert empty.request("T,1,F") == "t,1,f,255", "fingers that touch each other"


def test_attached_body_continues_the_motion(stage: Rig) -> None:
    stage.request("T,1,E,255")
    stage.request("D,5,5")
    stage.advance(20)
    stage.world.reset(np.random.default_rng(1), Layout((Pose(300.0, 200.0, 1.0),), (Point(600.0, 560.0),)))
    stage.firmware.attach(stage.robots[0])
    assert stage.request("H") == "h,1000,1000"
    stage.advance(20)
    assert stage.request("H") == "h,2000,2000"
    assert stage.request("T,1,H,1") == "t,1,h,255"
