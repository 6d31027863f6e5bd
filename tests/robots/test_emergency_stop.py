"""The wheels are stopped after every exit path: a child process drives, the parent observes the robot."""

import signal
import subprocess
import time

import pytest

from khepera_forage.robots.real_robot import stop_all
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from tests.robots.driver_process import start_driver, wait_for, wait_for_exit
from tests.robots.rig import FORWARD, make_rig


@pytest.mark.parametrize(
    ("body", "status", "message"),
    [
        ("drive()", 0, ""),
        ("drive(); sys.exit(3)", 3, ""),
        ("drive(); raise KeyError('here')", 1, "KeyError: 'here'"),
        ("drive(); robots[0].close(); robots[0].close()", 0, ""),
        ("with robots[0], robots[1]: drive()", 0, ""),
    ],
    ids=["normal exit", "sys.exit", "uncaught exception", "one closed", "with"],
)
def test_exit_stops_the_robots(body: str, status: int, message: str) -> None:
    with make_rig(2) as rig:
        child = start_driver([port.url for port in rig.ports], body)
        code, errors = wait_for_exit(child)
        assert code == status
        assert message in errors
        assert errors.count("\n") == 0 or message
        assert rig.is_stopped()


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT", "SIGALRM", "SIGXCPU", "SIGUSR1"])
@pytest.mark.parametrize(
    "body", ["drive(); time.sleep(60)", "drive_and_receive()"], ids=["idle", "during a request"]
)
def test_signal_stops_the_robots(name: str, body: str) -> None:
    number = signal.Signals[name]
    with make_rig(2, baud=38400) as rig:
        child = start_driver([port.url for port in rig.ports], body)
        # On a busy machine a round may have taken so long that the driver held the wheels until the next one.
        wait_for(lambda: rig.wheel_pulses(0) == rig.wheel_pulses(1) == (50, 50))
        child.send_signal(number)
        code, errors = wait_for_exit(child)
        wait_for(rig.is_stopped)  # by the watchdogs
        assert code == -number
        assert ("KeyboardInterrupt" in errors) == (name == "SIGINT")


def test_replaced_signal_handler_is_called() -> None:
    install = "import signal, sys\nsignal.signal(signal.SIGTERM, lambda number, frame: sys.exit(7))"
    with make_rig(1) as rig:
        child = start_driver([rig.url], "drive_and_receive()", before=install)
        child.terminate()
        code, errors = wait_for_exit(child)
        assert (code, errors) == (7, "")
        assert rig.is_stopped()


def test_ignored_signal_stays_ignored() -> None:
    body = """
    drive()
    sys.stdin.readline()
    """
    with make_rig(1) as rig:
        ignore = "import signal\nsignal.signal(signal.SIGHUP, signal.SIG_IGN)"
        child = start_driver([rig.url], body, before=ignore, stdin=subprocess.PIPE)
        child.send_signal(signal.SIGHUP)
        time.sleep(0.2)
        assert child.poll() is None
        assert rig.wheel_pulses() == (50, 50)
        child.communicate("\n", timeout=20)
        assert child.returncode == 0
        assert rig.is_stopped()


def test_forked_child_does_not_stop_the_robots() -> None:
    body = """
    drive()
    if os.fork() == 0:
        sys.exit(0)
    os.wait()
    print(robots[0].request("E"), flush=True)
    sys.stdin.readline()
    os._exit(0)
    """
    with make_rig(1) as rig:
        child = start_driver([rig.url], body, stdin=subprocess.PIPE)
        assert child.stdout is not None
        assert child.stdout.readline() == "(0, 0)\n"
        assert rig.wheel_pulses() == (50, 50)
        child.communicate("\n", timeout=20)


def test_failure_to_stop_one_robot_does_not_affect_others() -> None:
    with make_rig(2) as rig, SerialKhepera(rig.url) as robot:
        unstoppable = SerialKhepera(rig.ports[1].url)
        for each in (robot, unstoppable):
            each.drive(FORWARD)
            each.transmit()
        rig.ports[1].close()
        failed = stop_all((unstoppable, robot))
        assert rig.wheel_pulses(0) == (0, 0)
        assert [which for which, _ in failed] == [unstoppable]
        unstoppable.close()
