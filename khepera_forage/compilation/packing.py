"""The lanes of a block for which something is to be done, side by side: then instructions work on no others."""

from typing import Any

import numpy as np
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import inline, kernel, stand_in
from khepera_forage.sim.compiled.rows import LANES

_ONE, _WORD = np.uint64(1), 64


@kernel
def pack(w: NDArray[np.float64], marks: int, numbers: int, count: int) -> int:
    """Write the numbers of the marked lanes side by side.

    The marks are gathered to words of 64 bits, and only bits that are set are looked at: mostly few lanes are marked.

    Args:
        w: The work rows.
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
            bits |= _bit(w[marks * LANES + first + k], k)
        count = _write(w, numbers, count, first, bits)
    bits = np.uint64(0)
    for k in range(LANES % _WORD):
        bits |= _bit(w[marks * LANES + whole + k], k)
    return _write(w, numbers, count, whole, bits)


@inline
def packed(w: NDArray[np.float64], numbers: int, n: int) -> int:
    """Number n of those that `pack` wrote to a row."""
    # Of an index that might be negative, for all the compiler knows, every use would be checked.
    return int(w[numbers * LANES + n]) & 0xFFFF


@inline
def _bit(mark: float, k: int) -> np.uint64:
    return _ONE << np.uint64(k) if mark != 0.0 else np.uint64(0)


@inline
def _write(w: NDArray[np.float64], numbers: int, count: int, first: int, bits: np.uint64) -> int:
    """Write the numbers of the bits that are set, counted from `first`."""
    while bits != 0:
        w[numbers * LANES + count] = first + lowest(bits)
        bits &= bits - _ONE
        count += 1
    return count


def lowest(bits: np.uint64) -> int:
    """Number of the lowest bit that is set, where one is."""
    whole = int(bits)
    return (whole & -whole).bit_length() - 1


@intrinsic
def _count_zeros(typing_context: Any, bits: Any) -> Any:
    """Compiled: one instruction, to which numba gives no name."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.cttz(arguments[0], cgutils.true_bit)

    return types.int64(types.uint64), generate


@stand_in(lowest)
def _lowest(bits: np.uint64) -> int:
    return _count_zeros(bits)  # type: ignore[call-arg]
