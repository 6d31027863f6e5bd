"""Threads: the same compiled kernel runs in several threads, without Python's lock.

Numba's `prange` does the same, but optimises the outermost kernel three times: ten seconds more before the first step.
"""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any

import numba

BLOCKS_A_THREAD = 4
"""Blocks of worlds for which another thread pays: waking a thread takes as long as one round of four blocks."""


def threads_for(pieces: int) -> int:
    """Number of threads for this many pieces of work: at most `numba.get_num_threads()`."""
    return max(1, min(numba.get_num_threads(), pieces))


def most_threads_for(pieces: int) -> int:
    """The largest number of threads for this many pieces of work, whatever `numba.set_num_threads` is called with."""
    return max(1, min(int(numba.config.NUMBA_NUM_THREADS), pieces))  # type: ignore[attr-defined]


def share_out(kernel: Callable[..., Any], threads: int, *arguments: Any) -> None:
    """Run a kernel in several threads, one of them the caller's; returns when no work is left.

    The kernel takes its work piece by piece from a counter among the arguments (see `work_queue`). So no thread waits
    for a slower one, and a thread that has not started when the work is done never starts.

    Args:
        kernel: An entrance whose first argument is the number of the thread, from 0.
        threads: Number of threads.
        *arguments: The other arguments, the same in all threads.
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
    """The threads of this process; a forked process has its own."""
    return ThreadPoolExecutor(os.cpu_count(), thread_name_prefix=f"worlds of {process}")
