"""Several real robots in parallel: a round with all of them takes about as long as a round with one."""

import time
from collections.abc import Callable, Sequence
from queue import Empty, SimpleQueue
from typing import Any, Self

from khepera_forage.robots.khepera import RobotLost
from khepera_forage.robots.real_robot import RealRobot, Task, stop_all, stop_and_log

_Begin = Callable[[RealRobot, "SimpleQueue[Task[Any]]"], Task[None]]


class Fleet:
    """Robots on one port each, served in parallel.

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
        self._run(RealRobot.begin_transmit)

    def receive(self) -> None:
        """Read the sensors of all robots."""
        self._run(RealRobot.begin_receive)

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

    def _run(self, begin: _Begin) -> None:
        """Let all robots work; after the first failure, stop the others at once."""
        done_queue: SimpleQueue[Task[Any]] = SimpleQueue()
        errors: list[BaseException] = []
        held, end = False, time.monotonic() + self._hold_after
        try:
            pending = {begin(robot, done_queue): robot for robot in self.robots}
            while pending:
                try:
                    task = done_queue.get(timeout=None if held else max(0.0, end - time.monotonic()))
                except Empty:
                    held = True
                    for robot in set(self.robots) - set(pending.values()):
                        robot.begin_hold()
                    continue
                robot = pending.pop(task)
                if task.error is None:
                    if held and pending:  # it is done after the others were held
                        robot.begin_hold()
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
        lost = {error.port for error in errors if isinstance(error, RobotLost)}
        if errors:
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
