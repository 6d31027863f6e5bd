"""The thread that owns a port: order, urgent tasks, errors, and its end."""

import threading
from collections.abc import Callable
from queue import SimpleQueue
from typing import Any

import pytest

from khepera_forage.robots.serial.port_thread import PortThread, Task


def test_tasks_run_in_order_and_return_their_values() -> None:
    thread = PortThread("test")
    done: list[int] = []

    def numbered(number: int) -> Callable[[], int]:
        def work() -> int:
            done.append(number)
            return -number

        return work

    tasks = [thread.submit(Task(numbered(i))) for i in range(20)]
    assert [-task.result(5.0) for task in tasks] == done == list(range(20))
    thread.end()


def test_urgent_tasks_run_inside_ordinary_ones() -> None:
    thread = PortThread("test")
    done: list[str] = []
    begun, submitted = threading.Event(), threading.Event()

    def ordinary() -> None:
        begun.set()
        assert submitted.wait(5.0)
        assert thread.must_yield()
        thread.run_urgent()
        assert not thread.must_yield()
        done.append("ordinary")

    def urgent() -> None:
        assert not thread.must_yield(), "an urgent task is never interrupted"
        done.append("urgent")

    first = thread.submit(Task(ordinary))
    second = thread.submit(Task(lambda: done.append("second")))
    assert begun.wait(5.0)
    urgent_tasks = [thread.submit(Task(urgent), urgent=True) for _ in range(2)]
    submitted.set()
    for task in (*urgent_tasks, first, second):
        task.result(5.0)
    assert done == ["urgent", "urgent", "ordinary", "second"]
    thread.end()


def test_error_is_raised_by_result_and_the_thread_continues() -> None:
    thread = PortThread("test")

    def fails() -> None:
        raise KeyError("here")

    with pytest.raises(KeyError, match="here"):
        thread.submit(Task(fails)).result(5.0)
    assert thread.submit(Task(lambda: 3)).result(5.0) == 3
    thread.end()


def test_result_raises_after_its_timeout() -> None:
    thread = PortThread("test")
    gate = threading.Event()
    task = thread.submit(Task(gate.wait))
    with pytest.raises(TimeoutError):
        task.result(0.01)
    gate.set()
    assert task.result(5.0)
    thread.end()


def test_shared_queue_receives_tasks_in_the_order_of_completion() -> None:
    threads = [PortThread(f"test {i}") for i in range(3)]
    gates = [threading.Event() for _ in threads]
    finished: SimpleQueue[Task[Any]] = SimpleQueue()
    tasks = [t.submit(Task(gate.wait, finished)) for t, gate in zip(threads, gates, strict=True)]
    for number in (2, 0, 1):
        gates[number].set()
        assert finished.get(timeout=5.0) is tasks[number]
    for thread in threads:
        thread.end()


def test_end_makes_ordinary_tasks_give_up() -> None:
    thread = PortThread("test")
    begun = threading.Event()

    def until_ending() -> str:
        begun.set()
        while not thread.must_yield():
            pass
        return "gave up"

    task = thread.submit(Task(until_ending))
    assert begun.wait(5.0)
    thread.end()
    assert task.result(5.0) == "gave up"
