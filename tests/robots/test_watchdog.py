"""The watchdog: a robot below the driver records the last command after every end of the process."""

import contextlib
import logging
import os
import signal
import subprocess
import time

import pytest

from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from khepera_forage.robots.serial.watchdog import Watchdog, start_watchdog
from tests.robots.driver_process import start_driver, wait_for, wait_for_exit
from tests.robots.rfc2217_server import rfc2217_server
from tests.robots.rig import FORWARD, make_rig
from tests.robots.scripted_robot import Action, NumberedReplies, ScriptedRobot


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
