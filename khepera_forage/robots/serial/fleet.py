"""Several real robots at once: what is asked of all costs what one robot takes."""

import time
from collections.abc import Callable, Sequence
from queue import Empty, SimpleQueue
from types import TracebackType
from typing import Any, Self

from khepera_forage.robots.khepera import CONTROL_PERIOD, RobotLost
from khepera_forage.robots.serial import emergency_stop as stopping
from khepera_forage.robots.serial.port import seconds_on_wire
from khepera_forage.robots.serial.port_thread import Task
from khepera_forage.robots.serial.serial_khepera import SerialKhepera

_LONGEST_ROUND = 170
"""Bytes of a round in which arm and jaw move and all numbers have all their digits."""
_STOPPING = 4.0
"""Seconds after which a robot that does not confirm its stop is not waited for."""
_Begin = Callable[[SerialKhepera, "SimpleQueue[Task[Any]]"], Task[None]]


class Fleet:
    """Robots on a port each, told and asked in parallel.

    When one is lost, all the others are stopped at once, in the middle of their round, and `RobotLost` is raised. When
    one takes a round longer than its bytes do (it is lost, or its line is disturbed and it is asked again), the others
    are held: their wheels stand until the next `transmit`.

    Args:
        robots: In any order.

    Raises:
        ValueError: No robot, or two on one port.
    """

    def __init__(self, robots: Sequence[SerialKhepera]) -> None:
        ports = [robot.port for robot in robots]
        if not ports or len(set(ports)) < len(ports):
            raise ValueError(f"robots on ports {ports}; allowed: at least one, each on a port of its own")
        self.robots = tuple(robots)
        # A round, and what its bytes take on the slowest of the lines.
        self._patience = CONTROL_PERIOD + max(seconds_on_wire(_LONGEST_ROUND, robot.baud) for robot in robots)

    def transmit(self) -> None:
        """Send every robot what it was commanded.

        Raises:
            RobotLost: One or more do not answer; the others have been stopped.
        """
        self._round(SerialKhepera.begin_transmit)

    def receive(self) -> None:
        """Read the sensors of all robots.

        Raises:
            RobotLost: One or more do not answer; the others have been stopped.
        """
        self._round(SerialKhepera.begin_receive)

    def stop(self) -> None:
        """Stop all wheels.

        Raises:
            RobotLost: One or more do not confirm it; the others have been stopped.
        """
        _raise([error for _, error in stopping.stop_all(self.robots)])

    def close(self) -> None:
        """Stop all robots at once, then let go of them; a second call does nothing."""
        stopping.stop_all(self.robots)
        for robot in self.robots:
            robot.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _round(self, begin: _Begin) -> None:
        finished: SimpleQueue[Task[Any]] = SimpleQueue()
        try:
            waiting = {begin(robot, finished): robot for robot in self.robots}
            errors = self._wait(waiting, finished)
        except BaseException:
            stopping.stop_all(self.robots)
            raise
        _raise(errors)

    def _wait(
        self, waiting: dict[Task[None], SerialKhepera], finished: "SimpleQueue[Task[Any]]"
    ) -> list[Exception]:
        """Wait for all; returns the errors of those that failed, the others having been stopped."""
        errors: list[Exception] = []
        stops: list[Task[None]] = []
        held = False
        end = time.monotonic() + self._patience
        while waiting:
            try:
                task = finished.get(timeout=None if held else max(0.0, end - time.monotonic()))
            except Empty:
                held = True
                for robot in set(self.robots) - set(waiting.values()):
                    robot.begin_hold()
                continue
            robot = waiting.pop(task)
            if task.error is None:
                continue
            if not isinstance(task.error, Exception):
                raise task.error
            if not errors:
                # At once: what their lines are busy with makes room for it.
                stops = [other.begin_stop() for other in self.robots if other is not robot]
            # It may hear, although it is not heard; nobody waits for that.
            robot.begin_stop()
            errors.append(task.error)
        lost = {error.port for error in errors if isinstance(error, RobotLost)}
        for stop in stops:
            try:
                stop.result(_STOPPING)
            except RobotLost as error:
                if error.port not in lost:
                    errors.append(error)
            except TimeoutError as error:
                errors.append(error)
        return errors


def _raise(errors: Sequence[Exception]) -> None:
    """Raise what happened, if anything did; one `RobotLost` for several robots names them all."""
    if not errors:
        return
    first, *others = sorted(errors, key=lambda error: not isinstance(error, RobotLost))
    if not others or not isinstance(first, RobotLost):
        raise first
    also = "; also lost: ".join(map(str, others))
    raise RobotLost(first.port, first.command, first.tries, f"{first.reason}; also lost: {also}") from first
