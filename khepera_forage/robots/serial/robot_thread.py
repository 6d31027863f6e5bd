"""The session with a robot in the thread of its port: work starts over after an urgent stop or a restart."""

from collections.abc import Callable
from queue import SimpleQueue
from typing import Any, TypeVar

from khepera_forage.robots.khepera import RobotLost
from khepera_forage.robots.serial.client import ProtocolClient
from khepera_forage.robots.serial.errors import RequestInterrupted, RobotRestarted, RobotSuspended
from khepera_forage.robots.serial.port_thread import PortThread, Task
from khepera_forage.robots.serial.session import MAX_RESTARTS, TOO_MANY_RESTARTS, Session

T = TypeVar("T")


class RobotThread:
    """Runs the session's work in the port's thread.

    Args:
        client: The connection to the robot.
        period: As for `Session`.

    Attributes:
        session: Its methods run only as work of this thread.
        was_suspended: Whether the next work must raise `RobotSuspended`.
    """

    def __init__(self, client: ProtocolClient, period: float | None) -> None:
        self.session = Session(client, period)
        self.was_suspended = False
        self._port = client.port
        self._closed = False
        self._thread = PortThread(f"port {client.port}")
        client.exchange.interrupted = self._thread.must_yield

    def begin(self, work: Callable[[], T], done_queue: "SimpleQueue[Task[Any]] | None" = None) -> Task[T]:
        """Begin work; the task is put into the queue when it is done.

        Raises:
            ConnectionError: The thread has ended.
        """
        if self._closed:
            raise ConnectionError(f"{self._port} is closed")
        return self._thread.submit(Task(lambda: self._complete(work), done_queue))

    def begin_stop(self, discard_command: bool) -> Task[None]:
        """Begin to stop the wheels before any other work; never blocks. After `end`, there is nothing to stop."""
        task = Task(lambda: self.session.stop(discard_command))
        if self._closed:
            task = Task(lambda: None)
            task.run()
            return task
        return self._thread.submit(task, urgent=True)

    def end(self) -> None:
        """Make all work give up, and wait for the end of the thread."""
        self._closed = True
        self._thread.end()

    def _complete(self, work: Callable[[], T]) -> T:
        restarts = 0
        while True:
            if self.was_suspended:
                self.was_suspended = False
                raise RobotSuspended(self._port)
            try:
                self.session.restore()
                return work()
            except RequestInterrupted:
                self._thread.run_urgent()
                if self._thread.ending:
                    raise ConnectionError(f"{self._port} is closed") from None
            except RobotRestarted:
                self.session.on_restart()
                restarts += 1
                if restarts > MAX_RESTARTS:
                    raise RobotLost(self._port, "restart", restarts, TOO_MANY_RESTARTS) from None
