"""Several robots at once: one round trip for all, and all stop when one is lost."""

import contextlib
import threading
import time
from collections.abc import Iterator

import pytest

from khepera_forage.robots.khepera import Motors, RobotLost
from khepera_forage.robots.serial.fleet import Fleet
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from khepera_forage.robots.virtual.line_faults import Faults
from tests.robots.peer import Numbered, Peer, Said
from tests.robots.rig import FORWARD, Rig, rig


@contextlib.contextmanager
def fleet(count: int, *, baud: int | None = None) -> Iterator[tuple[Rig, Fleet]]:
    with rig(count, baud=baud) as built:
        robots = [SerialKhepera(port.url, baud=baud or 115200, timeout=0.05) for port in built.ports]
        with Fleet(robots) as together:
            yield built, together
            for port in built.ports:
                port.faults = Faults()


def play(built: Rig, together: Fleet, motors: Motors, rounds: int = 1) -> None:
    for _ in range(rounds):
        for robot in together.robots:
            robot.drive(motors)
        together.transmit()
        built.advance()
        together.receive()


@pytest.mark.parametrize("count", [1, 2, 8])
def test_each_robot_is_told_and_asked_its_own(count: int) -> None:
    with fleet(count) as (built, together):
        for round_ in range(12):
            for number, robot in enumerate(together.robots):
                robot.drive(Motors(number, round_ - 5, 255 if number % 2 else 215, 200))
            together.transmit()
            built.advance()
            together.receive()
            for robot, truth in zip(together.robots, built.robots, strict=True):
                assert robot.sense() == truth.sense()
    assert built.stands()


def test_four_robots_cost_about_what_one_costs() -> None:
    """By the line's own pace: at 9600 baud a round of one takes far longer than all that the computer does for four."""
    taken = []
    for count in (1, 4):
        with fleet(count, baud=9600) as (built, together):
            play(built, together, FORWARD, 2)
            begin = time.monotonic()
            play(built, together, FORWARD, 2)
            taken.append(time.monotonic() - begin)
    assert taken[1] < 2.5 * taken[0], "one after the other it would be four times as long"


def test_one_lost_all_stop_and_the_loss_is_raised() -> None:
    with fleet(3) as (built, together):
        play(built, together, FORWARD, 2)
        built.ports[1].faults = Faults(unplug=1.0)
        with pytest.raises(RobotLost, match="the line is gone") as lost:
            play(built, together, FORWARD)
        assert lost.value.port == built.ports[1].url
        assert "also lost" not in str(lost.value)
        assert built.wheels(0) == built.wheels(2) == (0, 0)
        for robot in (together.robots[0], together.robots[2]):
            robot.transmit()
        assert built.wheels(0) == built.wheels(2) == (0, 0), "they wait for a new command"


def test_several_lost_are_all_named() -> None:
    with fleet(3) as (built, together):
        play(built, together, FORWARD)
        for port in built.ports[:2]:
            port.faults = Faults(unplug=1.0)
        with pytest.raises(RobotLost, match="also lost") as lost:
            play(built, together, FORWARD)
        assert all(port.url in str(lost.value) for port in built.ports[:2])
        assert built.ports[2].url not in str(lost.value)
        assert built.wheels(2) == (0, 0)


def test_one_that_takes_long_is_waited_for_by_the_others_at_rest() -> None:
    with fleet(2) as (built, together):
        play(built, together, FORWARD, 2)
        built.ports[0].faults = Faults(delay=1.0, lateness=(0.5, 0.5))
        for robot in together.robots:
            robot.drive(FORWARD)
        late = together.robots[0].begin_receive()
        time.sleep(0.05)
        built.ports[0].faults = Faults()
        together.receive()
        late.result(5.0)
        assert built.wheels(1) == (0, 0), "held"
        assert built.wheels(0) == (50, 50)
        together.transmit()
        assert built.wheels(1) == (50, 50), "the command stayed"


def test_a_silent_robot_does_not_keep_the_others_going() -> None:
    """While one is asked again and again, and long before it is given up, the other stands."""

    def falls_silent(request: bytes, number: int) -> list[Said]:
        return Numbered({})(request, number) if number < 2 else []

    with rig() as built, Peer(falls_silent) as peer:
        robot = SerialKhepera(built.url)
        silent = SerialKhepera(peer.url, timeout=0.1, tries=3)
        robot.drive(FORWARD)
        robot.transmit()
        assert built.wheels() == (50, 50)
        together = Fleet([robot, silent])
        silent.drive(FORWARD)
        losses: list[RobotLost] = []

        def transmit() -> None:
            try:
                together.transmit()
            except RobotLost as lost:
                losses.append(lost)

        waiting = threading.Thread(target=transmit)
        waiting.start()
        time.sleep(0.02)
        while built.wheels() != (0, 0):
            assert waiting.is_alive(), "it stands before the other is given up"
            time.sleep(0.01)
        waiting.join()
        assert losses[0].port == peer.url
        assert built.wheels() == (0, 0)
        together.close()
        assert b"D,0,0" in peer.heard[2:], "it may hear although it is not heard"


def test_stop_and_close() -> None:
    with fleet(3) as (built, together):
        play(built, together, FORWARD, 2)
        together.stop()
        assert built.stands()
        play(built, together, FORWARD, 2)
        together.close()
        assert built.stands()
        together.close()
        with pytest.raises(ConnectionError, match="is closed"):
            together.transmit()


def test_stop_says_who_did_not_confirm() -> None:
    with fleet(2) as (built, together):
        play(built, together, FORWARD)
        built.ports[0].faults = Faults(unplug=1.0)
        with pytest.raises(RobotLost, match="D,0,0") as lost:
            together.stop()
        assert lost.value.port == built.ports[0].url
        assert built.wheels(1) == (0, 0)


def test_what_is_no_fleet() -> None:
    with pytest.raises(ValueError, match="at least one"):
        Fleet([])
    with rig() as built, SerialKhepera(built.url) as robot, pytest.raises(ValueError, match="of its own"):
        Fleet([robot, robot])
