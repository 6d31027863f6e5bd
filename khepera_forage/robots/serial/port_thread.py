"""The thread that owns a serial port, so that stopping a robot never waits for a lock.

Other threads submit tasks and wait for their results. A signal handler may submit a task and wait for it even if the
thread that it interrupted is waiting for another task: the port's thread continues. `SimpleQueue` is reentrant and
therefore safe in signal handlers; locks, conditions and futures are not.
"""

import threading
from collections import deque
from collections.abc import Callable
from queue import Empty, SimpleQueue
from typing import Any, Generic, TypeVar

T = TypeVar("T")


class Task(Generic[T]):
    """Work for the port's thread, and its result.

    Args:
        work: The function to run.
        done_queue: Queue for the task once it is done; a new queue by default.

    Attributes:
        error: What the work raised, or None.
        done: Whether the work has returned or raised.
    """

    def __init__(self, work: Callable[[], T], done_queue: "SimpleQueue[Task[Any]] | None" = None) -> None:
        self._work = work
        self._done_queue: SimpleQueue[Task[Any]] = SimpleQueue() if done_queue is None else done_queue
        self._value: list[T] = []
        self.error: BaseException | None = None
        self.done = False

    def run(self) -> None:
        """Run the work; never raises."""
        try:
            self._value.append(self._work())
        except BaseException as error:
            self.error = error
        self.done = True
        self._done_queue.put(self)

    def result(self, timeout: float | None = None) -> T:
        """Wait for the return value of the work; raises what the work raised.

        Only for a task with its own queue and one waiting thread.

        Raises:
            TimeoutError: The work is not done within `timeout` seconds.
        """
        if not self.done:
            try:
                self._done_queue.get(timeout=timeout)
            except Empty:
                raise TimeoutError(f"the port's thread is not done after {timeout:g} s") from None
        if self.error is not None:
            raise self.error
        return self._value[0]


class PortThread:
    """Runs tasks one after another, urgent ones first.

    Args:
        name: Name of the thread.

    Attributes:
        ending: Whether `end` was called, so that ordinary tasks must give up.
    """

    def __init__(self, name: str) -> None:
        self._urgent: deque[Task[Any]] = deque()
        self._ordinary: deque[Task[Any]] = deque()
        self._wake: SimpleQueue[bool] = SimpleQueue()
        self._in_urgent = False
        self.ending = False
        # A daemon: the interpreter waits for other threads at its exit before the robots can be stopped.
        self._thread = threading.Thread(target=self._serve, name=name, daemon=True)
        self._thread.start()

    def submit(self, task: Task[T], *, urgent: bool = False) -> Task[T]:
        """Queue a task; returns it at once."""
        (self._urgent if urgent else self._ordinary).append(task)
        self._wake.put(True)
        return task

    def must_yield(self) -> bool:
        """Whether an ordinary task must pause for an urgent one, or give up because the thread is ending."""
        return (self.ending or bool(self._urgent)) and not self._in_urgent

    def run_urgent(self) -> None:
        """Run all urgent tasks; also called by an ordinary task that pauses for them."""
        self._in_urgent = True
        try:
            while self._urgent:
                self._urgent.popleft().run()
        finally:
            self._in_urgent = False

    def end(self) -> None:
        """Make ordinary tasks give up, end the thread, and wait for it."""
        self.ending = True
        self._wake.put(False)
        if threading.current_thread() is not self._thread:
            self._thread.join(timeout=5.0)

    def _serve(self) -> None:
        while self._wake.get():
            self.run_urgent()
            # An urgent task may have run inside an ordinary one; its wake-up then finds empty queues.
            if self._ordinary:
                self._ordinary.popleft().run()
