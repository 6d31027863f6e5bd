"""Counter-based random numbers: number n of a key follows from the key and n alone.

The generator is SplitMix64 (Steele, Lea and Flood 2014), whose n-th number is a hash of key + n * golden ratio.
Layouts and food types are drawn by it, so that a seed has the same ones on every backend, in a batch of any size.
Compiled code has its own `random_bits`, `unit` and `heads` on machine words (`sim.compiled.rules`), with equal results.
"""

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

_MASK = 0xFFFFFFFFFFFFFFFF
_GOLDEN, _FIRST, _SECOND = 0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB


def random_bits(key: Any, number: Any) -> Any:
    """64 random bits: number `number` of a key."""
    z = (key + number * _GOLDEN) & _MASK
    z = ((z ^ (z >> 30)) * _FIRST) & _MASK
    z = ((z ^ (z >> 27)) * _SECOND) & _MASK
    return z ^ (z >> 31)


def unit(bits: Any) -> float:
    """A number in (0, 1) from 64 bits, of which 52 count: with one more, the largest would round to 1."""
    return float(((bits >> 12) + 0.5) * 2.0**-52)


def heads(bits: Any) -> int:
    """How many of 64 bits are set."""
    return int(bits.bit_count())


def uniform(key: Any, number: int) -> float:
    """Uniform number `number` of a key, in (0, 1)."""
    return unit(random_bits(key, number))


def standard_normal(key: Any, number: int) -> float:
    """Standard normal number `number` of a key, from two uniform ones (Box and Muller 1958)."""
    radius = math.sqrt(-2.0 * math.log(uniform(key, 2 * number)))
    return radius * math.cos(2.0 * math.pi * uniform(key, 2 * number + 1))


def key_of(seed: int) -> int:
    """The key of a seed.

    Args:
        seed: Any whole number of at least 0.
    """
    key = 0
    while True:
        key = random_bits(key ^ (seed & _MASK), 1)
        seed >>= 64
        if not seed:
            return int(key)


def keys_of(seeds: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """`key_of` of many seeds below 2**64."""
    keys: NDArray[np.uint64] = random_bits(seeds, np.uint64(1))
    return keys
