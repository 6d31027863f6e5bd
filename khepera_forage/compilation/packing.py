"""Packing: the numbers of marked lanes side by side, so that a loop works on these lanes only."""

from typing import Any

import numpy as np
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import inline, kernel, stand_in

_ONE, _WORD = np.uint64(1), 64
_STRIDE = 8
"""Numbers that one instruction handles."""


@kernel
def pack(marks: NDArray[np.float64], lane: NDArray[np.uint16], count: int) -> int:
    """Write the numbers of the marked lanes side by side.

    The marks are gathered into words of 64 bits, and only set bits are visited: mostly few lanes are marked.

    Args:
        marks: One number a lane, 1.0 or 0.0.
        lane: Where to write the numbers of the lanes.
        count: How many numbers `lane` has already.

    Returns:
        How many numbers `lane` has then.
    """
    lanes = marks.shape[0]
    whole = lanes // _WORD * _WORD
    for first in range(0, whole, _WORD):
        bits = np.uint64(0)
        for k in range(_WORD):
            bits |= _bit(marks[first + k], k)
        count = _write(lane, count, first, bits)
    bits = np.uint64(0)
    for k in range(lanes % _WORD):
        bits |= _bit(marks[whole + k], k)
    return _write(lane, count, whole, bits)


@inline
def rounded_up(count: int, lanes: int) -> int:
    """A number of packed lanes rounded up, so that a loop over them has no remainder.

    What the loop writes beyond `count` must not be used.
    """
    stride = min(_STRIDE, lanes)
    return (count + stride - 1) & -stride


@inline
def _bit(mark: float, k: int) -> np.uint64:
    return _ONE << np.uint64(k) if mark != 0.0 else np.uint64(0)


@inline
def _write(lane: NDArray[np.uint16], count: int, first: int, bits: np.uint64) -> int:
    """Write the numbers of the set bits, counted from `first`."""
    while bits != 0:
        lane[count] = first + lowest(bits)
        bits &= bits - _ONE
        count += 1
    return count


def lowest(bits: np.uint64) -> int:
    """Number of the lowest set bit of a word that is not 0."""
    whole = int(bits)
    return (whole & -whole).bit_length() - 1


@intrinsic
def _count_zeros(typing_context: Any, bits: Any) -> Any:
    """Count trailing zeros: one instruction for which numba has no name."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        return builder.cttz(arguments[0], cgutils.true_bit)

    return types.int64(types.uint64), generate


@stand_in(lowest)
def _lowest(bits: np.uint64) -> int:
    return _count_zeros(bits)  # type: ignore[call-arg]
