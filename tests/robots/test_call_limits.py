"""How long wheels run on while nothing is heard, and how long a call takes at most."""

import time

import numpy as np
import pytest

from khepera_forage.robots.khepera import Motors, RobotLost
from khepera_forage.robots.serial.call_limits import HOLD_AFTER, MAX_DURATION
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from khepera_forage.robots.virtual.faults import Faults
from tests.robots.rig import FORWARD, make_rig, run_rounds
from tests.robots.scripted_robot import Action, NumberedReplies, ScriptedRobot


def test_wheels_are_stopped_while_replies_are_missing() -> None:
    """Requests arrive, but nothing is heard: the stop is sent before the robot counts as lost."""
    mute = False

    def script(request: bytes, number: int) -> list[Action]:
        if request.startswith(b"D,"):
            speeds.append((time.monotonic(), request))
        return [] if mute else NumberedReplies({})(request, number)

    speeds: list[tuple[float, bytes]] = []
    with ScriptedRobot(script) as scripted, SerialKhepera(scripted.url) as robot:
        robot.drive(FORWARD)
        robot.transmit()
        assert speeds[-1][1] == b"D,5,5"
        mute = True
        begin = time.monotonic()
        with pytest.raises(RobotLost, match="received nothing"):
            robot.receive()
        assert time.monotonic() - begin < MAX_DURATION + 1.0
        mute = False
        first_stop = next(moment for moment, request in speeds if request == b"D,0,0" and moment > begin)
        assert HOLD_AFTER <= first_stop - begin < HOLD_AFTER + 0.3


def test_held_wheels_continue_with_the_next_command() -> None:
    with make_rig() as rig, SerialKhepera(rig.url) as robot:
        run_rounds(rig, robot, FORWARD, 2)
        rig.ports[0].faults = Faults(delay=1.0, lateness=(0.8, 0.8))
        task = robot.begin_receive()
        while not rig.ports[0].fault_counts.delay:
            time.sleep(0.001)
        rig.ports[0].faults = Faults()
        task.result(5.0)
        assert rig.is_stopped()
        assert not robot.stop_confirmed
        robot.transmit()
        assert rig.wheel_pulses() == (50, 50)


def test_repeated_speeds_do_not_start_held_wheels() -> None:
    """The replies to speeds are garbled: the speeds arrive, but are not confirmed, and are sent again and again."""
    garbled = False

    def script(request: bytes, number: int) -> list[Action]:
        if request.startswith(b"D,"):
            speeds.append((time.monotonic(), request))
            if garbled:
                return [0.08, b"?\r\n"]
        return NumberedReplies({})(request, number)

    speeds: list[tuple[float, bytes]] = []
    with ScriptedRobot(script) as scripted, SerialKhepera(scripted.url) as robot:
        garbled = True
        begin = time.monotonic()
        robot.drive(FORWARD)
        with pytest.raises(RobotLost, match="received only"):
            robot.transmit()
        garbled = False
        turning = [moment - begin for moment, request in speeds if request == b"D,5,5" and moment > begin]
        assert turning
        assert max(turning) < HOLD_AFTER + 0.3
        assert speeds[-1][1] == b"D,0,0"


def test_motion_by_a_single_request_is_sent_again_after_a_hold() -> None:
    """The first reply to the speeds is late: the wheels are stopped meanwhile."""
    late = [0.8]

    def script(request: bytes, number: int) -> list[Action]:
        delay = [late.pop()] if request == b"D,5,5" and late else []
        return [*delay, *NumberedReplies({})(request, number)]

    with ScriptedRobot(script) as scripted, SerialKhepera(scripted.url) as robot:
        robot.request("D", 5, 5)
        speeds = [request for request in scripted.requests if request.startswith(b"D,")]
        assert speeds == [b"D,0,0", b"D,5,5", b"D,0,0", b"D,5,5"]


def test_rounds_with_late_replies_are_bounded() -> None:
    """A fifth of the replies is late by 0.2 to 0.6 s, as over a disturbed radio link."""
    with make_rig(seed=1) as rig, SerialKhepera(rig.url) as robot:
        rig.ports[0].faults = Faults(delay=0.2, lateness=(0.2, 0.6))
        rng = np.random.default_rng(1)
        longest = 0.0
        for number in range(25):
            left, right = (int(speed) for speed in rng.integers(-20, 21, 2))
            begin = time.monotonic()
            senses = run_rounds(rig, robot, Motors(left, right, 215 + 40 * (number // 10 % 2), 200))
            longest = max(longest, time.monotonic() - begin)
            assert senses == rig.robots[0].sense()
        # Twice the lateness and the time-out, a second reading, and a busy machine.
        assert 0.2 < longest < 2 * (0.6 + robot.timeout) + HOLD_AFTER + 0.3
        rig.ports[0].faults = Faults()
    assert rig.is_stopped()


@pytest.mark.parametrize("seed", range(3))
def test_counters_are_correct_with_a_fifth_of_garbage(seed: int) -> None:
    """Unless they are reported as unknown, as on a busy machine, which leaves no time to request them again."""
    known = 0
    with make_rig(faults=Faults(), seed=seed) as rig, SerialKhepera(rig.url, timeout=0.05) as robot:
        rig.ports[0].faults = Faults(garble=0.2)
        rng = np.random.default_rng(seed)
        for _ in range(100):
            left, right = (int(speed) for speed in rng.integers(-20, 21, 2))
            unknown = robot.statistics.unknown
            senses = run_rounds(rig, robot, Motors(left, right, 215, 200))
            truth = rig.robots[0].sense()
            if robot.statistics.unknown == unknown:
                assert abs(senses.left_pulses - truth.left_pulses) <= 60
                assert abs(senses.right_pulses - truth.right_pulses) <= 60
                known += 1
        assert known > 50
        assert rig.ports[0].fault_counts.undetectable > 0
        rig.ports[0].faults = Faults()


def test_unknown_counters_keep_their_value_until_a_reading_is_confirmed() -> None:
    """The robot's counters contradict each other in one round."""
    confused = False
    noise = iter(range(1, 100))

    def script(request: bytes, number: int) -> list[Action]:
        if request == b"H":
            value = 5000 * next(noise) if confused else 1000
            return [b"h,%d,%d\r\n" % (value, value)]
        return NumberedReplies({0: lambda reply: [reply]})(request, 10)

    with ScriptedRobot(script) as scripted, SerialKhepera(scripted.url) as robot:
        robot.receive()
        assert robot.sense().left_pulses == 1000
        confused = True
        robot.receive()
        assert robot.sense().left_pulses == 1000
        assert robot.statistics.unknown == 1
        confused = False
        robot.receive()
        assert (robot.sense().left_pulses, robot.statistics.unknown) == (1000, 1)
