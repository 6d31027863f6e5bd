"""Stopping all open robots at the end of the program, and before it is suspended.

A robot may drive on at its last speed. A process that is killed, crashes or is frozen cannot stop it: the watchdog of
a serial robot does, within milliseconds, whatever the signal. After a power cut of the computer only the robot's switch
stops it.
"""

import atexit
import logging
import os
import signal
import threading
import time
from collections.abc import Callable, Sequence
from types import FrameType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from khepera_forage.robots.real_robot import RealRobot

_LOG = logging.getLogger(__name__)
_SUSPENSIONS = ("SIGTSTP", "SIGTTIN", "SIGTTOU")
"""Ctrl-Z, and the terminal access of a process in the background."""
_RESUMPTION = "SIGCONT"
_TIMEOUT = 4.0
"""Seconds allowed for stopping all robots."""
PORT_CLOSED = "when its port was closed"
"""An occasion of `stop_and_log`."""
_Handler = Callable[[int, FrameType | None], Any] | int | signal.Handlers | None


def stop_all(robots: "Sequence[RealRobot]", timeout: float = _TIMEOUT) -> "list[tuple[RealRobot, Exception]]":
    """Stop robots in parallel. Raises no error of a robot, so that one failure does not keep the others moving.

    Returns:
        The robots that could not be stopped, with the reasons.
    """
    tasks = [(robot, robot.begin_stop()) for robot in robots]
    end = time.monotonic() + timeout
    failed: list[tuple[RealRobot, Exception]] = []
    for robot, task in tasks:
        try:
            task.result(max(0.0, end - time.monotonic()))
        except Exception as error:
            failed.append((robot, error))
    return failed


def stop_and_log(robots: "Sequence[RealRobot]", occasion: str) -> None:
    """Stop robots; log those that could not be stopped, by default on standard error."""
    for robot, error in stop_all(robots):
        if not robot.stop_confirmed:
            _LOG.error(
                "%s may still be moving; it did not confirm its stop %s: %s", robot.port, occasion, error
            )


class _OpenRobots:
    """The open robots of this process. They are replaced as a whole, because a signal may arrive at any moment.

    Signal handlers are installed only while a robot is open, and then call the handlers that they replaced.
    """

    def __init__(self) -> None:
        self._robots: tuple[RealRobot, ...] = ()
        self._replaced: dict[int, _Handler] = {}
        self._suspended: list[str] = []
        self._process = os.getpid()
        self._lock = threading.Lock()

    def register(self, robot: "RealRobot") -> None:
        """Stop the robot at the end of the program from now on."""
        with self._lock:
            if self._process != os.getpid():
                self._process, self._robots = os.getpid(), ()
            if not self._robots:
                atexit.register(self._at_exit)
            self._robots = (*self._robots, robot)
            # Python allows handlers only in the main thread; `atexit` and the watchdogs remain.
            if threading.current_thread() is threading.main_thread():
                for name in (*_SUSPENSIONS, _RESUMPTION):
                    number = signal.Signals.__members__.get(name)
                    current = None if number is None else signal.getsignal(number)
                    # Leave ignored signals, and handlers not installed by Python, which cannot be called from here.
                    if current in (None, signal.SIG_IGN):
                        continue
                    if number in self._replaced and current != signal.SIG_DFL:
                        continue  # ours, or a later one, which may call ours
                    assert number is not None
                    handler = self._on_resumption if name == _RESUMPTION else self._on_suspension
                    self._replaced[number] = signal.signal(number, handler)

    def unregister(self, robot: "RealRobot") -> None:
        """Forget a robot that has been stopped and closed; a second call does nothing."""
        with self._lock:
            if robot not in self._robots:
                return
            self._robots = tuple(other for other in self._robots if other is not robot)
            if self._robots:
                return
            atexit.unregister(self._at_exit)
            if threading.current_thread() is not threading.main_thread():
                return  # The handlers remain, and only call the replaced ones.
            for number in list(self._replaced):
                # A handler installed later may call ours: leave both.
                if signal.getsignal(number) in (self._on_suspension, self._on_resumption):
                    signal.signal(number, self._replaced.pop(number))

    def _on_suspension(self, number: int, frame: FrameType | None) -> None:
        self._suspend()
        replaced = self._replaced.get(number)
        if callable(replaced):
            replaced(number, frame)
        elif replaced == signal.SIG_DFL:
            signal.signal(number, signal.SIG_DFL)
            signal.raise_signal(number)  # suspends the process
            signal.signal(number, self._on_suspension)

    def _on_resumption(self, number: int, frame: FrameType | None) -> None:
        # After SIGSTOP, which cannot be caught, the robots are stopped only now, unless they have watchdogs.
        self._suspend()
        replaced = self._replaced.get(number)
        if callable(replaced):
            replaced(number, frame)
        if self._suspended:
            stopped, self._suspended = ", ".join(self._suspended), []
            _LOG.warning(
                "the program was suspended: stopped %s; no wheel turns before a new command", stopped
            )

    def _suspend(self) -> None:
        if self._process == os.getpid():
            self._suspended += [robot.port for robot in self._robots if robot.suspend()]
            stop_and_log(self._robots, "when the program was suspended")

    def _at_exit(self) -> None:
        # A forked child has no threads of the robots, and must leave the parent's robots alone.
        if self._process == os.getpid():
            stop_and_log(self._robots, "at the end of the program")
            for robot in self._robots:
                if robot.stop_confirmed:
                    robot.end_watchdog()


_OPEN_ROBOTS = _OpenRobots()
register = _OPEN_ROBOTS.register
unregister = _OPEN_ROBOTS.unregister
