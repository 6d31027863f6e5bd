"""The counter-based generator of `khepera_forage.counter_rng` on machine words, for compiled code."""

import numpy as np

from khepera_forage import counter_rng
from khepera_forage.compilation.decorators import inline, stand_in

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_FIRST, _SECOND = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
_12, _30, _27, _31 = np.uint64(12), np.uint64(30), np.uint64(27), np.uint64(31)


@stand_in(counter_rng.random_bits)
def random_bits(key: np.uint64, number: int) -> np.uint64:
    """See `counter_rng.random_bits`."""
    z = key + np.uint64(number) * _GOLDEN
    z = (z ^ (z >> _30)) * _FIRST
    z = (z ^ (z >> _27)) * _SECOND
    return z ^ (z >> _31)


@stand_in(counter_rng.unit)
def unit(bits: np.uint64) -> float:
    """See `counter_rng.unit`."""
    return (np.float64(bits >> _12) + 0.5) * 2.0**-52


for _function in (counter_rng.uniform, counter_rng.standard_normal):
    inline(_function)
