"""Stopping all open robots on every exit path of the process: signals, uncaught exceptions, `sys.exit`, normal exit.

A Khepera drives on at its last speed (no source mentions a watchdog). No program can catch a `kill -9` or a power cut
of the computer: only the robot's switch stops it then.
"""

import atexit
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
_SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
_TIMEOUT = 4.0
"""Seconds allowed for stopping all robots."""
_Handler = Callable[[int, FrameType | None], Any] | int | signal.Handlers | None


class Stoppable(Protocol):
    """A robot that can be stopped without blocking."""

    @property
    def port(self) -> str:
        """Its port."""
        ...

    def begin_stop(self) -> Task[None]:
        """Begin to stop its wheels; never blocks."""
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
        _LOG.error("%s may still be moving; it could not be stopped %s: %s", robot.port, occasion, error)


class _ExitHandler:
    """Stops the open robots on exit.

    The signal handlers are installed only while a robot is open, and then call the handlers that they replaced. The
    robots are a tuple that is replaced as a whole, because a signal may arrive at any moment.
    """

    def __init__(self) -> None:
        self._robots: tuple[Stoppable, ...] = ()
        self._replaced: dict[int, _Handler] = {}
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
            return  # Python allows it only in the main thread; `atexit` remains.
        for number in _SIGNALS:
            current = signal.getsignal(number)
            # Leave ignored signals (nohup), and handlers not installed by Python, which cannot be called from here.
            if number not in self._replaced and current is not None and current is not signal.SIG_IGN:
                self._replaced[number] = current
                signal.signal(number, self._on_signal)

    def _remove_handlers(self) -> None:
        if threading.current_thread() is not threading.main_thread():
            return  # The handlers remain, and only call the replaced ones.
        for number in list(self._replaced):
            # A handler installed later may call ours: leave both.
            if signal.getsignal(number) == self._on_signal:
                signal.signal(number, self._replaced.pop(number))

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        self._stop(f"on signal {signal.Signals(number).name}")
        replaced = self._replaced.get(number)
        if callable(replaced):
            replaced(number, frame)
        elif replaced == signal.SIG_DFL:
            signal.signal(number, signal.SIG_DFL)
            signal.raise_signal(number)

    def _at_exit(self) -> None:
        self._stop("at the end of the program")

    def _stop(self, occasion: str) -> None:
        # A forked child has no port threads, and must leave the parent's robots alone.
        if self._process == os.getpid():
            stop_and_log(self._robots, occasion)


_EXIT_HANDLER = _ExitHandler()
register = _EXIT_HANDLER.register
unregister = _EXIT_HANDLER.unregister
