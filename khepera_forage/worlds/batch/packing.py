"""The lanes of a block for which something is to be done, side by side: then instructions work on no others."""

from typing import Any

import llvmlite.ir as ir
import numpy as np
from numba import types
from numba.extending import intrinsic
from numpy.typing import NDArray

from khepera_forage.worlds.batch.compiling import inline, kernel
from khepera_forage.worlds.batch.rows import LANES

_ONE, _WORD = np.uint64(1), 64


@kernel
def pack(s: NDArray[np.float64], marks: int, numbers: int, count: int) -> int:
    """Write the numbers of the marked lanes side by side.

    The marks are gathered to words of 64 bits, and only bits that are set are looked at: mostly few lanes are marked.

    Args:
        s: Rows of a block.
        marks: Row of the marks, 1 or 0.
        numbers: Row to write to.
        count: How many numbers it has already.

    Returns:
        How many it has then.
    """
    whole = LANES // _WORD * _WORD
    for first in range(0, whole, _WORD):
        bits = np.uint64(0)
        for k in range(_WORD):
            bits |= _bit(s[marks * LANES + first + k], k)
        count = _write(s, numbers, count, first, bits)
    bits = np.uint64(0)
    for k in range(LANES % _WORD):
        bits |= _bit(s[marks * LANES + whole + k], k)
    return _write(s, numbers, count, whole, bits)


@inline
def packed(s: NDArray[np.float64], numbers: int, n: int) -> int:
    """Number n of those that `pack` wrote to a row."""
    # Of an index that might be negative, for all the compiler knows, every use would be checked.
    return int(s[numbers * LANES + n]) & 0xFFFF


@inline
def _bit(mark: float, k: int) -> np.uint64:
    return _ONE << np.uint64(k) if mark != 0.0 else np.uint64(0)


@inline
def _write(s: NDArray[np.float64], numbers: int, count: int, first: int, bits: np.uint64) -> int:
    """Write the numbers of the bits that are set, counted from `first`."""
    while bits != 0:
        s[numbers * LANES + count] = first + _lowest(bits)  # type: ignore[call-arg, arg-type]
        bits &= bits - _ONE
        count += 1
    return count


@intrinsic
def _lowest(typing_context: Any, bits: Any) -> Any:
    """Number of the lowest bit that is set, of an `np.uint64` in which one is: one instruction."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.cttz(arguments[0], ir.Constant(ir.IntType(1), 1))

    return types.int64(types.uint64), generate
