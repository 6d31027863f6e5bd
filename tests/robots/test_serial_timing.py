"""The times that the driver of a serial robot keeps: rounds, opening, stops; on lines with a clock of their own."""

import math
import re
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import pairwise

import pytest

from khepera_forage.lab.clock import WallClock
from khepera_forage.robots.khepera import Motors, RobotLost
from khepera_forage.robots.serial.line import LineTiming, LineTooSlow
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from khepera_forage.robots.serial.serial_robot import HOLD_AFTER, MAX_DURATION, MAX_UNATTENDED
from tests.robots.rig import FORWARD, make_stage
from tests.robots.simulated_line import Action, Script, SimulatedLine, first_replies

PERIOD = 0.1
VARIATION = 84
"""Bytes by which the replies to a `receive` differ, with and without positions of the gripper."""
POLLS = 0.011
"""Seconds: the driver notices a reply, or the end of a wait, up to two polls later."""


@contextmanager
def opened(
    monkeypatch: pytest.MonkeyPatch,
    script: Script | None = None,
    *,
    baud: int = 38400,
    latency: float = 0.0,
    **options: float | None,
) -> Iterator[tuple[SerialKhepera, SimulatedLine]]:
    """A robot on a line which replies as usual when it is closed, so that the stop is confirmed."""
    line = SimulatedLine(script, baud=baud, latency=latency).install(monkeypatch)
    with SerialKhepera("simulated", baud=baud, watchdog=False, **options) as robot:  # type: ignore[arg-type]
        yield robot, line
        line.script = first_replies()


def counting(line: SimulatedLine, count: int, lost: float = 0.0, late: list[Action] | None = None) -> Script:
    """Counters at a value; for `lost` seconds from now on, replies are late, or lost if it is None."""
    end = line.now + lost

    def script(request: bytes, reply: bytes) -> list[Action]:
        reply = b"h,%d,%d\r\n" % (count, count) if request == b"H" else reply
        if line.now >= end:
            return [reply]
        return [] if late is None else [*late, reply]

    return script


@pytest.mark.parametrize(
    ("baud", "latency"),
    [
        (baud, latency)
        for baud in (19200, 38400, 115200)
        for latency in (0.0, 0.016, 0.06, 0.08)
        # Rounds in which the gripper moves fit into the period.
        if LineTiming(baud, latency=latency, pipelined=True).duration(6, 103) <= PERIOD / 2 + latency
    ],
)
def test_rounds_keep_the_period_and_one_latency(baud: int, latency: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Wheels and gripper move, and an object interrupts the barrier now and then."""
    stage = make_stage()

    def script(request: bytes, reply: bytes) -> list[Action]:
        is_interrupted = request == b"T,1,G" and round_ // 7 % 2
        return [b"t,1,g,200\r\n" if is_interrupted else stage.firmware.handle(request)]

    round_ = 0
    with opened(monkeypatch, script, baud=baud, latency=latency) as (robot, line):
        assert robot.timing.latency == pytest.approx(latency, abs=POLLS)
        assert robot.timing.pipelined
        robot.receive()
        clock = WallClock(PERIOD, lambda: line.now, lambda seconds: line.sleep(line.now + seconds))
        robot.receive()
        end = line.now
        for round_ in range(60):
            clock.wait()
            begin = clock.beginning
            stage.advance(1)
            robot.receive()
            assert line.now - end <= PERIOD + max(latency, VARIATION * 11 / baud) + POLLS
            end = line.now
            down = round_ // 5 % 2 == 0
            robot.drive(Motors(5, round_ % 9, 255 if down else 215, 0 if down else 200))
            robot.transmit()
            assert line.now - begin <= PERIOD + latency + POLLS
            assert robot.sense().left_pulses == stage.robots[0].sense().left_pulses
        assert robot.statistics.timeouts == 0


@pytest.mark.parametrize("latency", [0.12, 0.3, 0.7, 1.0])
def test_line_that_cannot_keep_the_period_is_rejected(latency: float, monkeypatch: pytest.MonkeyPatch) -> None:
    line = SimulatedLine(latency=latency).install(monkeypatch)
    with pytest.raises(
        LineTooSlow, match=r"rounds of 0\.1 s: .* required: at most 8\d ms .*Lengthen the period"
    ) as slow:
        SerialKhepera("simulated", watchdog=False)
    measured = re.search(r"a reply takes (\d+) ms", str(slow.value))
    assert measured is not None
    assert int(measured[1]) == pytest.approx(1000 * latency, abs=1000 * POLLS)
    assert line.requests[1][0] < 2.0
    assert not [request for _, request in line.requests if request.startswith(b"D,") and request != b"D,0,0"]


@pytest.mark.parametrize("request_number", [0, 1, 3, 5])
def test_line_with_one_stalled_reply_is_accepted(request_number: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """The identity, the stop, a measurement, and the pipelined requests: a busy machine can delay any of them."""
    in_time: list[Callable[[bytes], list[Action]]] = [lambda reply: [reply]] * request_number
    with opened(monkeypatch, first_replies(*in_time, lambda reply: [0.7, reply])) as (robot, line):
        assert line.now < 2.0
        assert robot.timing.latency == pytest.approx(0, abs=POLLS)
        assert robot.longest_exchange < 0.25, "the time-out follows from the usual latency"
        assert robot.stop_confirmed


@pytest.mark.parametrize("period", [0.25, None])
def test_longer_period_accepts_a_slow_line(period: float | None, monkeypatch: pytest.MonkeyPatch) -> None:
    with opened(monkeypatch, latency=0.2, period=period) as (robot, line):
        assert robot.timing.round_time == pytest.approx(0.2 + 61 * 11 / 38400, abs=POLLS)
        robot.receive()
        assert line.now < 4.0


def test_absent_robot_is_reported_within_two_seconds(monkeypatch: pytest.MonkeyPatch) -> None:
    line = SimulatedLine(lambda request, reply: []).install(monkeypatch)
    with pytest.raises(RobotLost, match="no answer to 'B'"):
        SerialKhepera("simulated", watchdog=False)
    assert max(at for at, request in line.requests if request == b"B") < 2.0
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("port ")]


def test_robot_that_answers_one_request_at_a_time_gets_one_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    busy_until = 0.0

    def one_at_a_time(request: bytes, reply: bytes) -> list[Action]:
        nonlocal busy_until
        arrived = line.requests[-1][0]
        busy_until = max(busy_until, arrived) + 0.015
        return [busy_until - arrived, reply]

    line = SimulatedLine(one_at_a_time).install(monkeypatch)
    with SerialKhepera("simulated", watchdog=False) as robot:
        assert not robot.timing.pipelined
        assert robot.timing.round_time == pytest.approx(4 * 0.015 + 61 * 11 / 38400, abs=4 * POLLS)
        sent = len(line.requests)
        robot.drive(FORWARD)
        robot.transmit()
        assert line.sent_since(line.requests[sent - 1][0]) == [b"D,5,5", b"T,1,E,215", b"T,1,D,0"]
        times = [at for at, _ in line.requests[sent:]]
        assert all(later - earlier > 0.015 for earlier, later in pairwise(times))


def test_wheels_are_held_while_replies_are_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    """Requests arrive, but nothing is heard: the stop is sent before the robot counts as lost."""
    with opened(monkeypatch) as (robot, line):
        robot.drive(FORWARD)
        robot.transmit()
        line.script, begin = counting(line, 0, lost=math.inf), line.now
        with pytest.raises(RobotLost, match="received nothing"):
            robot.receive()
        assert line.now - begin <= MAX_DURATION + POLLS
        assert not robot.stop_confirmed
        stops = [at - begin for at, request in line.requests if request == b"D,0,0" and at > begin]
        assert HOLD_AFTER - POLLS <= stops[0] <= HOLD_AFTER + POLLS
        assert all(later - earlier <= HOLD_AFTER + POLLS for earlier, later in pairwise(stops))


@pytest.mark.parametrize(
    ("garbled", "confirmed_after"), [(b"", 0.1), (b"", 0.39), (b"", 0.47), (b"", math.inf), (b"D,", math.inf)]
)
@pytest.mark.parametrize("timeout", [0.1, 3.0])
@pytest.mark.parametrize("period", [0.1, 0.5])
def test_wheels_stop_within_the_limit_when_replies_are_garbled(
    garbled: bytes, period: float, timeout: float, confirmed_after: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """All replies, or those to speeds, which are sent again; if they are confirmed by chance, `receive` waits again."""

    def script(request: bytes, reply: bytes) -> list[Action]:
        chance = request == b"D,5,5" and line.now - fault >= confirmed_after
        is_garbled = not chance and request.startswith(garbled)
        return [reply.replace(reply[:1], b"?") if is_garbled else reply]

    with opened(monkeypatch, timeout=timeout, period=period) as (robot, line):
        clock = WallClock(period, lambda: line.now, lambda seconds: line.sleep(line.now + seconds))

        def rounds(count: int) -> None:
            for _ in range(count):
                robot.transmit()
                clock.wait()
                robot.receive()

        robot.drive(FORWARD)
        rounds(2)
        line.script, fault = script, line.now
        with pytest.raises(RobotLost, match="received only"):
            rounds(2)
        speeds = [(at - fault, request) for at, request in line.requests if request.startswith(b"D,")]
        turning = max(at for at, request in speeds if request == b"D,5,5")
        stopped = min(at for at, request in speeds if at > turning and request == b"D,0,0")
        assert stopped <= MAX_UNATTENDED + POLLS


@pytest.mark.parametrize("late", [0.0, 0.05, 0.08, 0.095, 0.2, 0.6])
def test_object_is_sensed_at_once_even_in_a_late_round(late: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """An unexpected reading is requested once more; it enters the experience of this round."""

    def present(request: bytes, reply: bytes) -> list[Action]:
        return [b"t,1,g,200\r\n"] if request == b"T,1,G" else [late if request == b"N" else 0.0, reply]

    with opened(monkeypatch) as (robot, line):
        for _ in range(3):
            robot.receive()
            assert robot.sense().object_presence == 0
        line.script = present
        robot.receive()
        assert robot.sense().object_presence == 255


@pytest.mark.parametrize("pause", [0.6, 3.0])
def test_counters_continue_after_a_pause_at_full_speed(pause: float, monkeypatch: pytest.MonkeyPatch) -> None:
    def script(request: bytes, reply: bytes) -> list[Action]:
        return [b"h,%d,%d\r\n" % ((round(2000 * line.now),) * 2) if request == b"H" else reply]

    with opened(monkeypatch, script, period=None) as (robot, line):
        for _ in range(4):
            line.sleep(line.now + pause)
            robot.receive()
        assert robot.sense().left_pulses == pytest.approx(2000 * line.now, abs=200)


@pytest.mark.parametrize("late", [[0.8], None], ids=["late", "lost for a second"])
def test_held_wheels_continue_with_the_next_command(late: list[Action] | None, monkeypatch: pytest.MonkeyPatch) -> None:
    """The wheels did not turn as commanded all the time, and the counters say so."""
    with opened(monkeypatch) as (robot, line):
        robot.drive(FORWARD)
        robot.transmit()
        robot.receive()
        line.script, begin = counting(line, 512, 1.0, late), line.now
        robot.receive()
        assert b"D,0,0" in line.sent_since(begin)
        assert not robot.stop_confirmed
        assert robot.sense().left_pulses == 512
        line.sleep(line.now + 5.0)  # for the replies to what was repeated
        robot.transmit()
        assert line.sent_since(begin, b"D,")[-1] == b"D,5,5"


def test_wheels_stay_held_in_a_transmit_that_restores_what_a_restart_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    """The command was sent twice in such a call, so that wheels turned again after they were held."""
    with opened(monkeypatch) as (robot, line):
        robot.drive(FORWARD)
        robot.transmit()
        for count in (2000, 5):
            line.script = counting(line, count)
            robot.receive()
        line.script, begin = counting(line, 5, lost=1.0), line.now
        robot.transmit()
        assert line.now > begin + 1.0
        assert line.sent_since(begin, b"D,")[-1] == b"D,0,0"


@pytest.mark.parametrize("wrong", [b"h,5000,5000", b"h,1,900", b"h,-490,490", b"h,20500,500"])
def test_wrong_counters_are_corrected_by_the_next_ones(wrong: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    """A reply whose digits were changed may be well-formed: no wrong count lasts, and none counts as a restart."""
    counts = iter([490, None, *range(500, 540, 10)])

    def script(request: bytes, reply: bytes) -> list[Action]:
        if request != b"H":
            return [reply]
        count = next(counts)
        return [wrong + b"\r\n" if count is None else b"h,%d,%d\r\n" % (count, count)]

    with opened(monkeypatch, script) as (robot, line):
        for _ in range(6):
            robot.receive()
        assert robot.sense()[1:3] == (530, 530)
        assert [request for _, request in line.requests if request.startswith(b"D,")] == [b"D,0,0"]
