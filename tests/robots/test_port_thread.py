"""The thread that owns a port: order, urgency, errors, and its end."""

import threading
from collections.abc import Callable
from queue import SimpleQueue
from typing import Any

import pytest

from khepera_forage.robots.serial.port_thread import PortThread, Task


def test_tasks_are_done_in_order_and_return_what_they_return() -> None:
    thread = PortThread("test")
    done: list[int] = []

    def numbered(number: int) -> Callable[[], int]:
        def work() -> int:
            done.append(number)
            return -number

        return work

    tasks = [thread.begin(Task(numbered(i))) for i in range(20)]
    assert [-task.result(5.0) for task in tasks] == done == list(range(20))
    thread.end()


def test_urgent_tasks_come_first_and_ordinary_ones_make_room() -> None:
    thread = PortThread("test")
    done: list[str] = []
    begun, pressed = threading.Event(), threading.Event()

    def ordinary() -> None:
        begun.set()
        assert pressed.wait(5.0)
        assert thread.pressing()
        thread.do_urgent()
        assert not thread.pressing()
        done.append("ordinary")

    def urgent() -> None:
        assert not thread.pressing(), "nobody interrupts an urgent task"
        done.append("urgent")

    first = thread.begin(Task(ordinary))
    second = thread.begin(Task(lambda: done.append("second")))
    assert begun.wait(5.0)
    hasty = [thread.begin(Task(urgent), urgent=True) for _ in range(2)]
    pressed.set()
    for task in (*hasty, first, second):
        task.result(5.0)
    assert done == ["urgent", "urgent", "ordinary", "second"]
    thread.end()


def test_an_error_is_raised_to_who_waits_and_the_thread_goes_on() -> None:
    thread = PortThread("test")

    def fails() -> None:
        raise KeyError("here")

    with pytest.raises(KeyError, match="here"):
        thread.begin(Task(fails)).result(5.0)
    assert thread.begin(Task(lambda: 3)).result(5.0) == 3
    thread.end()


def test_whoever_does_not_want_to_wait_longer_is_told() -> None:
    thread = PortThread("test")
    gate = threading.Event()
    task = thread.begin(Task(gate.wait))
    with pytest.raises(TimeoutError):
        task.result(0.01)
    gate.set()
    assert task.result(5.0)
    thread.end()


def test_many_are_waited_for_in_the_order_in_which_they_finish() -> None:
    threads = [PortThread(f"test {i}") for i in range(3)]
    gates = [threading.Event() for _ in threads]
    finished: SimpleQueue[Task[Any]] = SimpleQueue()
    tasks = [t.begin(Task(gate.wait, finished)) for t, gate in zip(threads, gates, strict=True)]
    for number in (2, 0, 1):
        gates[number].set()
        assert finished.get(timeout=5.0) is tasks[number]
    for thread in threads:
        thread.end()


def test_ending_lets_ordinary_tasks_know() -> None:
    thread = PortThread("test")
    begun = threading.Event()

    def until_told() -> str:
        begun.set()
        while not thread.pressing():
            pass
        return "gave up"

    task = thread.begin(Task(until_told))
    assert begun.wait(5.0)
    thread.end()
    assert task.result(5.0) == "gave up"
