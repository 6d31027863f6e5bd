"""What all drivers of real robots share: a thread that owns the connection, stops on every exit path, and fleets.

Other threads submit tasks and wait for their results. A signal handler may submit a task and wait for it even if the
thread that it interrupted is waiting for another task: the robot's thread continues. `SimpleQueue` is reentrant and
therefore safe in signal handlers; locks, conditions and futures are not.

A robot may drive on at its last speed. All open robots are stopped at the end of the program, and before it is
suspended. A process that is killed, crashes or is frozen cannot stop them: the watchdog of a serial robot does, within
milliseconds, whatever the signal. After a power cut of the computer only the robot's switch stops it.
"""

import atexit
import logging
import os
import signal
import threading
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Sequence
from queue import Empty, SimpleQueue
from types import FrameType
from typing import Any, ClassVar, Generic, Self, TypeVar

from khepera_forage.robots.khepera import (
    ARM_DOWN,
    CONTROL_PERIOD,
    JAW_OPEN,
    Motors,
    RobotLost,
    Senses,
    applicable,
    check_finite,
)
from khepera_forage.robots.model import RobotModel

T = TypeVar("T")

Proximity = tuple[int, int, int, int, int, int, int, int]

_LOG = logging.getLogger(__name__)
_STOP_TIMEOUT = 10.0
"""Seconds that `stop` waits for the robot's thread."""
_STOP_ALL_TIMEOUT = 4.0
"""Seconds allowed for stopping all robots."""


class RobotSuspended(RobotLost):
    """The program was suspended while the wheels turned; they were stopped, and a new command starts them again."""


class Interrupted(Exception):  # noqa: N818 (an event, not an error)
    """A stop needs the connection; the interrupted work starts over afterwards."""


class Task(Generic[T]):
    """Work for a robot's thread; when it is `done`, it has a result or an `error`, and is put into its queue."""

    _value: T

    def __init__(self, work: Callable[[], T], done_queue: "SimpleQueue[Task[Any]] | None" = None) -> None:
        self._work = work
        self._done_queue: SimpleQueue[Task[Any]] = SimpleQueue() if done_queue is None else done_queue
        self.error: BaseException | None = None
        self.done = False

    def run(self) -> None:
        """Run the work; never raises."""
        try:
            self._value = self._work()
        except BaseException as error:
            self.error = error
        self.done = True
        self._done_queue.put(self)

    def result(self, timeout: float | None = None) -> T:
        """Wait for the return value of the work; raises what the work raised, or `TimeoutError`.

        Only for a task with its own queue and one waiting thread.
        """
        if not self.done:
            try:
                self._done_queue.get(timeout=timeout)
            except Empty:
                raise TimeoutError(f"the robot's thread is not done after {timeout:g} s") from None
        if self.error is not None:
            raise self.error
        return self._value


class RealRobot(ABC):
    """A `Robot` behind a connection; `transmit` and `receive` exchange the data of one round.

    All methods are thread-safe, and any that exchanges data raises `RobotLost` if the robot does not reply. The wheels
    are stopped on every exit path. After a suspension (Ctrl-Z) they remain stopped, and the next request raises
    `RobotSuspended` once.

    Args:
        port: Name of the connection.
        max_speed: Limit of the wheel speeds in speed units; that of the model by default.
        period: Seconds of a round; None of a program without rounds.

    Attributes:
        model: What this kind of robot can do.
        stop_confirmed: Whether the robot has confirmed a stop, and was sent no command since that turns its wheels.

    Raises:
        ValueError: A speed that is not allowed.
    """

    model: ClassVar[RobotModel]

    def __init__(self, port: str, *, max_speed: int | None = None, period: float | None = CONTROL_PERIOD) -> None:
        max_speed = self.model.max_speed if max_speed is None else max_speed
        if not 1 <= max_speed <= self.model.max_speed:
            raise ValueError(f"max_speed {max_speed}; allowed: 1..{self.model.max_speed} speed units")
        self.port = port
        self.stop_confirmed = self._food_ahead = False
        self._proximity: Proximity | None = None
        self._max_speed, self._period = max_speed, period
        self._command: Motors | None = None
        self._senses: Senses | None = None
        self._suspended = self._closed = self._in_urgent = False
        self._urgent: deque[Task[Any]] = deque()
        self._tasks: SimpleQueue[Task[Any] | bool] = SimpleQueue()
        """Ordinary work; True wakes the thread for an urgent task, and False ends it."""
        # A daemon: the interpreter waits for other threads at its exit before the robots can be stopped.
        self._thread = threading.Thread(target=self._serve, name=f"port {port}", daemon=True)

    @property
    def has_gripper(self) -> bool:
        """Whether it can pick up food."""
        return self.model.has_gripper

    @property
    @abstractmethod
    def longest_exchange(self) -> float:
        """Seconds after which `transmit` or `receive` of an undisturbed robot is over."""

    def drive(self, motors: Motors) -> Motors:
        """Set the command for the next `transmit`; returns it as it will be sent.

        That is in whole speed units within `max_speed`, arm within its travel, jaw open or closed; without a gripper,
        the arm is lowered and the jaw open.

        Raises:
            ValueError: A value that is not a finite number.
        """
        check_finite(motors)
        left, right, arm, jaw = applicable(motors)
        if not self.model.has_gripper:
            arm, jaw = ARM_DOWN, JAW_OPEN
        self._command = Motors(self._limited(left), self._limited(right), arm, jaw)
        return self._command

    def _limited(self, speed: float) -> float:
        """A wheel speed within `max_speed`."""
        return max(-self._max_speed, min(self._max_speed, speed))

    @staticmethod
    @abstractmethod
    def find() -> list[str]:
        """The ports of this computer at which such a robot may be, each with a description."""

    @abstractmethod
    def flash(self) -> None:
        """Switch its lamps on for a moment, so that a person sees which robot this is."""

    def turn_wheels(self, left: int, right: int) -> None:
        """Turn the wheels at speeds in speed units, and move nothing else."""
        self.drive(Motors(left, right, ARM_DOWN, JAW_OPEN))
        self.transmit()

    def sense(self) -> Senses:
        """The senses of the last `receive`; calls it if there was none."""
        if self._senses is None:
            self.receive()
        assert self._senses is not None
        senses = self._senses
        if not (self.model.has_gripper or self._food_ahead):
            senses = senses._replace(object_presence=0)
        return senses if self._proximity is None else senses._replace(proximity=self._proximity)

    @property
    def touches(self) -> bool:
        """Whether its own sensors report an object, food or wall; always true for a robot that has none for this."""
        return self._senses is not None and self._senses.object_presence > 0

    def note_surroundings(self, food_ahead: bool, proximity: Proximity | None) -> None:
        """Complete the senses of a robot that has fewer sensors than a Khepera, once a round.

        Args:
            food_ahead: Whether food is before the robot. Without a gripper, it reports an object only then.
            proximity: Readings as they follow from the map, for a robot without infra-reds.
        """
        self._food_ahead, self._proximity = food_ahead, proximity

    def transmit(self) -> None:
        """Send the last command."""
        self.begin(self._transmit).result()

    def receive(self) -> None:
        """Read the sensors."""
        self.begin(self._receive).result()

    def stop(self) -> None:
        """Stop the wheels, before any other request; arm and jaw still move to their last targets."""
        self.begin_stop().result(_STOP_TIMEOUT)

    def close(self, stop: bool = True) -> None:
        """Stop the wheels, unless they were just stopped, and close the connection, even if the robot is lost.

        A second call does nothing.
        """
        if not self._closed:
            if stop:
                stop_and_log((self,), "when its port was closed")
            self._release()

    def begin(self, work: Callable[[], T], done_queue: "SimpleQueue[Task[Any]] | None" = None) -> Task[T]:
        """Begin work in the robot's thread; raises `ConnectionError` if the robot is closed."""
        if self._closed:
            raise ConnectionError(f"{self.port} is closed")
        task = Task(lambda: self._complete(work), done_queue)
        self._tasks.put(task)
        return task

    def begin_stop(self, keep_command: bool = False) -> Task[None]:
        """Begin `stop`, or a hold, after which `transmit` sends the same command again.

        Never blocks, so signal handlers may call it.
        """
        if self._command is not None and not keep_command:
            self._command = self._command._replace(left=0, right=0)
        task: Task[None] = Task((lambda: None) if self._closed else self._stop_wheels)
        if self._closed:
            task.run()
        else:
            self._urgent.append(task)
            self._tasks.put(True)
        return task

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _open(self, work: Callable[[], None]) -> None:
        """Start the thread, and open the connection in it; release everything if that fails."""
        self._thread.start()
        _open_robots[self] = None
        _handle_suspensions()
        try:
            self.begin(work).result()
        except BaseException:
            self._release()
            raise

    def _release(self) -> None:
        self._closed = True
        _open_robots.pop(self, None)
        self._tasks.put(False)
        if threading.current_thread() is not self._thread:
            self._thread.join(timeout=5.0)
        self._disconnect()

    # The methods below run in the robot's thread.

    def _serve(self) -> None:
        while task := self._tasks.get():
            self._run_urgent()
            if isinstance(task, Task):
                task.run()

    def _run_urgent(self) -> None:
        self._in_urgent = True
        while self._urgent:
            self._urgent.popleft().run()
        self._in_urgent = False

    def _check_interruption(self) -> None:
        """Raise `Interrupted` during a wait if ordinary work must pause for a stop, or the robot is closed."""
        if (self._closed or self._urgent) and not self._in_urgent:
            raise Interrupted

    def _complete(self, work: Callable[[], T]) -> T:
        """Run work; from its beginning again after an interruption."""
        while True:
            if self._suspended:
                self._suspended = False
                raise RobotSuspended(self.port, "", 0, "the program was suspended, and the robot was stopped")
            try:
                return self._attempt(work)
            except Interrupted:
                self._run_urgent()
                if self._closed:
                    raise ConnectionError(f"{self.port} is closed") from None

    def _attempt(self, work: Callable[[], T]) -> T:
        """Run work once."""
        return work()

    @abstractmethod
    def _transmit(self) -> None:
        """Send `_command`, which `begin_stop` may have changed meanwhile."""

    @abstractmethod
    def _receive(self) -> None:
        """Set `_senses`."""

    @abstractmethod
    def _stop_wheels(self) -> None:
        """Stop the wheels until the next `_transmit`, and confirm it."""

    @abstractmethod
    def _disconnect(self) -> None:
        """End the watchdog, if there is one, and close the connection; a second call does nothing."""


def stop_all(robots: Sequence[RealRobot]) -> list[tuple[RealRobot, Exception]]:
    """Stop robots in parallel, within 4 s; returns those that could not be stopped, with the reasons.

    Raises no error of a robot, so that no failure keeps the others moving.
    """
    tasks = [(robot, robot.begin_stop()) for robot in robots]
    end = time.monotonic() + _STOP_ALL_TIMEOUT
    failed: list[tuple[RealRobot, Exception]] = []
    for robot, task in tasks:
        try:
            task.result(max(0.0, end - time.monotonic()))
        except Exception as error:
            failed.append((robot, error))
    return failed


def stop_and_log(robots: Sequence[RealRobot], occasion: str) -> None:
    """Stop robots; log those that could not be stopped, by default on standard error."""
    for robot, error in stop_all(robots):
        if not robot.stop_confirmed:
            _LOG.error("%s may still be moving; it did not confirm its stop %s: %s", robot.port, occasion, error)


class Fleet:
    """Robots on one port each, served in parallel: a round with all of them takes about as long as with one.

    When a robot is lost, all others are stopped at once, even in the middle of a round, and `RobotLost` names every
    lost robot. When a robot needs more than its time-out (it is lost, or its line is disturbed and requests are
    repeated), the others are held: their wheels are stopped until the next `transmit`.

    Raises:
        ValueError: No robot, or two on one port.
    """

    def __init__(self, robots: Sequence[RealRobot]) -> None:
        ports = [robot.port for robot in robots]
        if not ports or len(set(ports)) < len(ports):
            raise ValueError(f"robots on ports {ports}; allowed: at least one, each on its own port")
        self.robots = tuple(robots)
        self._hold_after = max(robot.longest_exchange for robot in robots)

    def transmit(self) -> None:
        """Send every robot its command."""
        self._run(lambda robot: robot._transmit)

    def receive(self) -> None:
        """Read the sensors of all robots."""
        self._run(lambda robot: robot._receive)

    def stop(self) -> None:
        """Stop all wheels."""
        _raise_any([error for _, error in stop_all(self.robots)])

    def close(self, report: bool = True) -> None:
        """Stop all robots in parallel, then close their ports; log those that do not confirm, unless told not to."""
        if report:
            stop_and_log(self.robots, "when its port was closed")
        else:
            stop_all(self.robots)
        for robot in self.robots:
            robot.close(stop=False)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _run(self, work_of: Callable[[RealRobot], Callable[[], None]]) -> None:
        """Let all robots work; after the first failure, stop the others at once."""
        done_queue: SimpleQueue[Task[Any]] = SimpleQueue()
        errors: list[BaseException] = []
        held, end = False, time.monotonic() + self._hold_after
        try:
            pending = {robot.begin(work_of(robot), done_queue): robot for robot in self.robots}
            while pending:
                try:
                    task = done_queue.get(timeout=None if held else max(0.0, end - time.monotonic()))
                except Empty:
                    held = True
                    for robot in set(self.robots) - set(pending.values()):
                        robot.begin_stop(keep_command=True)
                    continue
                robot = pending.pop(task)
                if task.error is None:
                    if held and pending:  # it is done after the others were held
                        robot.begin_stop(keep_command=True)
                    continue
                if not errors:
                    # At once: a stop is urgent and interrupts the requests of this round. The lost robot may still
                    # receive requests, too; nobody waits for its reply.
                    for other in self.robots:
                        other.begin_stop()
                errors.append(task.error)
        except BaseException:
            stop_all(self.robots)
            raise
        if errors:
            lost = {error.port for error in errors if isinstance(error, RobotLost)}
            errors += [e for _, e in stop_all([robot for robot in self.robots if robot.port not in lost])]
        _raise_any(errors)


def _raise_any(errors: Sequence[BaseException]) -> None:
    """Raise the errors, if any; one `RobotLost` names all lost robots."""
    if not errors:
        return
    first, *others = sorted(errors, key=lambda error: not isinstance(error, RobotLost))
    if not others or not isinstance(first, RobotLost):
        raise first
    also = "; also lost: ".join(map(str, others))
    raise RobotLost(first.port, first.command, first.tries, f"{first.reason}; also lost: {also}") from first


# The open robots of this process. Signal handlers are installed with the first robot, and call the replaced ones.

_open_robots: dict[RealRobot, None] = {}
"""In the order of their opening. Changed and copied in single operations only: a signal may arrive at any moment."""
_replaced: dict[int, Any] = {}
_suspended_ports: list[str] = []


def _handle_suspensions() -> None:
    """Install the signal handlers, unless they are; Python allows this in the main thread only.

    Elsewhere `atexit` and the watchdogs remain.
    """
    if threading.current_thread() is not threading.main_thread():
        return
    for name in {"SIGTSTP", "SIGCONT"} & signal.Signals.__members__.keys():
        number = signal.Signals[name]
        current = signal.getsignal(number)
        # Leave ignored signals, and handlers not installed by Python, which cannot be called from here. A handler
        # that was installed after ours may call ours.
        is_new = number not in _replaced or current == signal.SIG_DFL
        if is_new and current not in (None, signal.SIG_IGN):
            _replaced[number] = current
            signal.signal(number, _on_signal)


def _on_signal(number: int, frame: FrameType | None) -> None:
    """Stop the robots before a suspension; after SIGSTOP, which cannot be caught, unless they have watchdogs."""
    robots = list(_open_robots)
    for robot in robots:
        # A command may be on its way, whatever was confirmed.
        if not robot.stop_confirmed or (robot._command is not None and any(robot._command[:2])):
            robot._suspended = True
            _suspended_ports.append(robot.port)
    stop_and_log(robots, "when the program was suspended")
    resumed = number == signal.SIGCONT
    if callable(_replaced[number]):
        _replaced[number](number, frame)
    elif not resumed:
        signal.signal(number, signal.SIG_DFL)
        signal.raise_signal(number)  # suspends the process
        signal.signal(number, _on_signal)
    if resumed and _suspended_ports:
        stopped = ", ".join(_suspended_ports)
        _suspended_ports.clear()
        _LOG.warning("the program was suspended: stopped %s; no wheel turns before a new command", stopped)


@atexit.register
def _at_exit() -> None:
    robots = list(_open_robots)
    stop_and_log(robots, "at the end of the program")
    for robot in robots:
        if robot.stop_confirmed:
            robot.close(stop=False)  # ends the watchdog


if hasattr(os, "register_at_fork"):
    # A forked child has no threads of the robots, and must leave the parent's robots alone.
    os.register_at_fork(after_in_child=_open_robots.clear)
