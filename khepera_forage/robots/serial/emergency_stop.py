"""Stopping all open robots on every exit path of the process: signals, uncaught exceptions, `sys.exit`, normal exit.

A Khepera drives on at its last speed (no source mentions a watchdog). `watchdog` covers what a process cannot catch,
such as `kill -9`. After a power cut of the computer only the robot's switch stops it.
"""

import atexit
import faulthandler
import logging
import os
import signal
import threading
import time
from collections.abc import Callable
from types import FrameType
from typing import Any, Protocol

from khepera_forage.robots.serial.port_thread import Task

_LOG = logging.getLogger(__name__)


def _available(*names: str) -> tuple[signal.Signals, ...]:
    return tuple(signal.Signals[name] for name in names if name in signal.Signals.__members__)


_REQUESTS_TO_END = _available("SIGINT", "SIGTERM", "SIGHUP", "SIGQUIT")
_FATAL_BY_DEFAULT = _available(
    "SIGABRT",
    "SIGALRM",
    "SIGVTALRM",
    "SIGPROF",
    "SIGXCPU",
    "SIGXFSZ",
    "SIGUSR1",
    "SIGUSR2",
    "SIGPIPE",
    "SIGPOLL",
    "SIGPWR",
    "SIGSTKFLT",
    "SIGSYS",
    "SIGTRAP",
)
"""They end a process that has no handler. A program with a handler uses them for something else, such as a timer."""
_SUSPENSIONS = _available("SIGTSTP", "SIGTTIN", "SIGTTOU")
"""Ctrl-Z, and the terminal access of a process in the background."""
_RESUMPTIONS = _available("SIGCONT")
_TIMEOUT = 4.0
"""Seconds allowed for stopping all robots."""
PORT_CLOSED = "when its port was closed"
"""An occasion of `stop_and_log`."""
_Handler = Callable[[int, FrameType | None], Any] | int | signal.Handlers | None


class Stoppable(Protocol):
    """A robot that can be stopped without blocking."""

    @property
    def port(self) -> str:
        """Its port."""
        ...

    @property
    def stop_confirmed(self) -> bool:
        """Whether it has confirmed a stop and received no other speeds since."""
        ...

    def begin_stop(self) -> Task[None]:
        """Begin to stop its wheels; never blocks."""
        ...

    def suspend(self) -> bool:
        """If its wheels are turning, make its next request raise an error; does not stop them.

        Returns:
            Whether they are turning.
        """
        ...

    def end_watchdog(self) -> None:
        """End its watchdog, if it has one: the robot was stopped."""
        ...


def stop_all(robots: tuple[Stoppable, ...], timeout: float = _TIMEOUT) -> list[tuple[Stoppable, Exception]]:
    """Stop robots in parallel. Raises no error of a robot, so that one failure does not keep the others moving.

    Returns:
        The robots that could not be stopped, with the reasons.
    """
    tasks = [(robot, robot.begin_stop()) for robot in robots]
    end = time.monotonic() + timeout
    failed: list[tuple[Stoppable, Exception]] = []
    for robot, task in tasks:
        try:
            task.result(max(0.0, end - time.monotonic()))
        except Exception as error:
            failed.append((robot, error))
    return failed


def stop_and_log(robots: tuple[Stoppable, ...], occasion: str) -> None:
    """Stop robots; log those that could not be stopped, by default on standard error."""
    for robot, error in stop_all(robots):
        if not robot.stop_confirmed:
            _LOG.error(
                "%s may still be moving; it did not confirm its stop %s: %s", robot.port, occasion, error
            )


class _ExitHandler:
    """Stops the open robots on exit.

    The signal handlers are installed only while a robot is open, and then call the handlers that they replaced. The
    robots are a tuple that is replaced as a whole, because a signal may arrive at any moment.
    """

    def __init__(self) -> None:
        self._robots: tuple[Stoppable, ...] = ()
        self._replaced: dict[int, _Handler] = {}
        self._suspended: list[str] = []
        self._process = os.getpid()
        self._lock = threading.Lock()

    def register(self, robot: Stoppable) -> None:
        """Stop the robot on every exit path from now on."""
        with self._lock:
            if self._process != os.getpid():
                self._process, self._robots = os.getpid(), ()
            if not self._robots:
                atexit.register(self._at_exit)
            self._robots = (*self._robots, robot)
            self._install_handlers()

    def unregister(self, robot: Stoppable) -> None:
        """Forget a robot that has been stopped and closed; a second call does nothing."""
        with self._lock:
            if not any(other is robot for other in self._robots):
                return
            self._robots = tuple(other for other in self._robots if other is not robot)
            if not self._robots:
                atexit.unregister(self._at_exit)
                self._remove_handlers()

    def _install_handlers(self) -> None:
        if threading.current_thread() is not threading.main_thread():
            return  # Python allows it only in the main thread; `atexit` and the watchdogs remain.
        for numbers, handler in (
            (_REQUESTS_TO_END, self._on_end),
            (_FATAL_BY_DEFAULT, self._on_end),
            (_SUSPENSIONS, self._on_suspension),
            (_RESUMPTIONS, self._on_resumption),
        ):
            for number in numbers:
                if number not in self._replaced and _is_ours_to_replace(number):
                    self._replaced[number] = signal.signal(number, handler)

    def _remove_handlers(self) -> None:
        if threading.current_thread() is not threading.main_thread():
            return  # The handlers remain, and only call the replaced ones.
        ours = (self._on_end, self._on_suspension, self._on_resumption)
        for number in list(self._replaced):
            # A handler installed later may call ours: leave both.
            if signal.getsignal(number) in ours:
                signal.signal(number, self._replaced.pop(number))

    def _on_end(self, number: int, frame: FrameType | None) -> None:
        self._stop(f"on signal {signal.Signals(number).name}")
        self._call_replaced(number, frame)

    def _on_suspension(self, number: int, frame: FrameType | None) -> None:
        self._suspend()
        self._call_replaced(number, frame)
        if signal.getsignal(number) == signal.SIG_DFL:  # `_call_replaced` has suspended the process
            signal.signal(number, self._on_suspension)

    def _on_resumption(self, number: int, frame: FrameType | None) -> None:
        # After SIGSTOP, which cannot be caught, the robots are stopped only now.
        self._suspend()
        self._call_replaced(number, frame)
        if self._suspended:
            stopped = ", ".join(self._suspended)
            self._suspended = []
            _LOG.warning(
                "the program was suspended: stopped %s; no wheel turns before a new command", stopped
            )

    def _call_replaced(self, number: int, frame: FrameType | None) -> None:
        replaced = self._replaced.get(number)
        if callable(replaced):
            replaced(number, frame)
        elif replaced == signal.SIG_DFL and number not in _RESUMPTIONS:
            signal.signal(number, signal.SIG_DFL)
            signal.raise_signal(number)

    def _at_exit(self) -> None:
        self._stop("at the end of the program")
        if self._process == os.getpid():
            for robot in self._robots:
                if robot.stop_confirmed:
                    robot.end_watchdog()

    def _stop(self, occasion: str) -> None:
        # A forked child has no port threads, and must leave the parent's robots alone.
        if self._process == os.getpid():
            stop_and_log(self._robots, occasion)

    def _suspend(self) -> None:
        if self._process == os.getpid():
            self._suspended += [robot.port for robot in self._robots if robot.suspend()]
            stop_and_log(self._robots, "when the program was suspended")


def _is_ours_to_replace(number: signal.Signals) -> bool:
    """Whether a signal has a handler that ours may stand in for, and call."""
    current = signal.getsignal(number)
    if number in _FATAL_BY_DEFAULT and current != signal.SIG_DFL:
        return False
    if number == signal.SIGABRT and faulthandler.is_enabled():
        return False  # Python does not report its handler, which prints the cause of a crash.
    # Leave ignored signals (nohup), and handlers not installed by Python, which cannot be called from here.
    return current is not None and current is not signal.SIG_IGN


_EXIT_HANDLER = _ExitHandler()
register = _EXIT_HANDLER.register
unregister = _EXIT_HANDLER.unregister
