"""The driver of a real Khepera, connected to a virtual one: senses, commands, stopping and closing."""

import threading
from collections.abc import Iterator

import numpy as np
import pytest

from khepera_forage.robots.khepera import Motors, RobotLost
from khepera_forage.robots.serial import serial_robot
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from khepera_forage.robots.virtual.virtual_khepera import Faults
from tests.robots.driver_process import wait_for
from tests.robots.rig import FORWARD, make_rig, run_rounds

STILL = Motors(0, 0, 215, 200)


def test_drive_sends_nothing_and_returns_the_applied_command() -> None:
    with make_rig() as rig, SerialKhepera(rig.url, max_speed=8) as robot:
        sent = robot.statistics.sent
        assert robot.drive(Motors(99.0, -3.4, 300, 90)) == Motors(8, -3, 255, 0)
        assert robot.statistics.sent == sent
        robot.transmit()
        assert rig.wheel_pulses() == (80, -30)
        robot.turn_wheels(20, -9)
        assert rig.wheel_pulses() == (80, -80)


def test_round_sends_only_necessary_requests() -> None:
    with make_rig() as rig, SerialKhepera(rig.url, timeout=5.0) as robot:
        received = rig.intercept()

        def requests_per_round(motors: Motors, rounds: int) -> Iterator[list[bytes]]:
            for _ in range(rounds):
                received.clear()
                run_rounds(rig, robot, motors)
                yield list(received)

        run_rounds(rig, robot, STILL, 12)
        for sent in requests_per_round(FORWARD, 9):
            assert sent[:1] == [b"D,5,5"]
            assert [line for line in sent if line[:5] != b"T,1,H"] == [b"D,5,5", b"N", b"T,1,G", b"H"]
        first, *others = requests_per_round(FORWARD._replace(arm=255), 4)
        assert b"T,1,E,255" in first
        for sent in others:
            assert sent == [b"D,5,5", b"N", b"T,1,H,1", b"T,1,G", b"H"] or b"T,1,H,0" in sent
        first, second = requests_per_round(Motors(5, 5, 255, 0), 2)
        assert b"T,1,D,1" in first
        assert b"T,1,H,0" in second


def test_stop_interrupts_a_pending_request() -> None:
    """The robot ignores N: `stop` does not wait until it counts as lost."""
    with make_rig() as rig:
        robot = SerialKhepera(rig.url, timeout=1.0)
        run_rounds(rig, robot, FORWARD)
        requests = rig.intercept(lambda line: b"" if line == b"N" else None)
        task = robot.begin(robot._receive)
        wait_for(lambda: b"N" in requests)
        robot.stop()
        assert b"D,0,0" in requests
        assert not task.done
        robot.close()
        with pytest.raises(ConnectionError, match="is closed"):
            task.result(1.0)


def test_stop_during_transmit_is_not_undone_by_it() -> None:
    """The robot does not confirm the speeds, which would be sent again; `stop` is called before that."""
    with make_rig() as rig, SerialKhepera(rig.url, timeout=1.0) as robot:
        requests = rig.intercept(lambda line: b"" if line == b"D,5,5" else None)
        robot.drive(FORWARD)
        task = robot.begin(robot._transmit)
        wait_for(lambda: b"D,5,5" in requests)
        robot.stop()
        task.result(5.0)
        assert b"D,5,5" not in requests[requests.index(b"D,0,0") :]
        assert not rig.firmware.turning


def test_opening_and_closing_stop_the_robot_and_release_the_port() -> None:
    with make_rig() as rig:
        for _ in range(2):
            rig.firmware.handle(b"D,5,5")  # another program has left the wheels turning
            assert rig.wheel_pulses() == (50, 50)
            robot = SerialKhepera(rig.url)
            assert rig.is_stopped()
            run_rounds(rig, robot, FORWARD, 2)
            robot.close()
            robot.close()
            robot.stop()
            assert rig.is_stopped()
            with pytest.raises(ConnectionError, match="is closed"):
                robot.transmit()
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("port ")]


@pytest.mark.parametrize("speed", [0, 21, -3])
def test_max_speed_out_of_range_is_rejected(speed: int) -> None:
    with pytest.raises(ValueError, match=f"max_speed {speed}; allowed: 1..20"):
        SerialKhepera("/dev/null", max_speed=speed)


@pytest.mark.parametrize("banner", [True, False], ids=["banner", "noticed by the counters"])
def test_restart_restores_the_command_and_after_a_banner_the_counters(banner: bool) -> None:
    with make_rig() as rig, SerialKhepera(rig.url) as robot:
        motors = Motors(10, 10, 255, 0)
        before = run_rounds(rig, robot, motors, 20)
        rig.firmware.handle(b"T,1,E,215")
        rig.firmware.handle(b"T,1,D,0")
        if banner:
            rig.ports[0].faults = Faults(reset=1.0)
            robot.begin(robot._receive)
            wait_for(lambda: rig.ports[0].fault_counts["reset"] > 0)
            rig.ports[0].faults = Faults()
        else:
            rig.firmware.power_on()
        after = run_rounds(rig, robot, motors, 25)
        assert (robot.statistics.restarts > 0) == banner
        assert rig.wheel_pulses() == (100, 100)
        assert (after.arm, after.jaw) == (255, 0)
        if banner:
            assert abs(after.left_pulses - before.left_pulses - 25 * 100) <= 100, "at most a round is lost"


def test_robot_that_restarts_repeatedly_is_lost() -> None:
    with make_rig(seed=1) as rig:
        robot = SerialKhepera(rig.url)
        rig.ports[0].faults = Faults(reset=1.0)
        with pytest.raises(RobotLost, match="restarts again and again"):
            robot.receive()
        rig.ports[0].faults = Faults()
        robot.close()


def test_robot_that_had_stopped_before_it_was_unplugged_is_not_said_to_move(caplog: pytest.LogCaptureFixture) -> None:
    with make_rig() as rig:
        robot = SerialKhepera(rig.url)
        run_rounds(rig, robot, FORWARD)
        robot.stop()
        rig.ports[0].faults = Faults(unplug=1.0)
        with pytest.raises(RobotLost, match="the port failed"):
            robot.receive()
        robot.close()
    assert caplog.text == ""


ROUNDS = 150
RATES = {
    "drop": Faults(drop=0.02),
    "delay": Faults(delay=0.01, lateness=(0.08, 0.2)),
    "garble": Faults(garble=0.2),
    "all": Faults(drop=0.01, delay=0.005, garble=0.02, duplicate=0.05, reset=0.005, lateness=(0.08, 0.2)),
}


@pytest.mark.parametrize("name", RATES)
def test_senses_are_correct_under_faults(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Drive wheels, arm and jaw: the driver's senses equal those of the simulated robot in every round.

    What enters the experience is always right. A garbled digit may leave a well-formed reading of the infra-reds or the
    counters, which is wrong until the next round. After a restart the counters lack what came after
    their last reading.
    """
    monkeypatch.setattr(serial_robot, "HOLD_AFTER", 60.0)  # a round may take long on a busy machine
    with make_rig(seed=5) as rig, SerialKhepera(rig.url, baud=115200, timeout=0.05) as robot:
        rig.ports[0].faults = RATES[name]
        rng, wrong = np.random.default_rng(1), 0
        for number in range(ROUNDS):
            if number % 30 == 0:
                arm, jaw = (int(v) for v in (rng.choice((215, 255)), rng.choice((0, 200))))
            left, right = (int(v) for v in rng.integers(-8, 9, 2))
            applied = Motors(left, right, arm, jaw)
            assert robot.drive(applied) == applied
            before = rig.robots[0].sense()
            robot.transmit()
            rig.advance()
            robot.receive()
            truth, senses = rig.robots[0].sense(), robot.sense()
            assert (senses.arm, senses.jaw, senses.object_presence) == truth[3:]
            wrong += senses.proximity != truth.proximity
            if name != "all":
                wrong += senses[1:3] != truth[1:3]
                assert truth.left_pulses - before.left_pulses == 10 * left
                assert truth.right_pulses - before.right_pulses == 10 * right
        counts = rig.ports[0].fault_counts
        assert wrong <= counts["undetectable"]
        wanted = ("drop", "delay", "garble", "duplicate", "reset") if name == "all" else (name,)
        assert all(counts[fault] for fault in wanted)
        rig.ports[0].faults = Faults()
        robot.receive()
        if name != "all":
            assert robot.sense() == rig.robots[0].sense()
    assert rig.is_stopped()
