"""A thread that owns a serial port, so that nobody who wants a robot stopped ever waits for a lock.

Whoever wants something of the port leaves it as a task and waits for that task alone. A signal handler may do so while
the very thread it interrupted waits for another one: the port's thread goes on working. `SimpleQueue` is made for this
(its methods may interrupt themselves); locks, conditions and futures are not.
"""

import threading
from collections import deque
from collections.abc import Callable
from queue import Empty, SimpleQueue
from typing import Any, Generic, TypeVar

T = TypeVar("T")


class Task(Generic[T]):
    """Work for the port's thread, and what came of it.

    Args:
        work: What is to be done.
        finished: Where the task is put once it is done; a queue of its own by default.
    """

    def __init__(self, work: Callable[[], T], finished: "SimpleQueue[Task[Any]] | None" = None) -> None:
        self._work = work
        self._finished: SimpleQueue[Task[Any]] = SimpleQueue() if finished is None else finished
        self._value: list[T] = []
        self.error: BaseException | None = None
        self.done = False

    def run(self) -> None:
        """Do it; never raises."""
        try:
            self._value.append(self._work())
        except BaseException as error:
            self.error = error
        self.done = True
        self._finished.put(self)

    def result(self, timeout: float | None = None) -> T:
        """What the work returned; raises what it raised.

        Only for a task with a queue of its own, and by one waiter.

        Raises:
            TimeoutError: It is not done in so many seconds.
        """
        if not self.done:
            try:
                self._finished.get(timeout=timeout)
            except Empty:
                raise TimeoutError(f"the port's thread is not done after {timeout:g} s") from None
        if self.error is not None:
            raise self.error
        return self._value[0]


class PortThread:
    """Does tasks one after another, urgent ones first.

    Args:
        name: For whoever lists threads.

    Attributes:
        ending: Whether ordinary tasks are to give up.
    """

    def __init__(self, name: str) -> None:
        self._urgent: deque[Task[Any]] = deque()
        self._ordinary: deque[Task[Any]] = deque()
        self._wake: SimpleQueue[bool] = SimpleQueue()
        self._in_urgent = False
        self.ending = False
        # A daemon: others are waited for at the interpreter's exit before anyone gets to stop the robots.
        self._thread = threading.Thread(target=self._serve, name=name, daemon=True)
        self._thread.start()

    def begin(self, task: Task[T], *, urgent: bool = False) -> Task[T]:
        """Leave a task; returns it at once."""
        (self._urgent if urgent else self._ordinary).append(task)
        self._wake.put(True)
        return task

    def pressing(self) -> bool:
        """Whether an ordinary task is to make room: for an urgent one, or because the thread shall end."""
        return (self.ending or bool(self._urgent)) and not self._in_urgent

    def do_urgent(self) -> None:
        """Do all urgent tasks; called by an ordinary one that makes room."""
        self._in_urgent = True
        try:
            while self._urgent:
                self._urgent.popleft().run()
        finally:
            self._in_urgent = False

    def end(self) -> None:
        """Have ordinary tasks give up, let the thread end, and wait for that."""
        self.ending = True
        self._wake.put(False)
        if threading.current_thread() is not self._thread:
            self._thread.join(timeout=5.0)

    def _serve(self) -> None:
        while self._wake.get():
            self.do_urgent()
            # A task that was done out of turn leaves its call behind, which then finds nothing.
            if self._ordinary:
                self._ordinary.popleft().run()
