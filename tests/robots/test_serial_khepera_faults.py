"""The driver on a disturbed line: restarts, disconnection, and correct senses under every fault."""

import time
from dataclasses import fields

import numpy as np
import pytest

from khepera_forage.robots.khepera import Motors, RobotLost
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from khepera_forage.robots.virtual.faults import Faults
from tests.robots.rig import FORWARD, make_rig, run_rounds


def test_restart_restores_the_command_and_continues_the_counters() -> None:
    with make_rig() as rig, SerialKhepera(rig.url) as robot:
        motors = Motors(5, 5, 255, 0)
        before = run_rounds(rig, robot, motors, 5)
        rig.firmwares[0].handle(b"T,1,E,215")
        rig.firmwares[0].handle(b"T,1,D,0")
        rig.ports[0].faults = Faults(reset=1.0)
        robot.begin_receive()
        while not rig.ports[0].fault_counts.reset:
            time.sleep(0.001)
        rig.ports[0].faults = Faults()
        after = run_rounds(rig, robot, motors, 25)
        assert robot.statistics.restarts >= 1
        assert rig.wheel_pulses() == (50, 50)
        assert (after.arm, after.jaw) == (255, 0)
        assert 0 <= after.left_pulses - before.left_pulses - 25 * 50 <= 50


def test_restart_without_banner_is_detected_by_the_counters() -> None:
    with make_rig() as rig, SerialKhepera(rig.url) as robot:
        motors = Motors(10, 10, 255, 0)
        before = run_rounds(rig, robot, motors, 20)
        rig.firmwares[0].handle(b"T,1,E,215")
        rig.firmwares[0].handle(b"T,1,D,0")
        rig.firmwares[0].power_on()
        after = run_rounds(rig, robot, motors, 25)
        assert robot.statistics.restarts == 0
        assert (after.arm, after.jaw) == (255, 0)
        assert 24 * 100 <= after.left_pulses - before.left_pulses <= 25 * 100


def test_robot_that_restarts_repeatedly_is_lost() -> None:
    with make_rig(seed=1) as rig:
        robot = SerialKhepera(rig.url)
        rig.ports[0].faults = Faults(reset=1.0)
        with pytest.raises(RobotLost, match="restarts again and again"):
            robot.receive()
        rig.ports[0].faults = Faults()
        robot.close()


def test_unplugged_robot_is_lost_at_once(caplog: pytest.LogCaptureFixture) -> None:
    with make_rig() as rig:
        robot = SerialKhepera(rig.url)
        run_rounds(rig, robot, FORWARD)
        rig.ports[0].faults = Faults(unplug=1.0)
        with pytest.raises(RobotLost, match="the port failed") as lost:
            robot.receive()
        assert lost.value.port == rig.url
        robot.close()
    assert "may still be moving" in caplog.text


ROUNDS = 150
RATES = {
    "drop": Faults(drop=0.02),
    "delay": Faults(delay=0.01, lateness=(0.08, 0.2)),
    "garble": Faults(garble=0.2),
    "duplicate": Faults(duplicate=0.2),
    "reset": Faults(reset=0.01),
    "all": Faults(drop=0.01, delay=0.005, garble=0.02, duplicate=0.05, reset=0.005, lateness=(0.08, 0.2)),
}


@pytest.mark.parametrize("name", RATES)
def test_senses_are_correct_under_faults(name: str) -> None:
    """Drive wheels, arm and jaw: the driver's senses equal those of the simulated robot in every round.

    What enters the experience is always right. A garbled digit may leave a well-formed reading of the infra-reds or the
    counters, which is wrong until the next round. After a restart the counters lack what came after
    their last reading.
    """
    with make_rig(faults=Faults(), seed=5) as rig, SerialKhepera(rig.url, baud=115200, timeout=0.05) as robot:
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
            if "reset" not in name and name != "all":
                wrong += senses[1:3] != truth[1:3]
                assert truth.left_pulses - before.left_pulses == 10 * left
                assert truth.right_pulses - before.right_pulses == 10 * right
        counts = rig.ports[0].fault_counts
        assert wrong <= counts.undetectable
        occurred = {
            field.name: getattr(counts, field.name) for field in fields(Faults) if hasattr(counts, field.name)
        }
        assert all(occurred[fault] for fault in (RATES if name == "all" else [name]) if fault != "all")
        rig.ports[0].faults = Faults()
        robot.receive()
        if "reset" not in name and name != "all":
            assert robot.sense() == rig.robots[0].sense()
    assert rig.is_stopped()


def test_unplugged_robot_that_had_confirmed_its_stop_is_not_reported_as_moving(
    caplog: pytest.LogCaptureFixture,
) -> None:
    with make_rig() as rig:
        robot = SerialKhepera(rig.url)
        run_rounds(rig, robot, FORWARD)
        robot.stop()
        rig.ports[0].faults = Faults(unplug=1.0)
        with pytest.raises(RobotLost, match="the port failed"):
            robot.receive()
        robot.close()
    assert caplog.text == ""
