"""Lines with a latency: measured when they are opened, pipelined, or rejected."""

import re
import time
from collections.abc import Callable

import pytest

from khepera_forage.lab.clock import WallClock
from khepera_forage.robots.khepera import CONTROL_PERIOD, Motors, RobotLost
from khepera_forage.robots.serial.errors import LineTooSlow
from khepera_forage.robots.serial.line_timing import LineTiming
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from khepera_forage.robots.virtual.faults import Faults
from tests.robots.rig import FORWARD, Rig, make_rig, run_rounds
from tests.robots.scripted_robot import Action, NumberedReplies, ScriptedRobot

SCHEDULING = 0.1
"""Seconds by which a busy machine may delay a round."""


def late(seconds: float) -> Faults:
    """Every reply is late by a constant time, as on a line with this latency."""
    return Faults(delay=1.0, lateness=(seconds, seconds))


def timed_rounds(rig: Rig, robot: SerialKhepera, rounds: int) -> list[float]:
    """Seconds from one end of a round to the next, with moving gripper and wheels."""
    taken, due = [], time.monotonic()
    end = due
    for number in range(rounds):
        down = number // 5 % 2 == 0
        due = max(due + CONTROL_PERIOD, time.monotonic())
        robot.drive(Motors(5, number % 9, 255 if down else 215, 0 if down else 200))
        robot.transmit()
        time.sleep(max(0.0, due - time.monotonic()))
        rig.advance()  # by a whole round, after the command has arrived
        robot.receive()
        taken.append(time.monotonic() - end)
        end = time.monotonic()
        assert robot.sense() == rig.robots[0].sense()
    return taken


@pytest.mark.parametrize("latency", [0.0, 0.016, 0.04, 0.08])
def test_round_ends_within_its_period_and_one_latency(latency: float) -> None:
    with make_rig(faults=late(latency)) as rig, SerialKhepera(rig.url) as robot:
        assert robot.timing.latency == pytest.approx(latency, abs=0.015)
        assert robot.timing.pipelined is (latency > 0)
        taken = sorted(timed_rounds(rig, robot, 15))
        assert taken[-2] < CONTROL_PERIOD + latency + SCHEDULING, (
            "all rounds but one, in which the machine is busy"
        )
        assert robot.statistics.unknown == 0
        assert robot.timeout >= 2 * robot.timing.latency
        robot.stop()
        assert rig.is_stopped()


def exchanges(rig: Rig, robot: SerialKhepera, rounds: int) -> list[float]:
    """Seconds from the beginning of each period until its readings have arrived and the next commands are sent."""
    clock, ends = WallClock(CONTROL_PERIOD), []
    for number in range(rounds):
        clock.wait()
        beginning = min(clock.beginning, time.monotonic())
        rig.advance()  # by a whole round, after the command has arrived
        unknown = robot.statistics.unknown
        robot.receive()
        assert robot.sense() == rig.robots[0].sense() or robot.statistics.unknown > unknown
        down = number // 5 % 2 == 0
        robot.drive(Motors(5, number % 9, 255 if down else 215, 0 if down else 200))
        robot.transmit()
        ends.append(time.monotonic() - beginning)
    return ends


@pytest.mark.parametrize("latency", [0.0, 0.005, 0.016, 0.03, 0.05, 0.08])
def test_exchange_ends_within_the_period_and_the_latency_from_the_beginning_of_its_period(
    latency: float,
) -> None:
    """At the pace of the line. A busy machine can delay a round: one of three attempts must be undisturbed."""
    for _ in range(3):
        with make_rig(baud=38400, faults=late(latency)) as rig, SerialKhepera(rig.url) as robot:
            robot.receive()
            bound = robot.timing._replace(latency=latency).latest_end(CONTROL_PERIOD)
            assert bound == pytest.approx(CONTROL_PERIOD + latency)
            ends = exchanges(rig, robot, 15)
        if max(ends) <= bound:
            return
    pytest.fail(f"a round ended {1000 * max(ends):.0f} ms after the beginning; at most {1000 * bound:.0f} ms")


@pytest.mark.parametrize("latency", [0.12, 0.3, 0.7, 1.0])
def test_line_that_cannot_keep_the_period_is_rejected(latency: float) -> None:
    with make_rig(faults=late(latency)) as rig:
        begin = time.monotonic()
        with pytest.raises(
            LineTooSlow, match=r"too slow for rounds of 0\.1 s: .* required: at most 8\d ms"
        ) as slow:
            SerialKhepera(rig.url)
        assert time.monotonic() - begin < 2.0
        measured = re.search(r"a reply takes (\d+) ms", str(slow.value))
        assert measured is not None
        assert int(measured[1]) == pytest.approx(1000 * latency, abs=15)
        assert "Lengthen the period" in str(slow.value)
        assert rig.is_stopped()


@pytest.mark.parametrize(("request_number", "stall"), [(0, 0.7), (1, 0.7), (3, 0.7), (5, 0.7)])
def test_line_with_one_stalled_reply_is_accepted(request_number: int, stall: float) -> None:
    """Request B, the stop, a measurement, and the pipelined requests: a busy machine can delay any of them."""
    replies = NumberedReplies({request_number: lambda reply: [stall, reply]})
    with ScriptedRobot(replies) as scripted, SerialKhepera(scripted.url) as robot:
        assert robot.timing.latency == pytest.approx(0, abs=0.05)
        assert robot.timing.round_time < CONTROL_PERIOD
        assert robot.timing.can_pipeline
        assert robot.timeout == pytest.approx(0.1, abs=0.05), "it follows from the usual latency"
        assert robot.stop_confirmed


def test_longer_period_accepts_a_slow_line() -> None:
    with make_rig(faults=late(0.2)) as rig:
        with SerialKhepera(rig.url, period=0.25) as robot:
            run_rounds(rig, robot, Motors(0, 0, 255, 0), 2)
            assert robot.sense() == rig.robots[0].sense()
        with SerialKhepera(rig.url, period=None) as robot:
            assert robot.timing.round_time == pytest.approx(0.22, abs=0.02)


def test_absent_robot_is_reported_within_two_seconds() -> None:
    with ScriptedRobot(lambda request, number: []) as scripted:
        begin = time.monotonic()
        with pytest.raises(RobotLost, match="no answer to 'B'"):
            SerialKhepera(scripted.url)
        assert time.monotonic() - begin < 2.5


def one_at_a_time(seconds: float) -> Callable[[bytes, int], list[Action]]:
    """A robot that executes a request only after it has answered the one before."""
    return lambda request, number: [seconds, *NumberedReplies({})(request, number)]


def test_robot_that_answers_one_request_at_a_time_is_not_pipelined() -> None:
    with ScriptedRobot(one_at_a_time(0.015)) as scripted, SerialKhepera(scripted.url) as robot:
        assert not robot.timing.pipelined
        assert robot.timing.round_time == pytest.approx(0.07, abs=0.03)
        sent = len(scripted.requests)
        robot.drive(FORWARD)
        robot.transmit()
        assert scripted.requests[sent:] == [b"D,5,5", b"T,1,E,215", b"T,1,D,0"]


def test_lost_reply_of_a_pipelined_round_is_requested_again() -> None:
    """Unless there is no time on a busy machine: then the reading is reported as unknown."""
    known = 0
    with make_rig(faults=Faults(delay=0.9, drop=0.1, lateness=(0.03, 0.03)), seed=4) as rig:
        with SerialKhepera(rig.url, timeout=0.05) as robot:
            assert robot.timing.pipelined
            for number in range(40):
                unknown = robot.statistics.unknown
                senses = run_rounds(rig, robot, Motors(number % 7, 5, 215 + 40 * (number // 5 % 2), 200))
                if robot.statistics.unknown == unknown:
                    assert senses == rig.robots[0].sense()
                    known += 1
            rig.ports[0].faults = Faults()
        assert known > 20
        assert rig.is_stopped()


@pytest.mark.parametrize("latency", [0.0, 0.1, 0.2])
def test_unexpected_reading_waits_for_the_next_round_if_there_is_no_time(latency: float) -> None:
    """An object appears: to request the reading again at once would end the round late on a slow line."""
    readings = {
        b"N": b"n,0,0,0,0,0,0,0,0",
        b"H": b"h,0,0",
        b"E": b"e,0,0",
        b"B": b"b,5.02,5.01",
        b"D,0,0": b"d",
        b"T,1,G": b"t,1,g,0",
        b"T,1,H,1": b"t,1,h,215",
        b"T,1,H,0": b"t,1,h,200",
    }
    period = 0.5
    with (
        ScriptedRobot(lambda request, number: [readings[request] + b"\r\n"]) as scripted,
        SerialKhepera(scripted.url, period=period) as robot,
    ):
        for _ in range(20):
            robot.receive()
        robot._thread.session.timing = LineTiming(9600, latency, latency > 0, can_pipeline=True)
        time.sleep(period - 0.015)
        readings[b"N"] = b"n,0,0,500,0,0,0,0,0"
        robot.receive()
        is_slow = latency > 0
        assert robot.sense().proximity[2] == (0 if is_slow else 500)
        assert robot.statistics.unknown == is_slow
        robot.receive()
        assert robot.sense().proximity[2] == 500
        assert robot.statistics.unknown == is_slow


@pytest.mark.parametrize(
    ("baud", "latency", "bound"),
    [(38400, 0.0, 0.124), (38400, 0.04, 0.14), (38400, 0.08, 0.18), (9600, 0.0, 0.246), (115200, 0.09, 0.19)],
)
def test_longest_round_is_the_period_and_the_latency_or_the_transmission(
    baud: int, latency: float, bound: float
) -> None:
    assert LineTiming(baud, latency, latency > 0).longest_round(0.1) == pytest.approx(bound, abs=0.001)


def test_timing_counts_the_latency_once_if_pipelined() -> None:
    assert LineTiming(38400, 0.05, False).round_time == pytest.approx(4 * 0.05 + 61 * 11 / 38400)
    assert LineTiming(38400, 0.05, True).round_time == pytest.approx(0.05 + 61 * 11 / 38400)


def test_doubtful_counters_are_read_again_without_a_timeout() -> None:
    """A blocked wheel turns less than commanded."""
    with make_rig(faults=late(0.03)) as rig, SerialKhepera(rig.url) as robot:
        run_rounds(rig, robot, Motors(0, 0, 215, 200), 3)
        robot.drive(Motors(20, 20, 215, 200))
        robot.transmit()
        begin, timeouts = time.monotonic(), robot.statistics.timeouts
        robot.receive()
        assert robot.statistics.timeouts == timeouts
        assert time.monotonic() - begin < 2 * 0.03 + SCHEDULING
        assert robot.sense().left_pulses == rig.robots[0].sense().left_pulses
