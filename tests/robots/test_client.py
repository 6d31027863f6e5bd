"""The protocol client: timeouts, retries and reply matching on a disturbed line."""

import time

import pytest

from khepera_forage.robots.khepera import RobotLost
from khepera_forage.robots.serial.client import ProtocolClient
from khepera_forage.robots.serial.errors import RequestInterrupted, RequestRejected, RobotRestarted
from khepera_forage.robots.serial.protocol import BANNER, Reply, Request
from khepera_forage.robots.serial.traffic import Traffic
from tests.robots.clients import connected_client, reply_to_n
from tests.robots.scripted_robot import Action, NumberedReplies

N = Request("N")
H = Request("H")
ARM, JAW = Request("T,1,H", (1,)), Request("T,1,H", (0,))
BANNER_BYTES = b"".join(line.encode() + b"\r\n" for line in BANNER)


def test_request_returns_its_reply() -> None:
    with connected_client(NumberedReplies({})) as (client, scripted):
        traffic: list[Traffic] = []
        client.transport.on_traffic = traffic.append
        assert client.request(N) == reply_to_n(1)
        assert client.request(ARM) == Reply("T,1,H", (2,))
        assert scripted.requests == [b"N", b"T,1,H,1"]
        assert b"".join(t.data for t in traffic if t.sent) == b"N\nT,1,H,1\n"
        assert b"".join(t.data for t in traffic if not t.sent) == b"n,1,1,1,1,1,1,1,1\r\nt,1,h,2\r\n"


@pytest.mark.parametrize("end", [b"\r", b"\n", b"\r\n"])
def test_replies_may_arrive_in_pieces_with_any_line_ending(end: bytes) -> None:
    def in_pieces(reply: bytes) -> list[Action]:
        body = reply.rstrip() + end
        return [piece for byte in body for piece in (bytes((byte,)), 0.002)]

    # The pieces alone take half of the usual timeout, and longer on a busy machine.
    with connected_client(NumberedReplies({0: in_pieces, 1: in_pieces}), timeout=1.0) as (client, _):
        assert client.request(N) == reply_to_n(1)
        assert client.request(H) == Reply("H", (2, 2))
        assert client.transport.statistics.timeouts == 0


def test_garbled_and_unmatched_lines_are_ignored() -> None:
    other_lines = [
        b"N\r\n",
        b"t,2,b,1\r\n",
        b"h,4,5\r\n",
        b"\r\n\r\n",
        b"\xff\x80\r\n",
        b"n,1,2\r\n",
        b"hello there\r\n",
    ]
    with connected_client(NumberedReplies({0: lambda reply: [b"".join(other_lines) + reply]})) as (
        client,
        scripted,
    ):
        assert client.request(N) == reply_to_n(1)
        assert scripted.requests == [b"N"]
        assert client.transport.statistics.unmatched == 1
        assert client.transport.statistics.garbled == 5


def test_unrequested_input_is_discarded() -> None:
    with connected_client(NumberedReplies({})) as (client, scripted):
        scripted.send(b"n,9,9,9,9,9,9,9,9\r\nn,9,9")
        time.sleep(0.05)
        assert client.request(N) == reply_to_n(len(scripted.requests))


def test_request_is_repeated_at_once_after_a_garbled_reply() -> None:
    with connected_client(NumberedReplies({0: lambda reply: [b"n,1,1,1,\x8f,1,1,1,1\r\n"]}), timeout=5.0) as (
        client,
        scripted,
    ):
        begin = time.monotonic()
        assert client.request(N) == reply_to_n(len(scripted.requests))
        assert time.monotonic() - begin < 4.0, "it does not wait for the timeout"


def test_silent_robot_is_lost() -> None:
    with connected_client(lambda request, number: [], timeout=0.01, tries=4) as (client, scripted):
        with pytest.raises(RobotLost, match="received nothing") as lost:
            client.request(Request("D", (3, -3)))
        assert (lost.value.port, lost.value.command, lost.value.tries) == (scripted.url, "D,3,-3", 4)
        assert len(scripted.requests) == 4


def test_robot_that_ignores_one_command_is_lost() -> None:
    def ignores_n(request: bytes, number: int) -> list[Action]:
        return [] if request == b"N" else NumberedReplies({})(request, number)

    with connected_client(ignores_n, timeout=0.01, tries=3) as (client, scripted):
        with pytest.raises(RobotLost):
            client.request(N)
        assert scripted.requests.count(b"N") == 3


def test_garbled_replies_hint_at_the_baud_rate() -> None:
    with (
        connected_client(lambda request, number: [b"\x80\xf8\r\n"], timeout=0.01, tries=2) as (client, _),
        pytest.raises(RobotLost, match="is the robot set to 115200 baud"),
    ):
        client.request(N)


def test_well_formed_replies_give_no_hint_at_the_baud_rate() -> None:
    """The robot answers everything but N, to which it sends a line that is cut off."""

    def cut_off(request: bytes, number: int) -> list[Action]:
        return [b"n,1,2\r\n"] if request == b"N" else NumberedReplies({})(request, number)

    with (
        connected_client(cut_off, timeout=0.01, tries=2) as (client, _),
        pytest.raises(RobotLost, match=r"received only b'n,1,2'$"),
    ):
        client.request(N)


def test_repeated_error_replies_raise_request_rejected() -> None:
    with connected_client(lambda request, number: [b"z,Protocol error\r\n"], tries=3) as (client, _):
        with pytest.raises(RequestRejected, match="it replied z,Protocol error"):
            client.request(Request("T,1,G"))
        assert client.transport.statistics.rejected >= 3


def test_request_is_repeated_after_one_error_reply() -> None:
    with connected_client(NumberedReplies({0: lambda reply: [b"z,Command not found\r\n"]})) as (
        client,
        scripted,
    ):
        assert client.request(N) == reply_to_n(len(scripted.requests))


def test_disconnected_robot_is_lost_without_more_tries() -> None:
    with connected_client(NumberedReplies({})) as (client, scripted):
        client.request(N)
        scripted.disconnect()
        with pytest.raises(RobotLost, match="'H' was not sent: the port failed") as lost:
            client.request(H)
        assert lost.value.tries == 0


@pytest.mark.parametrize(
    "banner",
    [
        BANNER_BYTES,
        b"n,1,2," + BANNER_BYTES,
        b"ROM of minirobot\r\nKHEPERA\r\n" + b"some words\r\n" * 15,
        BANNER_BYTES[17:],
    ],
    ids=["complete", "after a partial reply", "other line breaks", "without its beginning"],
)
def test_restart_banner_is_recognised_and_discarded(banner: bytes) -> None:
    with connected_client(NumberedReplies({0: lambda reply: [banner[:40], 0.02, banner[40:]]})) as (
        client,
        _,
    ):
        with pytest.raises(RobotRestarted):
            client.request(N)
        assert client.request(N) == reply_to_n(2)
        assert client.transport.statistics.restarts == 1
        assert client.transport.statistics.timeouts == 0


def test_banner_between_requests_is_noticed_before_the_next_request() -> None:
    with connected_client(NumberedReplies({})) as (client, scripted):
        client.request(N)
        scripted.send(BANNER_BYTES)
        time.sleep(0.05)
        with pytest.raises(RobotRestarted):
            client.request(H)
        assert scripted.requests == [b"N"]


def test_request_at_once_is_sent_before_the_synchronisation() -> None:
    with connected_client(NumberedReplies({})) as (client, scripted):
        client.request(Request("D", (5, 5)))
        client.request_at_once(Request("D", (0, 0)))
        assert scripted.requests == [b"D,5,5", b"D,0,0", b"E", b"D,0,0"]


def test_overdue_request_can_be_interrupted() -> None:
    with connected_client(lambda request, number: [], timeout=5.0) as (client, scripted):
        client.exchange.interrupted = lambda: bool(scripted.requests)
        begin = time.monotonic()
        with pytest.raises(RequestInterrupted):
            client.request(N)
        assert time.monotonic() - begin < 4.0


def test_commands_that_may_not_be_repeated_are_rejected() -> None:
    with connected_client(NumberedReplies({})) as (client, scripted):
        for request in (Request("G", (0, 0)), Request("restart")):
            with pytest.raises(ValueError, match="allowed: commands that may be sent twice"):
                client.request(request)
        with pytest.raises(ValueError, match="999"):
            client.request(Request("D", (999, 0)))
        assert scripted.requests == []


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"baud": 1200}, "baud 1200; allowed: 9600, 19200, 38400, 57600, 115200"),
        ({"timeout": 0.0}, "timeout 0.0; allowed: more than 0"),
        ({"timeout": float("nan")}, "timeout nan"),
        ({"tries": 0}, "tries 0; allowed: at least 1"),
    ],
)
def test_invalid_arguments_are_rejected(arguments: dict[str, float], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ProtocolClient("/dev/null", **arguments)  # type: ignore[arg-type]
