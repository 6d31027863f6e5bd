"""Highest rates of one core: simple loops over arrays in its first cache, compiled like the kernels."""

import re
from collections.abc import Callable
from time import perf_counter
from typing import Any, NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

_LANES = 256
"""Numbers in a row: nine rows take 18 kB."""
_ROUNDS = 2_000
_Rows = NDArray[np.float64]
_compiled = numba.njit(error_model="numpy", boundscheck=False)


class Peak(NamedTuple):
    """A loop, and how many operations it does for a number.

    Attributes:
        name: What it does.
        loop: Of rows and rounds.
        operations: For each number of a row, in each round.
    """

    name: str
    loop: Callable[[_Rows, int], None]
    operations: int


# In every loop, numbers stay between 0.5 and 2 however often it runs. Factors and thresholds come from `rows`, so that
# the compiler cannot compute anything in advance. Only rows are read and written, in order.


@_compiled
def _arithmetic(rows: _Rows, rounds: int) -> None:
    a, b = rows[8, 0] * 0.25, rows[8, 1] * 0.75
    for _ in range(rounds):
        for i in range(_LANES):
            x = rows[0, i]
            x = x * a + b
            x = x * b + a
            x = x * a + b
            x = x * b + a
            x = x * a + b
            x = x * b + a
            x = x * a + b
            rows[0, i] = x * b + a


@_compiled
def _comparisons(rows: _Rows, rounds: int) -> None:
    a, b, c, d = rows[8, 0] * 0.9, rows[8, 1] * 1.1, rows[8, 2] * 0.8, rows[8, 3] * 1.2
    for _ in range(rounds):
        for i in range(_LANES):
            x, y = rows[0, i], rows[1, i]
            x = y if x < a else x
            y = x if y > b else y
            x = y if x < c else x
            y = x if y > d else y
            x = y if x < b else x
            y = x if y > a else y
            x = y if x < d else x
            y = x if y > c else y
            rows[0, i] = y
            rows[1, i] = x


@_compiled
def _divisions(rows: _Rows, rounds: int) -> None:
    a = rows[8, 0] * 1.1
    for _ in range(rounds):
        for i in range(_LANES):
            rows[0, i] = a / (a / (a / (a / rows[0, i])))


@_compiled
def _roots(rows: _Rows, rounds: int) -> None:
    for _ in range(rounds):
        for i in range(_LANES):
            rows[0, i] = np.sqrt(np.sqrt(np.sqrt(np.sqrt(rows[0, i]))))


@_compiled
def _memory(rows: _Rows, rounds: int) -> None:
    # Each round has different rows, or the compiler would keep them in registers.
    for n in range(rounds):
        one, two, three, four = n & 1, 2 + (n & 1), 4 + (n & 1), 6 + (n & 1)
        for i in range(_LANES):
            rows[four, i] = max(max(rows[one, i], rows[two, i]), rows[three, i])


PEAKS = ARITHMETIC, COMPARISONS, DIVISIONS, ROOTS, MEMORY = (
    Peak("additions and multiplications", _arithmetic, 16),
    Peak("comparisons, each with a choice", _comparisons, 8),
    Peak("divisions", _divisions, 4),
    Peak("square roots", _roots, 4),
    Peak("loads and stores, three to one", _memory, 4),
)


def rate(peak: Peak) -> float:
    """Operations of a core in a nanosecond, each on one number."""
    rows = np.ones((9, _LANES))
    peak.loop(rows, 1)  # compiles
    start = perf_counter()
    peak.loop(rows, _ROUNDS)
    return _ROUNDS * _LANES * peak.operations / (perf_counter() - start) / 1e9


def width(peak: Peak) -> int:
    """Bits of the widest registers that the compiled loop computes in (0: none that are known)."""
    loop: Any = peak.loop
    code = "\n".join(loop.inspect_asm().values())
    names = {"z": 512, "y": 256, "x": 128}
    packed = re.findall(r"\bv(?:add|mul|max|cmp\w*|div|sqrt|blendm|mova|movu)pd\b.*%([xyz])mm", code)
    return max((names[name] for name in packed), default=0)
