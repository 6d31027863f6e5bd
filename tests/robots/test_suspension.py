"""A suspended program: its robots are stopped first, and continue only on command."""

import os
import signal
import subprocess

import pytest

from khepera_forage.robots.khepera import Motors
from khepera_forage.robots.real_robot import RobotSuspended
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from tests.robots.driver_process import start_driver, wait_for, wait_for_exit
from tests.robots.rig import FORWARD, make_rig, run_rounds

CONTINUE = """
from khepera_forage.robots.khepera import RobotLost
try:
    drive_and_receive()
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


def wait_for_suspension(child: "subprocess.Popen[str]") -> None:
    _, status = os.waitpid(child.pid, os.WUNTRACED)
    assert os.WIFSTOPPED(status)


def command(child: "subprocess.Popen[str]") -> str:
    """Send a line, and return the answer."""
    assert child.stdin is not None
    assert child.stdout is not None
    child.stdin.write("\n")
    child.stdin.flush()
    return child.stdout.readline()


@pytest.mark.parametrize(("name", "options"), [("SIGTSTP", "watchdog=False"), ("SIGSTOP", "")])
def test_suspended_program_stops_its_robots_until_the_next_command(name: str, options: str) -> None:
    """The watchdog stops them on SIGSTOP, which cannot be caught."""
    with make_rig(2) as rig:
        child = start_driver(
            [port.url for port in rig.ports], CONTINUE, options=options, stdin=subprocess.PIPE
        )
        assert child.stdout is not None
        assert rig.wheel_pulses(0) == rig.wheel_pulses(1) == (50, 50)
        child.send_signal(signal.Signals[name])
        wait_for_suspension(child)
        wait_for(rig.is_stopped)
        child.send_signal(signal.SIGCONT)
        assert "the program was suspended, and the robot was stopped" in child.stdout.readline()
        assert rig.is_stopped()
        assert command(child) == "(0, 0)\n"
        assert child.stdout.readline() == "(0, 0)\n"
        assert rig.is_stopped()
        assert command(child) == "driving\n"
        _, errors = wait_for_exit(child)
        assert errors.startswith(f"the program was suspended: stopped {rig.url}, {rig.ports[1].url};")


def test_suspended_program_with_resting_robots_continues_without_an_error() -> None:
    with make_rig(1) as rig, SerialKhepera(rig.url) as robot:
        run_rounds(rig, robot, Motors(0, 0, 215, 200))
        os.kill(os.getpid(), signal.SIGCONT)
        run_rounds(rig, robot, FORWARD)
        os.kill(os.getpid(), signal.SIGCONT)
        assert rig.is_stopped()
        with pytest.raises(RobotSuspended):
            robot.receive()
        run_rounds(rig, robot, FORWARD)
        assert rig.wheel_pulses() == (50, 50)


def test_motion_by_a_single_request_ends_with_a_suspension() -> None:
    with make_rig(1) as rig, SerialKhepera(rig.url) as robot:
        robot.request("D", 5, 5)
        os.kill(os.getpid(), signal.SIGCONT)
        assert rig.is_stopped()
        with pytest.raises(RobotSuspended):
            robot.request("H")
        robot.request("D", 5, 5)
        robot.request("D", 0, 0)
        os.kill(os.getpid(), signal.SIGCONT)
        robot.request("H")
