"""A robot behind a serial port: the real driver, real bytes, a virtual Khepera."""

import threading
import time
from dataclasses import fields

import numpy as np
import pytest

from khepera_forage.robots.khepera import Motors, RobotLost, Senses
from khepera_forage.robots.serial.line_events import Traffic
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from khepera_forage.robots.virtual.line_faults import Faults
from tests.robots.peer import Numbered, Peer
from tests.robots.rig import FORWARD, Rig, rig

from .rfc2217_server import served

STILL = Motors(0, 0, 215, 200)


def play(built: Rig, robot: SerialKhepera, motors: Motors, rounds: int = 1) -> Senses:
    for _ in range(rounds):
        robot.drive(motors)
        robot.transmit()
        built.advance()
        robot.receive()
    return robot.sense()


@pytest.mark.parametrize("tcp", [False, True], ids=["pty", "tcp"])
def test_it_senses_and_does_what_the_simulated_robot_does(tcp: bool) -> None:
    with rig(tcp=tcp) as built, SerialKhepera(built.url) as robot:
        assert robot.sense() == built.robots[0].sense()
        for motors in (Motors(5, 5, 255, 0), Motors(-3, 4, 215, 200), STILL):
            for _ in range(13):
                assert play(built, robot, motors) == built.robots[0].sense()
        assert robot.counts.sent == robot.counts.answered


def test_driving_sends_nothing_and_tells_what_will_be_applied() -> None:
    with rig() as built, SerialKhepera(built.url, max_speed=8) as robot:
        sent = robot.counts.sent
        assert robot.drive(Motors(99.0, -3.4, 300, 90)) == Motors(8, -3, 255, 0)
        assert robot.counts.sent == sent
        with pytest.raises(ValueError, match="nan"):
            robot.drive(Motors(float("nan"), 0, 215, 200))
        robot.transmit()
        assert built.wheels() == (80, -30)


def requests(robot: SerialKhepera, built: Rig, motors: Motors, rounds: int) -> list[list[str]]:
    """What is asked and told, round by round."""
    heard: list[Traffic] = []
    robot.listen(heard.append)
    told = []
    for _ in range(rounds):
        play(built, robot, motors)
        told.append([t.data.decode().strip() for t in heard if t.sent])
        heard.clear()
    robot.listen(None)
    return told


def test_only_what_a_step_needs_is_asked() -> None:
    with rig() as built, SerialKhepera(built.url) as robot:
        play(built, robot, STILL, 12)
        for told in requests(robot, built, FORWARD, 9):
            assert told[:1] == ["D,5,5"]
            assert [t for t in told if t[:5] != "T,1,H"] == ["D,5,5", "N", "T,1,G", "H"]
        first, *others = requests(robot, built, FORWARD._replace(arm=255), 4)
        assert "T,1,E,255" in first
        assert all(told == ["D,5,5", "N", "T,1,H,1", "T,1,G", "H"] or "T,1,H,0" in told for told in others)
        first, second, *_ = requests(robot, built, Motors(5, 5, 255, 0), 2)
        assert "T,1,D,1" in first
        assert "T,1,H,0" in second


def test_senses_stay_until_received_anew() -> None:
    with rig() as built, SerialKhepera(built.url) as robot:
        before = robot.sense()
        robot.drive(FORWARD)
        robot.transmit()
        built.advance()
        assert robot.sense() == before
        robot.receive()
        assert robot.sense().left_pulses == before.left_pulses + 50


def test_readings_of_a_real_turret_are_brought_into_range() -> None:
    with Peer(Numbered({})) as peer, SerialKhepera(peer.url, baud=115200) as robot:
        senses = robot.sense()
        assert senses.arm == 215, "it says less than 100"
        assert 0 <= senses.jaw <= 200
        assert senses.object_presence == 0


def test_opening_stops_wheels_that_another_program_left_turning() -> None:
    with rig() as built:
        built.firmwares[0].answer(b"D,5,5")
        assert built.wheels() == (50, 50)
        with SerialKhepera(built.url):
            assert built.stands()


def test_a_command_that_another_program_left_unfinished_does_no_harm() -> None:
    with rig() as built:
        with open(built.url, "wb", buffering=0) as port:
            port.write(b"D,5")
        with SerialKhepera(built.url) as robot:
            assert robot.sense() == built.robots[0].sense()


def test_stop_stops_and_leaves_the_gripper() -> None:
    with rig() as built, SerialKhepera(built.url) as robot:
        play(built, robot, Motors(5, 5, 255, 0), 3)
        robot.stop()
        assert built.stands()
        for _ in range(20):
            robot.transmit()
            built.advance()
            robot.receive()
        assert built.stands()
        assert (robot.sense().arm, robot.sense().jaw) == (255, 0)
        play(built, robot, FORWARD)
        assert built.wheels() == (50, 50)


def test_stop_comes_before_what_the_line_is_busy_with() -> None:
    """The robot is deaf to N: stopping does not wait until it is lost."""

    def deaf_to_n(request: bytes, number: int) -> list[bytes | float]:
        return [] if request == b"N" else Numbered({})(request, number)

    with Peer(deaf_to_n) as peer:
        robot = SerialKhepera(peer.url, baud=115200, timeout=1.0)
        robot.drive(FORWARD)
        robot.transmit()
        task = robot.begin_receive()
        while b"N" not in peer.heard:
            time.sleep(0.001)
        robot.stop()
        assert b"D,0,0" in peer.heard[peer.heard.index(b"N") :]
        assert peer.heard.count(b"N") <= 2
        assert not task.done
        begin = time.monotonic()
        robot.close()
        assert time.monotonic() - begin < 3.0
        with pytest.raises(ConnectionError, match="is closed"):
            task.result(1.0)


def test_stop_in_the_middle_of_a_transmission_is_not_undone_by_it() -> None:
    """The first D is swallowed, so it would be sent again; the stop comes meanwhile."""

    def deaf_once(request: bytes, number: int) -> list[bytes | float]:
        return [] if request == b"D,5,5" else Numbered({})(request, number)

    with Peer(deaf_once) as peer, SerialKhepera(peer.url, baud=115200, timeout=1.0) as robot:
        robot.drive(FORWARD)
        task = robot.begin_transmit()
        while b"D,5,5" not in peer.heard:
            time.sleep(0.001)
        robot.stop()
        task.result(5.0)
        assert peer.heard.count(b"D,5,5") == 1
        assert peer.heard[-1].startswith((b"D,0,0", b"T,1,"))


def test_close_stops_and_frees_the_port_and_again_does_nothing() -> None:
    with rig() as built:
        for _ in range(2):
            robot = SerialKhepera(built.url)
            play(built, robot, FORWARD, 2)
            robot.close()
            robot.close()
            robot.stop()
            assert built.stands()
            with pytest.raises(ConnectionError, match="is closed"):
                robot.transmit()
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("port ")]


def test_leaving_with_an_error_stops() -> None:
    with rig() as built:
        try:
            with SerialKhepera(built.url) as robot:
                play(built, robot, FORWARD, 2)
                raise KeyError
        except KeyError:
            assert built.stands()


def test_nobody_there_is_a_lost_robot_and_leaves_nothing_behind() -> None:
    with (
        Peer(lambda request, number: []) as peer,
        pytest.raises(RobotLost, match="'B' after 2 tries"),
    ):
        SerialKhepera(peer.url, timeout=0.01, tries=2)
    assert not [thread for thread in threading.enumerate() if thread.name.startswith("port ")]


@pytest.mark.parametrize("speed", [0, 21, -3])
def test_bad_max_speed(speed: int) -> None:
    with pytest.raises(ValueError, match=f"max_speed {speed}; allowed: 1..20"):
        SerialKhepera("/dev/null", max_speed=speed)


def test_any_other_command() -> None:
    with rig() as built, SerialKhepera(built.url) as robot:
        assert robot.ask("B") == ("5.02", "5.01")
        assert robot.ask("L", 0, 1) == ()
        with pytest.raises(ValueError, match="allowed"):
            robot.ask("G", 0, 0)


def test_after_a_restart_the_robot_is_told_again_and_its_counters_go_on() -> None:
    with rig() as built, SerialKhepera(built.url) as robot:
        motors = Motors(5, 5, 255, 0)
        before = play(built, robot, motors, 5)
        built.firmwares[0].answer(b"T,1,E,215")
        built.firmwares[0].answer(b"T,1,D,0")
        built.ports[0].faults = Faults(reset=1.0)
        robot.begin_receive()
        while not built.ports[0].counts.reset:
            time.sleep(0.001)
        built.ports[0].faults = Faults()
        after = play(built, robot, motors, 25)
        assert robot.counts.restarts >= 1
        assert built.wheels() == (50, 50)
        assert (after.arm, after.jaw) == (255, 0)
        assert 0 <= after.left_pulses - before.left_pulses - 25 * 50 <= 50


def test_a_restart_that_nobody_saw_is_noticed_by_the_counters() -> None:
    with rig() as built, SerialKhepera(built.url) as robot:
        motors = Motors(10, 10, 255, 0)
        before = play(built, robot, motors, 20)
        built.firmwares[0].answer(b"T,1,E,215")
        built.firmwares[0].answer(b"T,1,D,0")
        built.firmwares[0].power_on()
        after = play(built, robot, motors, 25)
        assert robot.counts.restarts == 0
        assert (after.arm, after.jaw) == (255, 0)
        assert 24 * 100 <= after.left_pulses - before.left_pulses <= 25 * 100


def test_a_supply_that_fails_all_the_time_is_a_lost_robot() -> None:
    with rig(seed=1) as built:
        robot = SerialKhepera(built.url)
        built.ports[0].faults = Faults(reset=1.0)
        with pytest.raises(RobotLost, match="starts anew again and again"):
            robot.receive()
        built.ports[0].faults = Faults()
        robot.close()


def test_a_pulled_plug_is_a_lost_robot_at_once(caplog: pytest.LogCaptureFixture) -> None:
    with rig() as built:
        robot = SerialKhepera(built.url)
        play(built, robot, FORWARD)
        built.ports[0].faults = Faults(unplug=1.0)
        begin = time.monotonic()
        with pytest.raises(RobotLost, match="the line is gone") as lost:
            robot.receive()
        assert time.monotonic() - begin < 1.0
        assert lost.value.port == built.url
        robot.close()
    assert "may still be moving" in caplog.text


ROUNDS = 150
RATES = {
    "drop": Faults(drop=0.02),
    "delay": Faults(delay=0.01, lateness=(0.08, 0.2)),
    "garble": Faults(garble=0.04),
    "duplicate": Faults(duplicate=0.2),
    "reset": Faults(reset=0.01),
    "all": Faults(drop=0.01, delay=0.005, garble=0.02, duplicate=0.05, reset=0.005, lateness=(0.08, 0.2)),
}


@pytest.mark.parametrize("name", RATES)
def test_senses_are_right_whatever_happens_on_the_line(name: str) -> None:
    """Rounds of wheels, arm and jaw: every round senses what the simulated robot does.

    After a restart, counters lack what the wheels did since they were read last; a garbled digit may leave a reading
    that does not surprise, so those of infra-reds and counters may be off by what does not.
    """
    with rig(faults=Faults(), seed=5) as built, SerialKhepera(built.url, baud=115200, timeout=0.05) as robot:
        built.ports[0].faults = RATES[name]
        rng = np.random.default_rng(1)
        for number in range(ROUNDS):
            if number % 30 == 0:
                arm, jaw = (int(v) for v in (rng.choice((215, 255)), rng.choice((0, 200))))
            left, right = (int(v) for v in rng.integers(-8, 9, 2))
            applied = Motors(left, right, arm, jaw)
            assert robot.drive(applied) == applied
            before = built.robots[0].sense()
            robot.transmit()
            built.advance()
            robot.receive()
            truth, senses = built.robots[0].sense(), robot.sense()
            assert (senses.arm, senses.jaw, senses.object_presence) == truth[3:]
            assert max(abs(a - b) for a, b in zip(senses.proximity, truth.proximity, strict=True)) <= 200
            if "reset" not in name and name != "all":
                assert abs(senses.left_pulses - truth.left_pulses) <= 60
                assert truth.left_pulses - before.left_pulses == 10 * left
                assert truth.right_pulses - before.right_pulses == 10 * right
        counts = built.ports[0].counts
        happened = {
            field.name: getattr(counts, field.name) for field in fields(Faults) if hasattr(counts, field.name)
        }
        assert all(happened[fault] for fault in (RATES if name == "all" else [name]) if fault != "all")
        built.ports[0].faults = Faults()
    assert built.stands()


@pytest.mark.filterwarnings("ignore:set(Daemon|Name):DeprecationWarning")  # pyserial's own
def test_over_a_serial_device_server() -> None:
    with rig(tcp=True) as built, served(built.url) as url, SerialKhepera(url) as robot:
        for _ in range(5):
            assert play(built, robot, Motors(5, 4, 255, 0)) == built.robots[0].sense()
        robot.stop()
        assert built.stands()
