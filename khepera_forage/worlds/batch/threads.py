"""Blocks of worlds shared out among threads: a compiled kernel works on a range of them without Python's lock.

Numba's own `prange` would do the same, but has the outermost kernel optimised three times over: some ten seconds more
before the first step.
"""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, wait
from functools import cache
from itertools import pairwise
from typing import Any

import numba
import numpy as np
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numpy.typing import NDArray

from khepera_forage.worlds.batch.compiling import stand_in

ROUNDS = 4
"""Blocks whose next round is worth a thread: to hand work to one takes about as long as four such rounds."""


def threads_for(blocks: int, least: int = 1) -> int:
    """How many threads blocks are shared out among: at most `numba.get_num_threads()`, each with `least` or more."""
    return max(1, min(numba.get_num_threads(), blocks // least))


def share_out(kernel: Callable[..., Any], blocks: int, *arguments: Any, least: int = 1) -> None:
    """Have blocks worked on in as many threads as `threads_for` says; returns when all are done.

    Args:
        kernel: Takes the first block, the one after the last, and `arguments`; compiled with `nogil`.
        blocks: How many.
        *arguments: What all calls have in common.
        least: Blocks that a thread is worth.
    """
    threads = threads_for(blocks, least)
    own, *shares = pairwise(blocks * n // threads for n in range(threads + 1))
    others = [_pool(os.getpid()).submit(kernel, *share, *arguments) for share in shares]
    try:
        kernel(*own, *arguments)
    finally:
        wait(others)
    for other in others:
        other.result()


@cache
def _pool(process: int) -> ThreadPoolExecutor:
    """The threads of this process: a fork has none of its parent's."""
    return ThreadPoolExecutor(os.cpu_count(), thread_name_prefix=f"worlds of {process}")


def take(counter: NDArray[np.int64]) -> int:
    """How often this counter was asked before, by all threads together; each answer is given once.

    Args:
        counter: One number, 0 at first.
    """
    before = int(counter[0])
    counter[0] = before + 1
    return before


@intrinsic
def _add_one(typing_context: Any, counter: Any) -> Any:
    """Compiled: one indivisible addition, which numba has for graphics cards alone."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        array = context.make_array(signature.args[0])(context, builder, arguments[0])
        return builder.atomic_rmw("add", array.data, cgutils.intp_t(1), "monotonic")

    return types.int64(counter), generate


@stand_in(take)
def _take(counter: NDArray[np.int64]) -> int:
    return _add_one(counter)  # type: ignore[call-arg]
