"""One request, its reply: what is survived on a line, byte by byte."""

import builtins
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest

from khepera_forage.robots.khepera import RobotLost
from khepera_forage.robots.serial.line_events import Interrupted, Refused, Restarted, Traffic
from khepera_forage.robots.serial.link import SerialLink
from khepera_forage.robots.serial.port import seconds_on_wire
from khepera_forage.robots.serial.protocol import BANNER, Reply, Request
from tests.robots.peer import Numbered, Peer, Said

N = Request("N")
H = Request("H")
ARM, JAW = Request("T,1,H", (1,)), Request("T,1,H", (0,))
BANNER_BYTES = b"".join(line.encode() + b"\r\n" for line in BANNER)
LATE = 0.3


@contextmanager
def linked(
    answer: Callable[[bytes, int], list[Said]], *, timeout: float = 0.08, tries: int = 6
) -> Iterator[tuple[SerialLink, Peer]]:
    with Peer(answer) as peer:
        link = SerialLink(peer.url, baud=115200, timeout=timeout, tries=tries)
        try:
            yield link, peer
        finally:
            link.close()


def all_of(value: int) -> Reply:
    return Reply("N", (value,) * 8)


def test_a_request_and_its_reply() -> None:
    with linked(Numbered({})) as (link, peer):
        seen: list[Traffic] = []
        link.wire.traffic = seen.append
        assert link.ask(N) == all_of(1)
        assert link.ask(ARM) == Reply("T,1,H", (2,))
        assert peer.heard == [b"N", b"T,1,H,1"]
        assert b"".join(t.data for t in seen if t.sent) == b"N\nT,1,H,1\n"
        assert b"".join(t.data for t in seen if not t.sent) == b"n,1,1,1,1,1,1,1,1\r\nt,1,h,2\r\n"


@pytest.mark.parametrize("end", [b"\r", b"\n", b"\r\n"])
def test_replies_in_pieces_and_with_any_line_end(end: bytes) -> None:
    def in_pieces(reply: bytes) -> list[Said]:
        body = reply.rstrip() + end
        return [piece for byte in body for piece in (bytes((byte,)), 0.002)]

    with linked(Numbered({0: in_pieces, 1: in_pieces})) as (link, _):
        assert link.ask(N) == all_of(1)
        assert link.ask(H) == Reply("H", (2, 2))
        assert link.wire.counts.unanswered == 0


def test_a_late_reply_is_not_taken_for_that_to_the_same_request_sent_again() -> None:
    with linked(Numbered({0: lambda reply: [LATE, reply]})) as (link, peer):
        answer = link.ask(N)
        assert peer.heard[0] == peer.heard[-1] == b"N"
        assert answer == all_of(len(peer.heard)), "the answer to the request that was sent last"
        assert link.wire.counts.foreign >= 1


def test_a_late_position_of_the_arm_is_not_taken_for_that_of_the_jaw() -> None:
    with linked(Numbered({0: lambda reply: [LATE, reply]}), tries=1) as (link, peer):
        with pytest.raises(RobotLost):
            link.ask(ARM)
        link.tries = 6
        answer = link.ask(JAW)
        assert peer.heard[-1] == b"T,1,H,0"
        assert answer == Reply("T,1,H", (len(peer.heard),))


def test_a_late_reply_that_had_begun_to_arrive_is_not_taken_either() -> None:
    def halting(reply: bytes) -> list[Said]:
        return [reply[:3], LATE, reply[3:]]

    with linked(Numbered({0: halting})) as (link, peer):
        assert link.ask(N) == all_of(len(peer.heard))


def test_a_repeated_reply_is_not_taken_for_the_next() -> None:
    twice = {number: (lambda reply: [reply, 0.01, reply]) for number in range(9)}
    with linked(Numbered(twice)) as (link, peer):
        for request in (N, N, ARM, JAW, N):
            value = link.ask(request).values[0]
            assert value == len(peer.heard)


def test_no_fence_where_letters_differ() -> None:
    with linked(Numbered({})) as (link, peer):
        for _ in range(3):
            for request in (Request("D", (1, 1)), N, ARM, Request("T,1,G"), JAW, H):
                link.ask(request)
        assert len(peer.heard) == 18


def test_an_answer_of_the_line_itself_is_refused_by_fence_too() -> None:
    """Every letter that may serve as a fence has been asked in vain: still no stale value is believed."""
    with linked(Numbered({0: lambda reply: [1.2, reply]}), timeout=0.05) as (link, peer):
        assert link.ask(N) == all_of(len(peer.heard))
        fences = peer.heard[1:-1]
        assert len(fences) == len(set(fences)) >= 3, "no fence is asked twice while its answer may come"


def test_foreign_lines_are_passed_over() -> None:
    strangers = [
        b"N\r\n",
        b"t,2,b,1\r\n",
        b"h,4,5\r\n",
        b"\r\n\r\n",
        b"\xff\x80\r\n",
        b"n,1,2\r\n",
        b"hello there\r\n",
    ]
    with linked(Numbered({0: lambda reply: [b"".join(strangers) + reply]})) as (link, peer):
        assert link.ask(N) == all_of(1)
        assert peer.heard == [b"N"]
        assert link.wire.counts.foreign == 1
        assert link.wire.counts.garbled == 5


def test_what_comes_unasked_is_drained() -> None:
    with linked(Numbered({})) as (link, peer):
        peer.say(b"n,9,9,9,9,9,9,9,9\r\nn,9,9")
        time.sleep(0.05)
        assert link.ask(N) == all_of(len(peer.heard))


def test_a_garbled_reply_is_asked_for_again_at_once() -> None:
    with linked(Numbered({0: lambda reply: [b"n,1,1,1,\x8f,1,1,1,1\r\n"]}), timeout=5.0) as (link, peer):
        begin = time.monotonic()
        assert link.ask(N) == all_of(len(peer.heard))
        assert time.monotonic() - begin < 4.0, "without waiting for the timeout"


def test_silence_is_a_lost_robot() -> None:
    with linked(lambda request, number: [], timeout=0.01, tries=4) as (link, peer):
        with pytest.raises(RobotLost, match="silence") as lost:
            link.ask(Request("D", (3, -3)))
        assert (lost.value.port, lost.value.command, lost.value.tries) == (peer.url, "D,3,-3", 4)
        assert len(peer.heard) == 4


def test_only_the_same_question_in_vain_is_a_lost_robot_too() -> None:
    def deaf_to_n(request: bytes, number: int) -> list[Said]:
        return [] if request == b"N" else Numbered({})(request, number)

    with linked(deaf_to_n, timeout=0.01, tries=3) as (link, peer):
        with pytest.raises(RobotLost):
            link.ask(N)
        assert peer.heard.count(b"N") == 3


def test_garbage_alone_hints_at_the_baud_rate() -> None:
    with (
        linked(lambda request, number: [b"\x80\xf8\r\n"], timeout=0.01, tries=2) as (link, _),
        pytest.raises(RobotLost, match="is it set to 115200 baud"),
    ):
        link.ask(N)


def test_a_refusal_is_told_as_one() -> None:
    with linked(lambda request, number: [b"z,Protocol error\r\n"], tries=3) as (link, _):
        with pytest.raises(Refused, match="it answers z,Protocol error"):
            link.ask(Request("T,1,G"))
        assert link.wire.counts.refused >= 3


def test_a_single_refusal_is_asked_again() -> None:
    with linked(Numbered({0: lambda reply: [b"z,Command not found\r\n"]})) as (link, peer):
        assert link.ask(N) == all_of(len(peer.heard))


def test_a_line_that_goes_is_a_lost_robot_without_more_tries() -> None:
    with linked(Numbered({})) as (link, peer):
        link.ask(N)
        peer.hang_up()
        with pytest.raises(RobotLost, match="the line is gone") as lost:
            link.ask(H)
        assert lost.value.tries <= 1


@pytest.mark.parametrize(
    "banner",
    [
        BANNER_BYTES,
        b"n,1,2," + BANNER_BYTES,
        b"ROM of minirobot\r\nKHEPERA\r\n" + b"some words\r\n" * 15,
        BANNER_BYTES[17:],
    ],
    ids=["whole", "in the middle of a reply", "broken elsewhere", "cut at its beginning"],
)
def test_the_restart_banner_is_recognised_and_read_to_its_end(banner: bytes) -> None:
    with linked(Numbered({0: lambda reply: [banner[:40], 0.02, banner[40:]]})) as (link, _):
        with pytest.raises(Restarted):
            link.ask(N)
        assert link.ask(N) == all_of(2)
        assert link.wire.counts.restarts == 1
        assert link.wire.counts.unanswered == 0


def test_a_banner_that_came_unasked_is_noticed_before_the_next_request() -> None:
    with linked(Numbered({})) as (link, peer):
        link.ask(N)
        peer.say(BANNER_BYTES)
        time.sleep(0.05)
        with pytest.raises(Restarted):
            link.ask(H)
        assert peer.heard == [b"N"]


def test_insisting_sends_first_and_makes_sure_after() -> None:
    with linked(Numbered({})) as (link, peer):
        link.ask(Request("D", (5, 5)))
        link.insist(Request("D", (0, 0)))
        assert peer.heard == [b"D,5,5", b"D,0,0", b"E", b"D,0,0"]


def test_something_urgent_interrupts_what_is_overdue() -> None:
    with linked(lambda request, number: [], timeout=5.0) as (link, peer):
        link.interrupted = lambda: bool(peer.heard)
        begin = time.monotonic()
        with pytest.raises(Interrupted):
            link.ask(N)
        assert time.monotonic() - begin < 4.0


def test_what_may_not_be_repeated_is_not_sent() -> None:
    with linked(Numbered({})) as (link, peer):
        for request in (Request("G", (0, 0)), Request("restart")):
            with pytest.raises(ValueError, match="allowed: what may be sent twice"):
                link.ask(request)
        with pytest.raises(ValueError, match="999"):
            link.ask(Request("D", (999, 0)))
        assert peer.heard == []


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        ({"baud": 1200}, "baud 1200; allowed: 9600, 19200, 38400, 57600, 115200"),
        ({"timeout": 0.0}, "timeout 0.0; allowed: more than 0"),
        ({"timeout": float("nan")}, "timeout nan"),
        ({"tries": 0}, "tries 0; allowed: at least 1"),
    ],
)
def test_bad_arguments(arguments: dict[str, float], told: str) -> None:
    with pytest.raises(ValueError, match=told):
        SerialLink("/dev/null", **arguments)  # type: ignore[arg-type]


def test_a_port_that_is_not_there() -> None:
    with pytest.raises(ConnectionError, match=r"/dev/nowhere cannot be opened"):
        SerialLink("/dev/nowhere")


def test_one_program_at_a_time() -> None:
    with linked(Numbered({})) as (_, peer), pytest.raises(ConnectionError, match="cannot be opened"):
        SerialLink(peer.url)


def test_pyserial_missing_is_told_with_its_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    original = builtins.__import__

    def without_serial(name: str, *rest: object) -> object:
        if name == "serial":
            raise ImportError(name)
        return original(name, *rest)  # type: ignore[arg-type]

    monkeypatch.delitem(sys.modules, "serial", raising=False)
    monkeypatch.setattr(builtins, "__import__", without_serial)
    with pytest.raises(ImportError, match=r"pip install 'khepera-forage\[robots\]'"):
        SerialLink("/dev/nowhere")


def test_time_on_the_wire() -> None:
    assert seconds_on_wire(9600, 9600) == 11.0, "1 start, 8 data, 2 stop bits"
