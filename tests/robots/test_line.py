"""A serial line: opening, requests, replies that are late, repeated, garbled or missing, and the restart banner."""

import math
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager, suppress

import pytest
import serial
from hypothesis import given, settings
from hypothesis import strategies as st

from khepera_forage.robots.khepera import RobotLost
from khepera_forage.robots.serial.line import Line, RequestRejected, RobotRestarted
from khepera_forage.robots.serial.protocol import KHEPERA, Reply, Request
from tests.robots.rig import Rig, make_rig
from tests.robots.simulated_line import Action, Script, SimulatedLine, first_replies, reply_with

N, H, BARRIER = Request("N"), Request("H"), Request("T,1,G")
ARM, JAW, D5 = Request("T,1,H", (1,)), Request("T,1,H", (0,)), Request("D", (5, 5))
BANNER_BYTES = b"".join(line.encode() + b"\r\n" for line in KHEPERA.banner)
LATE = 0.3
"""Seconds, more than the timeout of the tests."""


@contextmanager
def connected(script: Script, *, timeout: float = 0.08) -> Iterator[tuple[Line, SimulatedLine]]:
    """A line with a clock of its own."""
    with pytest.MonkeyPatch.context() as patch:
        simulated = SimulatedLine(script, baud=115200).install(patch)
        yield Line("simulated", KHEPERA, baud=115200, timeout=timeout), simulated


@contextmanager
def opened() -> Iterator[tuple[Line, Rig]]:
    """A line on a pseudo-terminal."""
    with make_rig() as rig, closing(Line(rig.url, KHEPERA, baud=115200)) as line:
        yield line, rig


def first(line: Line, request: Request) -> int | str:
    """The first value of the reply to one request."""
    return line.exchange([request])[0].values[0]


@pytest.mark.parametrize("end", [b"\r", b"\n", b"\r\n"])
def test_replies_may_arrive_in_pieces_with_any_line_ending(end: bytes) -> None:
    def in_pieces(reply: bytes) -> list[Action]:
        body = reply.rstrip() + end
        return [piece for byte in body for piece in (bytes((byte,)), 0.001)]

    with connected(first_replies(in_pieces, in_pieces), timeout=5.0) as (line, _):
        assert line.exchange([N, H]) == [Reply("N", (1,) * 8), Reply("H", (2, 2))]
        assert line.statistics.timeouts == 0


def test_garbled_and_unmatched_lines_are_ignored() -> None:
    others = b"N\r\nz\r\nm\r\n5.01\r\nt,2,b,1\r\nh,4,5\r\n\r\n\r\n\xff\x80\r\nn,1,2\r\nhello there\r\n"
    with connected(first_replies(lambda reply: [others + reply]), timeout=5.0) as (line, scripted):
        assert first(line, N) == 1
        assert scripted.commands == [b"N"]
        assert (line.statistics.unmatched, line.statistics.garbled) == (1, 8)


ACTIONS: dict[str, Callable[[bytes], list[Action]]] = {
    "in time": lambda reply: [reply],
    "lost": lambda reply: [],
    "late": lambda reply: [LATE, reply],
    "twice": lambda reply: [reply, 0.005, reply],
    "garbled": lambda reply: [b"?" + reply[1:]],
}
EXCHANGES = [[N], [ARM], [JAW], [D5, N], [N, ARM, BARRIER, JAW, H]]


@given(
    st.lists(st.sampled_from(sorted(ACTIONS)), max_size=30),
    st.lists(st.tuples(st.sampled_from(EXCHANGES), st.booleans(), st.booleans()), min_size=1, max_size=4),
)
@settings(derandomize=True, deadline=None, max_examples=300)
def test_replies_belong_to_the_requests_of_their_exchange(
    actions: list[str], exchanges: list[tuple[list[Request], bool, bool]]
) -> None:
    """Replies of arm and jaw look alike; before an exchange, the robot may have sent something else."""
    with connected(first_replies(*(ACTIONS[action] for action in actions))) as (line, scripted):
        for requests, is_given_up, is_disturbed in exchanges:
            if is_disturbed:
                scripted.say(reply_with(str(requests[-1]).encode(), 999) + b"n,9,9")
            sent = len(scripted.commands)
            line.deadline = line.now() + 0.05 if is_given_up else math.inf
            with suppress(RobotLost):
                for request, reply in zip(requests, line.exchange(requests), strict=True):
                    for value in reply.values[:1]:
                        assert int(value) > sent
                        assert scripted.commands[int(value) - 1] == str(request).encode()


@pytest.mark.parametrize(
    ("received", "to", "tries", "message"),
    [
        (b"", b"", 6, "received nothing$"),
        (b"", b"N", 6, "received nothing$"),
        (b"\x80\xf8\r\n", b"", 24, "is the robot set to 115200 baud"),
        (b"\x80\xf8", b"", 6, r"received only b'(\\x80\\xf8)+' \(is the robot set to 115200 baud"),
        (b"n,1,2\r\n", b"N", 24, r"received only b'n,1,2'$"),
    ],
)
def test_request_without_a_reply_loses_the_robot(received: bytes, to: bytes, tries: int, message: str) -> None:
    with connected(lambda request, reply: [received if to in request else reply], timeout=0.01) as (line, scripted):
        with pytest.raises(RobotLost, match=message) as lost:
            line.exchange([N])
        assert (lost.value.port, lost.value.command) == ("simulated", "N")
        assert lost.value.tries == len(scripted.commands)
        assert tries <= lost.value.tries <= 2 * tries, "requests, some behind a query"


def test_repeated_error_replies_raise_request_rejected() -> None:
    error = b"z,Protocol error\r\n"
    with connected(lambda request, reply: [error if request.startswith(b"T,1") else reply]) as (line, _):
        with pytest.raises(RequestRejected, match=r"'T,1,G' .*it replied z,Protocol error"):
            line.exchange([N, BARRIER, H])
        assert line.statistics.rejected >= 3


@pytest.mark.parametrize(
    "banner",
    [
        BANNER_BYTES,
        b"n,1,2," + BANNER_BYTES,
        b"b,5.02," + BANNER_BYTES,
        b"ROM of minirobot\r\nKHEPERA\r\n" + b"some words\r\n" * 15,
        BANNER_BYTES[17:],
    ],
    ids=["complete", "after a partial reply", "after a version", "other line breaks", "without its beginning"],
)
def test_restart_banner_is_recognised_and_discarded(banner: bytes) -> None:
    with connected(first_replies(lambda reply: [banner[:40], 0.01, banner[40:]])) as (line, _):
        with pytest.raises(RobotRestarted):
            line.exchange([N])
        assert first(line, N) == 2
        assert (line.statistics.restarts, line.statistics.timeouts) == (1, 0)


def test_commands_that_may_not_be_repeated_are_rejected() -> None:
    with connected(first_replies()) as (line, scripted):
        for request in (Request("G", (0, 0)), Request("restart")):
            with pytest.raises(ValueError, match="allowed: commands that may be sent twice"):
                line.exchange([request])
        with pytest.raises(ValueError, match=r"999.*allowed"):
            line.exchange([Request("D", (999, 0))])
        assert scripted.commands == []


@pytest.mark.parametrize("timeout", [0.0, math.nan])
def test_invalid_timeout_is_rejected(timeout: float) -> None:
    with pytest.raises(ValueError, match=f"timeout {timeout}; allowed: more than 0"):
        Line("/dev/null", KHEPERA, baud=38400, timeout=timeout)


def test_port_that_is_in_use_is_reported() -> None:
    with opened() as (line, _), pytest.raises(ConnectionError, match=f"{line.port} cannot be opened"):
        Line(line.port, KHEPERA, baud=38400)


def test_write_timeout_is_a_lost_request(monkeypatch: pytest.MonkeyPatch) -> None:
    """pyserial reports it on a blocked port, and when the process was not scheduled for half a second."""
    write, timeouts = serial.Serial.write, [True, False]

    def slow(port: serial.Serial, data: bytes) -> int | None:
        if timeouts:
            if timeouts.pop():
                write(port, data)
            raise serial.SerialTimeoutException("Write timeout")
        return write(port, data)

    monkeypatch.setattr(serial.Serial, "write", slow)
    with opened() as (line, _):
        assert line.exchange([H]) == [Reply("H", (0, 0))]


def test_garbled_reply_is_requested_again_at_once() -> None:
    """Not after the timeout."""
    garbled = first_replies(lambda reply: [b"n,1,1,1,\x8f,1,1,1,1\r\n"])
    with connected(garbled, timeout=10.0) as (line, scripted):
        assert line.exchange([N, H]) == [Reply("N", (3,) * 8), Reply("H", (2, 2))]
        assert scripted.commands == [b"N", b"H", b"N"]
        assert line.statistics.timeouts == 0


def test_late_reply_is_matched_to_its_own_request() -> None:
    """A repeated request would take longer, and the robot could be late again."""
    with connected(first_replies(lambda reply: [LATE, reply])) as (line, _):
        assert first(line, N) == 1
