"""Work shared out among threads: a compiled kernel runs in each of them, without Python's lock.

Numba's own `prange` would do the same, but has the outermost kernel optimised three times over: some ten seconds more
before the first step.
"""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any

import numba

BLOCKS_A_THREAD = 4
"""Blocks whose next round is worth a thread: to wake one takes about as long as four such rounds."""


def threads_for(pieces: int) -> int:
    """How many threads share out this many pieces of work: at most `numba.get_num_threads()`."""
    return max(1, min(numba.get_num_threads(), pieces))


def most_threads_for(pieces: int) -> int:
    """How many threads that may be, should `numba.set_num_threads` be called."""
    return max(1, min(int(numba.config.NUMBA_NUM_THREADS), pieces))  # type: ignore[attr-defined]


def share_out(kernel: Callable[..., Any], threads: int, *arguments: Any) -> None:
    """Run a kernel in threads, of which this is one; returns when there is nothing left to do.

    The kernel takes its work piece by piece from a counter among the arguments (see `counter`): no thread waits for
    another that was late, and one that has not begun when this one finds nothing left never does.

    Args:
        kernel: Takes the number of the thread, from 0, and `arguments`; compiled with `nogil`.
        threads: How many.
        *arguments: What all have in common.
    """
    others = [_pool(os.getpid()).submit(kernel, thread, *arguments) for thread in range(1, threads)]
    try:
        kernel(0, *arguments)
    finally:
        for other in others:
            if not other.cancel():
                other.result()


@cache
def _pool(process: int) -> ThreadPoolExecutor:
    """The threads of this process: a fork has none of its parent's."""
    return ThreadPoolExecutor(os.cpu_count(), thread_name_prefix=f"worlds of {process}")
