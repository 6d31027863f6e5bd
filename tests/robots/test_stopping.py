"""The wheels are stopped after every exit path: a child process drives, the parent observes the robot."""

import contextlib
import logging
import os
import signal
import subprocess
import time

import pytest

from khepera_forage.robots.khepera import Motors
from khepera_forage.robots.real_robot import RobotSuspended, stop_all
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from khepera_forage.robots.serial.watchdog import Watchdog, start_watchdog
from tests.robots.driver_process import start_driver, wait_for, wait_for_exit
from tests.robots.rfc2217_server import rfc2217_server
from tests.robots.rig import FORWARD, make_rig, run_rounds
from tests.robots.scripted_robot import Action, NumberedReplies, ScriptedRobot


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


def last_speeds(robot: ScriptedRobot) -> bytes:
    """The last speed command that a robot has received."""
    return next(request for request in reversed(robot.requests) if request.startswith(b"D,"))


@pytest.mark.parametrize(
    "end",
    [
        "os._exit(0)",
        "os.abort()",
        "import ctypes; ctypes.string_at(0)",
        "os.kill(os.getpid(), 9)",
        "os.killpg(0, 9)",
        "os.execv('/bin/true', ['true'])",
    ],
    ids=["_exit", "abort", "crash", "kill", "kill of the group", "exec"],
)
def test_end_of_the_process_stops_the_robot(end: str) -> None:
    with ScriptedRobot(NumberedReplies({})) as robot:
        child = start_driver([robot.url], f"drive(); sys.stdin.readline(); {end}", stdin=subprocess.PIPE)
        assert last_speeds(robot) == b"D,5,5"
        assert child.stdin is not None
        child.stdin.write("\n")
        child.stdin.flush()
        child.wait()
        wait_for(lambda: last_speeds(robot) == b"D,0,0")
        assert wait_for_exit(child)[1].count("may still be moving") == 0


@pytest.mark.parametrize("scheme", ["socket", "rfc2217"])
def test_end_of_the_process_stops_a_robot_in_the_network(scheme: str) -> None:
    ignore = "import warnings\nwarnings.simplefilter('ignore')"  # pyserial's
    with make_rig(1, tcp=True) as rig, contextlib.ExitStack() as stack:
        url = stack.enter_context(rfc2217_server(rig.url)) if scheme == "rfc2217" else rig.url
        child = start_driver([url], "drive(); time.sleep(60)", before=ignore)
        assert rig.wheel_pulses() == (50, 50)
        child.kill()
        wait_for(rig.is_stopped)
        wait_for_exit(child)


def test_frozen_process_stops_the_robot() -> None:
    """A call outside the interpreter blocks all threads for two seconds."""
    body = """
    import ctypes
    drive()
    ctypes.PyDLL(None).usleep(2_000_000)
    print("awake", flush=True)
    robots[0].transmit()
    print("driving again", flush=True)
    time.sleep(60)
    """
    with ScriptedRobot(NumberedReplies({})) as robot:
        child = start_driver([robot.url], body)
        assert last_speeds(robot) == b"D,5,5"
        wait_for(lambda: last_speeds(robot) == b"D,0,0")
        assert child.stdout is not None
        assert child.stdout.readline() == "awake\n"
        assert child.stdout.readline() == "driving again\n"
        assert last_speeds(robot) == b"D,5,5"
        child.kill()
        wait_for_exit(child)


def test_robot_that_confirms_no_stop_is_reported() -> None:
    def deaf_to_stops(request: bytes, number: int) -> list[Action]:
        if request == b"D,0,0" and number > 2:
            return []
        return NumberedReplies({})(request, number)

    with ScriptedRobot(deaf_to_stops) as robot:
        child = start_driver([robot.url], "drive(); os._exit(0)")
        _, errors = wait_for_exit(child)
        assert f"{robot.url} may still be moving: its driver has ended" in errors
        assert robot.requests.count(b"D,0,0") > 10


def exists(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    return True


def test_watchdog_ends_with_the_driver(no_leaks: None, monkeypatch: pytest.MonkeyPatch) -> None:
    pids: list[int] = []
    original = Watchdog.__init__

    def recorded(self: Watchdog, port: str, descriptor: int, stop: bytes) -> None:
        original(self, port, descriptor, stop)
        pids.append(self.pid)

    monkeypatch.setattr(Watchdog, "__init__", recorded)
    with ScriptedRobot(NumberedReplies({})) as scripted:
        with SerialKhepera(scripted.url) as robot:
            robot.drive(FORWARD)
            robot.transmit()
            assert exists(pids[0])
        assert not exists(pids[0])
        sent = len(scripted.requests)
        with SerialKhepera(scripted.url, watchdog=False):
            pass
        assert len(pids) == 1
        assert scripted.requests[sent] == b"B", "the watchdog sent nothing"


def test_lost_watchdog_is_reported(caplog: pytest.LogCaptureFixture) -> None:
    reader, writer = os.pipe()
    watchdog = Watchdog("somewhere", writer, b"D,0,0\n")
    os.kill(watchdog.pid, signal.SIGKILL)
    wait_for(lambda: "the watchdog of somewhere has ended" in caplog.text)
    watchdog.end()
    os.close(reader)
    os.close(writer)


def test_port_without_a_descriptor_has_no_watchdog(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        assert start_watchdog("loop://", None, b"") is None
    assert "loop:// has no watchdog" in caplog.text


def test_signals_to_the_group_do_not_end_the_watchdog() -> None:
    """The driver ignores them, too."""
    ignore = "import signal\nfor number in (1, 2, 3, 15): signal.signal(number, signal.SIG_IGN)"
    with ScriptedRobot(NumberedReplies({})) as robot:
        child = start_driver([robot.url], "drive(); time.sleep(60)", before=ignore)
        for number in (signal.SIGHUP, signal.SIGINT, signal.SIGQUIT, signal.SIGTERM):
            os.killpg(child.pid, number)
        time.sleep(0.1)
        assert last_speeds(robot) == b"D,5,5"
        child.kill()
        wait_for(lambda: last_speeds(robot) == b"D,0,0")
        wait_for_exit(child)
