"""Open robots are stopped on every way out of the process: signals, uncaught errors, `sys.exit`, its plain end.

A Khepera drives on as it was last told (no source knows of a watchdog). What no program can catch, a kill -9 or a
power cut of the computer, needs a hand on the robot's switch.
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
_PATIENCE = 4.0
"""Seconds that stopping all robots may take."""
_Handler = Callable[[int, FrameType | None], Any] | int | signal.Handlers | None


class Stoppable(Protocol):
    """What can be stopped without waiting for it."""

    @property
    def port(self) -> str:
        """Where it is."""
        ...

    def begin_stop(self) -> Task[None]:
        """Begin to stop it; never blocks."""
        ...


def stop_all(robots: tuple[Stoppable, ...], patience: float = _PATIENCE) -> list[tuple[Stoppable, Exception]]:
    """Stop robots in parallel; never raises for a robot's sake, so that one does not keep another from it.

    Returns:
        Those that could not be stopped, and why.
    """
    tasks = [(robot, robot.begin_stop()) for robot in robots]
    end = time.monotonic() + patience
    failed: list[tuple[Stoppable, Exception]] = []
    for robot, task in tasks:
        try:
            task.result(max(0.0, end - time.monotonic()))
        except Exception as error:
            failed.append((robot, error))
    return failed


def stop_and_tell(robots: tuple[Stoppable, ...], occasion: str) -> None:
    """Stop robots; those that cannot be stopped are reported to whoever reads the log, by default on standard error."""
    for robot, error in stop_all(robots):
        _LOG.error("%s may still be moving; it could not be stopped at %s: %s", robot.port, occasion, error)


class _Guard:
    """Stops the robots that are open, then lets the way out go on.

    Signal handlers are there only while a robot is open, and hand on to the handlers they found. A tuple that is
    replaced as a whole holds the robots: a signal may come at any moment.
    """

    def __init__(self) -> None:
        self._robots: tuple[Stoppable, ...] = ()
        self._found: dict[int, _Handler] = {}
        self._process = os.getpid()
        self._changing = threading.Lock()

    def watch(self, robot: Stoppable) -> None:
        """From now on the robot is stopped on every way out."""
        with self._changing:
            if self._process != os.getpid():
                self._process, self._robots = os.getpid(), ()
            if not self._robots:
                atexit.register(self._at_exit)
            self._robots = (*self._robots, robot)
            self._catch_signals()

    def unwatch(self, robot: Stoppable) -> None:
        """The robot has been stopped and closed; a second call does nothing."""
        with self._changing:
            if not any(other is robot for other in self._robots):
                return
            self._robots = tuple(other for other in self._robots if other is not robot)
            if not self._robots:
                atexit.unregister(self._at_exit)
                self._let_signals_go()

    def _catch_signals(self) -> None:
        if threading.current_thread() is not threading.main_thread():
            return  # Python allows it to the main thread only; `atexit` remains.
        for number in _SIGNALS:
            found = signal.getsignal(number)
            # Ignored ones stay so (nohup), and what was not installed by Python could not be handed on to.
            if number not in self._found and found is not None and found is not signal.SIG_IGN:
                self._found[number] = found
                signal.signal(number, self._on_signal)

    def _let_signals_go(self) -> None:
        if threading.current_thread() is not threading.main_thread():
            return  # The handlers stay, and merely hand on.
        for number in list(self._found):
            # One that was installed on top of ours hands on to ours: leave both.
            if signal.getsignal(number) == self._on_signal:
                signal.signal(number, self._found.pop(number))

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        self._stop(f"signal {signal.Signals(number).name}")
        found = self._found.get(number)
        if callable(found):
            found(number, frame)
        elif found == signal.SIG_DFL:
            signal.signal(number, signal.SIG_DFL)
            signal.raise_signal(number)

    def _at_exit(self) -> None:
        self._stop("the end of the program")

    def _stop(self, occasion: str) -> None:
        # A forked child has neither the robots' threads nor any business with them.
        if self._process == os.getpid():
            stop_and_tell(self._robots, occasion)


_GUARD = _Guard()
watch = _GUARD.watch
unwatch = _GUARD.unwatch
