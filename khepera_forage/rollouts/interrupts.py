"""Interrupts that come a moment later."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def interrupts_held() -> Iterator[None]:
    """An interrupt (Ctrl-C) within the block is raised at its end.

    For a few lines that must not be cut apart, as the opening of a file and the promise to close it: an interrupt may
    be raised after any call, even one whose result nobody holds yet.
    """
    usual = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(usual):
        yield  # nothing is raised here: Python tells its main thread alone, and only if it listens
        return
    held: list[int] = []
    signal.signal(signal.SIGINT, lambda number, _: held.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, usual)
        if held:
            signal.raise_signal(signal.SIGINT)
