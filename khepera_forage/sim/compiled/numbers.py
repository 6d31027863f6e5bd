"""Random numbers by counting: number n of a world follows from the world's key and n alone.

The generator is SplitMix64 (Steele, Lea and Flood 2014), whose n-th number is a hash of key + n * golden ratio. So a
world draws the same numbers whatever stands beside it, and no number waits for the one before it.
"""

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import inline

DRAWS = 128
"""Random numbers of one round. Their numbers within the round:"""
DRAW_WHEELS, DRAW_PROXIMITY, DRAW_MARKER, DRAW_POLICY = 0, 3, 7, 12
DRAW_FOOD, FOOD_DRAWS = 16, 4
"""The first number of food object 0, and how many numbers each food object has."""
DRAW_BIAS = DRAWS - 3
"""The first of three numbers that the start of an episode uses."""
MOST_FOODS = 16
"""Food objects that there are random numbers for."""

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_FIRST, _SECOND = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
_30, _27, _31 = np.uint64(30), np.uint64(27), np.uint64(31)
_1, _2, _4, _56, _32, _48, _16 = (np.uint64(n) for n in (1, 2, 4, 56, 32, 48, 16))
_5S, _3S, _0F, _01 = (
    np.uint64(n) for n in (0x5555555555555555, 0x3333333333333333, 0x0F0F0F0F0F0F0F0F, 0x0101010101010101)
)
_LOW = np.uint64(0xFFFFFFFF)
_LOW_16 = np.uint64(0xFFFF)
_SHARE_32, _SHARE_16 = 2.0**-32, 2.0**-16
_DEVIATION = 1.0 / (16.0 + 1.0 / 6.0) ** 0.5


@inline
def word(key: np.uint64, number: np.uint64) -> np.uint64:
    """64 random bits: number `number` of the world with this key."""
    z = key + number * _GOLDEN
    z = (z ^ (z >> _30)) * _FIRST
    z = (z ^ (z >> _27)) * _SECOND
    return z ^ (z >> _31)


@inline
def upper(bits: np.uint64) -> float:
    """A uniform number in (0, 1) from the upper half of 64 bits."""
    return (np.float64(bits >> _32) + 0.5) * _SHARE_32


@inline
def lower(bits: np.uint64) -> float:
    """A uniform number in (0, 1) from the lower half of 64 bits."""
    return (np.float64(bits & _LOW) + 0.5) * _SHARE_32


@inline
def normal(coins: np.uint64, dither: np.uint64) -> float:
    """A standard normal number, nearly.

    The heads of 64 coins, smoothed by the sum of two 16-bit uniform numbers: mean 0 and variance 1 exactly, skewness 0,
    excess kurtosis -0.03, no value beyond 8.2 deviations.

    Args:
        coins: 64 random bits.
        dither: At least 32 random bits, at the lower end.
    """
    n = coins - ((coins >> _1) & _5S)
    n = (n & _3S) + ((n >> _2) & _3S)
    n = (n + (n >> _4)) & _0F
    heads = np.float64((n * _01) >> _56)
    between = (np.float64((dither & _LOW_16) + ((dither >> _16) & _LOW_16)) + 1.0) * _SHARE_16
    return (heads - 33.0 + between) * _DEVIATION


def keys_of(seed: int, worlds: NDArray[np.int64]) -> NDArray[np.uint64]:
    """The keys of worlds of a seed: that of world i does not depend on how many others there are.

    Args:
        seed: Any whole number of at least 0.
        worlds: Their numbers, of any shape.
    """
    base = np.random.SeedSequence(seed).generate_state(1, np.uint64)
    with np.errstate(over="ignore"):
        keys: NDArray[np.uint64] = word(base, worlds.astype(np.uint64) + _1)  # type: ignore[arg-type, assignment]
    return keys


def keys_of_each(seeds: Iterable[int]) -> NDArray[np.uint64]:
    """The key of world 0 of each of some seeds, each at least 0."""
    zero = np.zeros(1, np.int64)
    return np.concatenate([keys_of(seed, zero) for seed in seeds])
