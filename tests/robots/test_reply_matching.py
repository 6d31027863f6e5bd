"""Reply matching: late and repeated replies are never taken for the current one."""

import time

import pytest

from khepera_forage.robots.khepera import RobotLost
from khepera_forage.robots.serial.protocol import Reply, Request
from khepera_forage.robots.serial.reply_matching import PendingReplies
from tests.robots.clients import connected_client, reply_to_n
from tests.robots.scripted_robot import Action, NumberedReplies

N = Request("N")
H = Request("H")
ARM, JAW = Request("T,1,H", (1,)), Request("T,1,H", (0,))
LATE = 0.3
"""Seconds, more than the timeout of the tests."""


def test_late_reply_to_an_earlier_request_is_not_matched() -> None:
    with connected_client(NumberedReplies({0: lambda reply: [LATE, reply]}), tries=1) as (client, scripted):
        with pytest.raises(RobotLost):
            client.request(N)
        client.tries = 6
        assert client.request(N) == reply_to_n(len(scripted.requests))
        assert scripted.requests[-1] == b"N"
        assert client.transport.statistics.unmatched >= 1


def test_late_reply_is_matched_to_its_own_request() -> None:
    """Sending the request again would take longer, and the robot could be late again."""
    with connected_client(NumberedReplies({0: lambda reply: [LATE, reply]})) as (client, scripted):
        assert client.request(N) == reply_to_n(1)
        assert scripted.requests.count(b"N") == 1
        for _ in range(3):
            for request in (H, ARM, N):
                assert client.request(request).values[0] == len(scripted.requests)


def test_late_arm_position_is_not_matched_to_a_jaw_request() -> None:
    with connected_client(NumberedReplies({0: lambda reply: [LATE, reply]}), tries=1) as (client, scripted):
        with pytest.raises(RobotLost):
            client.request(ARM)
        client.tries = 6
        answer = client.request(JAW)
        assert scripted.requests[-1] == b"T,1,H,0"
        assert answer == Reply("T,1,H", (len(scripted.requests),))


def test_partly_received_late_reply_is_not_matched() -> None:
    def interrupted(reply: bytes) -> list[Action]:
        return [reply[:3], LATE, reply[3:]]

    with connected_client(NumberedReplies({0: interrupted})) as (client, scripted):
        assert client.request(N) == reply_to_n(len(scripted.requests))


def test_repeated_reply_is_not_matched_to_the_next_request() -> None:
    twice = {number: (lambda reply: [reply, 0.01, reply]) for number in range(9)}
    with connected_client(NumberedReplies(twice)) as (client, scripted):
        for request in (N, N, ARM, JAW, N):
            value = client.request(request).values[0]
            assert value == len(scripted.requests)


def test_reply_to_a_stop_sent_meanwhile_stays_pending() -> None:
    """The stop is sent behind requests whose replies are late: its own reply arrives after theirs."""
    pending = PendingReplies()
    for command in ("N", "T,1,G", "D"):
        pending.sent(Request(command))
    pending.answered(Request("N"))
    pending.answered(Request("T,1,G"))
    assert pending.among(["D", "N"]) == {"D"}


def test_late_replies_in_turn_are_awaited_together() -> None:
    late = {number: (lambda reply: [LATE, reply]) for number in range(3)}
    with connected_client(NumberedReplies(late)) as (client, scripted):
        begin = time.monotonic()
        replies = client.request_in_turn([N, ARM, Request("T,1,G"), JAW, H])
        # The scripted robot answers one request after the other.
        assert time.monotonic() - begin < 3 * LATE + 0.2
        assert [reply.command for reply in replies] == ["N", "T,1,H", "T,1,G", "T,1,H", "H"]
        assert [request for request in scripted.requests if request != b"E"][:5] == [
            b"N",
            b"T,1,H,1",
            b"T,1,G",
            b"T,1,H,0",
            b"H",
        ]


def test_no_synchronisation_between_different_commands() -> None:
    with connected_client(NumberedReplies({})) as (client, scripted):
        for _ in range(3):
            for request in (Request("D", (1, 1)), N, ARM, Request("T,1,G"), JAW, H):
                client.request(request)
        assert len(scripted.requests) == 18


def test_each_retry_uses_a_synchronisation_request_that_is_not_pending() -> None:
    """The reply to an earlier request is later than several retries: still it is not matched to this one."""
    with connected_client(NumberedReplies({0: lambda reply: [1.2, reply]}), timeout=0.05, tries=1) as (
        client,
        scripted,
    ):
        with pytest.raises(RobotLost):
            client.request(N)
        client.tries = 6
        assert client.request(N) == reply_to_n(len(scripted.requests))
        syncs = scripted.requests[1:-1]
        assert len(syncs) == len(set(syncs)) >= 3, "none is sent again while its reply is pending"
