"""The wheels are stopped after every exit path: a child process drives, the parent observes the robot."""

import contextlib
import logging
import os
import signal
import time

import pytest

from khepera_forage.robots.epuck.firmware import EPuckFirmware
from khepera_forage.robots.khepera import Motors
from khepera_forage.robots.real_robot import RobotSuspended
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from khepera_forage.robots.serial.watchdog import Watchdog, start_watchdog
from khepera_forage.robots.virtual.firmware import Firmware
from tests.robots.driver_process import KHEPERA_DRIVER, answer, start_driver, tell, wait_for, wait_for_exit
from tests.robots.rfc2217_server import rfc2217_server
from tests.robots.rig import FORWARD, Rig, make_rig, run_rounds


def all_drive(rig: Rig) -> bool:
    """On a busy machine a round may take so long that the wheels are held until the next one."""
    return all(rig.wheel_pulses(number) == (50, 50) for number in range(len(rig.robots)))


@pytest.mark.parametrize(
    ("end", "status", "message"),
    [
        ("pass", 0, ""),
        ("raise KeyError('here')", 1, "KeyError: 'here'"),
        ("robots[0].close(); robots[0].close()", 0, ""),
        ("with robots[0], robots[1]: pass", 0, ""),
        ("os._exit(0)", 0, ""),
        ("import ctypes; ctypes.string_at(0)", -signal.SIGSEGV, ""),
        ("os.kill(os.getpid(), 9)", -signal.SIGKILL, ""),
        ("os.killpg(0, 9)", -signal.SIGKILL, ""),
        ("os.execv('/bin/true', ['true'])", 0, ""),
        ("os.kill(os.getpid(), signal.SIGINT)", -signal.SIGINT, "KeyboardInterrupt"),
    ],
)
def test_end_of_the_program_stops_the_robots(end: str, status: int, message: str) -> None:
    with make_rig(2) as rig:
        child = start_driver([port.url for port in rig.ports], f"drive_until_told()\n{end}")
        wait_for(lambda: all_drive(rig))
        tell(child)
        code, errors = wait_for_exit(child)
        assert code == status
        assert message in errors
        assert errors == "" or message
        wait_for(rig.is_stopped)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGUSR1])
def test_signal_stops_the_robots(number: signal.Signals) -> None:
    with make_rig(2, baud=38400) as rig:
        child = start_driver([port.url for port in rig.ports], "drive_until_told()")
        wait_for(lambda: all_drive(rig))
        child.send_signal(number)
        code, errors = wait_for_exit(child)
        wait_for(rig.is_stopped)  # by the watchdogs
        assert code == -number
        assert ("KeyboardInterrupt" in errors) == (number == signal.SIGINT)


def test_replaced_signal_handler_is_called() -> None:
    install = "import signal, sys\nsignal.signal(signal.SIGTERM, lambda number, frame: sys.exit(7))"
    with make_rig(1) as rig:
        child = start_driver([rig.url], "drive_until_told()", before=install)
        child.terminate()
        assert wait_for_exit(child) == (7, "")
        assert rig.is_stopped()


def test_forked_child_does_not_stop_the_robots() -> None:
    body = """
    drive_until_told()
    if os.fork() == 0:
        sys.exit(0)
    os.wait()
    print(robots[0].request("E"), flush=True)
    drive_until_told()
    """
    with make_rig(1) as rig:
        child = start_driver([rig.url], body)
        tell(child)
        assert answer(child) == "(0, 0)\n", "the line is as it was"
        wait_for(lambda: all_drive(rig))
        tell(child)
        assert wait_for_exit(child) == (0, "")


CONTINUE = """
from khepera_forage.robots.khepera import RobotLost
try:
    drive_until_told()
except RobotLost as error:
    print(error, flush=True)
sys.stdin.readline()
for robot in robots:
    try:
        robot.transmit()
    except RobotLost:  # a call that ended just before the suspension was noticed: this one reports it
        robot.transmit()
    print(robot.request("E"), flush=True)
sys.stdin.readline()
drive()
os.kill(os.getpid(), 9)
"""


@pytest.mark.parametrize(("name", "options"), [("SIGTSTP", "watchdog=False"), ("SIGSTOP", "")])
def test_suspended_program_stops_its_robots_until_the_next_command(name: str, options: str) -> None:
    """The watchdog stops them on SIGSTOP, which cannot be caught."""
    with make_rig(2) as rig:
        child = start_driver([port.url for port in rig.ports], CONTINUE, options=options)
        wait_for(lambda: all_drive(rig))
        child.send_signal(signal.Signals[name])
        assert os.WIFSTOPPED(os.waitpid(child.pid, os.WUNTRACED)[1])
        wait_for(rig.is_stopped)
        child.send_signal(signal.SIGCONT)
        assert "the program was suspended, and the robot was stopped" in answer(child)
        assert rig.is_stopped()
        tell(child)
        assert [answer(child), answer(child)] == ["(0, 0)\n"] * 2
        assert rig.is_stopped()
        tell(child)
        assert answer(child) == "driving\n"
        _, errors = wait_for_exit(child)
        assert errors.startswith(f"the program was suspended: stopped {rig.url}, {rig.ports[1].url};")


def test_only_turning_wheels_make_a_suspension_an_error() -> None:
    """Turning by `transmit`, or by a single request; an error is raised once."""
    with make_rig(1) as rig, SerialKhepera(rig.url) as robot:
        run_rounds(rig, robot, Motors(0, 0, 215, 200))
        os.kill(os.getpid(), signal.SIGCONT)
        for turn in (lambda: run_rounds(rig, robot, FORWARD), lambda: robot.request("D", 5, 5)):
            turn()
            os.kill(os.getpid(), signal.SIGCONT)
            assert rig.is_stopped()
            with pytest.raises(RobotSuspended):
                robot.request("H")
        run_rounds(rig, robot, FORWARD)
        assert rig.wheel_pulses() == (50, 50)
        run_rounds(rig, robot, Motors(0, 0, 215, 200))
        robot.request("D", 5, 5)
        robot.request("D", 0, 0)
        os.kill(os.getpid(), signal.SIGCONT)
        robot.request("H")


@pytest.mark.parametrize("robot", ["e-puck2", "socket", "rfc2217"])
def test_end_of_the_process_stops_another_robot_and_one_in_the_network(robot: str) -> None:
    ignore = "import warnings\nwarnings.simplefilter('ignore')"  # pyserial's
    kind, driver = (EPuckFirmware, "epuck.driver.SerialEPuck") if robot == "e-puck2" else (Firmware, KHEPERA_DRIVER)
    with make_rig(1, tcp=robot != "e-puck2", kind=kind) as rig, contextlib.ExitStack() as stack:
        url = stack.enter_context(rfc2217_server(rig.url)) if robot == "rfc2217" else rig.url
        child = start_driver([url], "drive_until_told()", before=ignore, driver=driver)
        wait_for(lambda: all_drive(rig))
        child.kill()
        wait_for(rig.is_stopped)
        wait_for_exit(child)


def test_frozen_process_stops_the_robot() -> None:
    """A call outside the interpreter blocks all threads for two seconds."""
    body = """
    import ctypes
    drive_until_told()
    ctypes.PyDLL(None).usleep(2_000_000)
    print("awake", flush=True)
    drive_until_told()
    """
    with make_rig(1) as rig:
        child = start_driver([rig.url], body)
        tell(child)
        wait_for(rig.is_stopped)
        assert [answer(child), answer(child)] == ["awake\n", "driving\n"]
        wait_for(lambda: all_drive(rig))
        child.kill()
        wait_for_exit(child)


def test_robot_that_confirms_no_stop_is_reported() -> None:
    with make_rig(1) as rig:
        rig.intercept(lambda line: b"" if line == b"D,0,0" and rig.firmware.turning else None)
        child = start_driver([rig.url], "drive(); os._exit(0)")
        _, errors = wait_for_exit(child)
        assert f"{rig.url} may still be moving: its driver has ended" in errors


def test_watchdog_ends_with_the_driver(no_leaks: None) -> None:
    with make_rig(1) as rig, SerialKhepera(rig.url) as robot:
        assert robot._watchdog is not None
        process = robot._watchdog._process
        run_rounds(rig, robot, FORWARD)
        assert process.poll() is None
    assert process.poll() == 0


def test_lost_watchdog_is_reported(caplog: pytest.LogCaptureFixture) -> None:
    reader, writer = os.pipe()
    watchdog = Watchdog("somewhere", writer, b"D,0,0\n")
    watchdog._process.kill()
    wait_for(lambda: "the watchdog of somewhere has ended" in caplog.text)
    watchdog.end()
    os.close(reader)
    os.close(writer)


def test_port_without_a_descriptor_has_no_watchdog(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        assert start_watchdog("loop://", None, b"") is None
    assert "loop:// has no watchdog" in caplog.text


def test_signals_that_the_driver_ignores_end_neither_it_nor_the_watchdog() -> None:
    signals = (signal.SIGHUP, signal.SIGINT, signal.SIGQUIT, signal.SIGTERM, signal.SIGTSTP)
    ignore = f"import signal\nfor n in {[*map(int, signals)]}: signal.signal(n, signal.SIG_IGN)"
    with make_rig(1) as rig:
        child = start_driver([rig.url], "drive_until_told()", before=ignore)
        for number in signals:
            os.killpg(child.pid, number)
        time.sleep(0.1)
        assert child.poll() is None
        wait_for(lambda: all_drive(rig))
        child.kill()
        wait_for(rig.is_stopped)
        wait_for_exit(child)
