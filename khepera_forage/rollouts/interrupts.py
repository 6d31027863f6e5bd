"""Delayed interrupts (Ctrl-C), for lines that must not be separated."""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def delayed_interrupts() -> Iterator[None]:
    """Raise an interrupt (Ctrl-C) that arrives within the block at the end of the block.

    Python may otherwise raise the interrupt after any call, for example between opening a file and storing the open
    file in a variable, so that nothing can close the file.
    """
    usual_handler = signal.getsignal(signal.SIGINT)
    if threading.current_thread() is not threading.main_thread() or not callable(usual_handler):
        yield  # Python raises interrupts only in the main thread, and only with a callable handler.
        return
    received: list[int] = []
    signal.signal(signal.SIGINT, lambda number, _: received.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, usual_handler)
        if received:
            signal.raise_signal(signal.SIGINT)
