"""Several robots in parallel: time of a round, and stopping all when one is lost."""

import contextlib
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor

import pytest

from khepera_forage.robots.khepera import Motors, RobotLost
from khepera_forage.robots.real_robot import Fleet
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from khepera_forage.robots.virtual.virtual_khepera import Faults
from tests.robots.driver_process import wait_for
from tests.robots.rig import FORWARD, Rig, make_rig, run_rounds


@contextlib.contextmanager
def make_fleet(count: int) -> Iterator[tuple[Rig, Fleet]]:
    with make_rig(count) as rig:
        robots = [SerialKhepera(port.url, baud=115200, timeout=0.05) for port in rig.ports]
        with Fleet(robots) as fleet:
            yield rig, fleet
            for port in rig.ports:
                port.faults = Faults()


def test_each_robot_receives_its_own_command() -> None:
    with make_fleet(8) as (rig, fleet):
        for round_ in range(12):
            for number, robot in enumerate(fleet.robots):
                robot.drive(Motors(number, round_ - 5, 255 if number % 2 else 215, 200))
            fleet.transmit()
            rig.advance()
            fleet.receive()
            for robot, truth in zip(fleet.robots, rig.robots, strict=True):
                assert robot.sense() == truth.sense()
    assert rig.is_stopped()


def test_robots_are_served_in_parallel() -> None:
    """Each robot replies only after the other one was asked."""
    with make_fleet(2) as (rig, fleet):
        asked = [threading.Event(), threading.Event()]
        for number, firmware in enumerate(rig.firmwares):

            def handle(line: bytes, number: int = number, handle: Callable[[bytes], bytes] = firmware.handle) -> bytes:
                if line == b"N":
                    asked[number].set()
                    asked[1 - number].wait(20.0)
                return handle(line)

            firmware.handle = handle  # type: ignore[method-assign]
        fleet.receive()


@pytest.mark.parametrize("lost", [[1], [0, 1]])
def test_lost_robots_stop_all_and_are_named(lost: list[int]) -> None:
    with make_fleet(3) as (rig, fleet):
        run_rounds(rig, fleet, FORWARD, 2)
        for number in lost:
            rig.ports[number].faults = Faults(unplug=1.0)
        with pytest.raises(RobotLost, match="the port failed") as loss:
            run_rounds(rig, fleet, FORWARD)
        assert loss.value.port in [rig.ports[number].url for number in lost]
        assert [port.url in str(loss.value) for port in rig.ports] == [i in lost for i in range(3)]
        assert str(loss.value).count("also lost") == len(lost) - 1
        assert rig.wheel_pulses(0) == rig.wheel_pulses(2) == (0, 0)
        fleet.robots[2].transmit()
        assert rig.wheel_pulses(2) == (0, 0), "the old command was discarded"


def test_slow_robot_holds_the_others() -> None:
    with make_fleet(2) as (rig, fleet):
        run_rounds(rig, fleet, FORWARD, 2)
        rig.ports[0].faults = Faults(delay=1.0, lateness=(0.3, 0.3))
        late = fleet.robots[0].begin(fleet.robots[0]._receive)
        wait_for(lambda: rig.ports[0].fault_counts["delay"] > 0)
        rig.ports[0].faults = Faults()
        fleet.receive()
        late.result(5.0)
        assert rig.wheel_pulses(1) == (0, 0), "held"
        assert rig.wheel_pulses(0) == (50, 50)
        fleet.transmit()
        assert rig.wheel_pulses(1) == (50, 50), "the command was kept"


@pytest.mark.parametrize("report", [True, False])
def test_robot_that_does_not_confirm_is_named_when_all_stop_and_logged_once_or_not_at_all(
    report: bool, caplog: pytest.LogCaptureFixture
) -> None:
    with make_fleet(2) as (rig, fleet):
        run_rounds(rig, fleet, FORWARD)
        rig.ports[0].faults = Faults(unplug=1.0)
        with pytest.raises(RobotLost, match="D,0,0") as lost:
            fleet.stop()
        assert lost.value.port == rig.ports[0].url
        assert rig.wheel_pulses(1) == (0, 0)
        fleet.close(report=report)
        assert [rig.ports[0].url in message for message in caplog.messages] == [True] * report
        with pytest.raises(ConnectionError, match="is closed"):
            fleet.transmit()


def test_invalid_fleets_are_rejected() -> None:
    with pytest.raises(ValueError, match="at least one"):
        Fleet([])
    with make_rig() as rig, SerialKhepera(rig.url) as robot, pytest.raises(ValueError, match="on its own port"):
        Fleet([robot, robot])


@pytest.mark.parametrize("is_late", [False, True], ids=["in time", "a little late"])
def test_silent_robot_stops_the_others_before_it_counts_as_lost(is_late: bool) -> None:
    """Also one that is done after the others were held."""
    with make_fleet(2) as (rig, fleet), ThreadPoolExecutor() as pool:
        run_rounds(rig, fleet, FORWARD, 2)
        rig.ports[0].interrupted = True
        rig.ports[1].faults = Faults(delay=float(is_late), lateness=(0.15, 0.15))
        waiting = pool.submit(fleet.receive)
        time.sleep(0.1 * is_late)
        rig.ports[1].faults = Faults()
        while rig.firmwares[1].turning:
            assert not waiting.done()
            time.sleep(0.002)
        rig.ports[0].interrupted = not is_late
        lost = waiting.exception()
        assert lost is None if is_late else isinstance(lost, RobotLost) and lost.port == rig.url
        assert not rig.firmwares[1].turning
        rig.ports[0].interrupted = False
