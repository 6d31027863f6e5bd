"""Random numbers of bodies and camera: which numbers a round has, and uniform and normal numbers of 64 random bits.

The bits are those of `counter_rng`: they depend on the world's key, the round and the purpose only.
"""

import numpy as np

from khepera_forage.compilation import counter_rng  # noqa: F401 (registers the random bits)
from khepera_forage.compilation.decorators import inline

DRAWS = 128
"""How many random numbers one round has."""
DRAW_WHEELS, DRAW_PROXIMITY, DRAW_MARKER, DRAW_POLICY = 0, 3, 7, 12
"""The first random number of each purpose within a round."""
DRAW_FOOD, FOOD_DRAWS = 16, 4
"""The first number of food object 0, and how many numbers each food object has."""
DRAW_BIAS = DRAWS - 3
"""The first of three numbers that the start of an episode uses."""
MOST_FOODS = 16
"""Food objects that there are random numbers for."""

_1, _2, _4, _56, _32, _48, _16 = (np.uint64(n) for n in (1, 2, 4, 56, 32, 48, 16))
_5S, _3S, _0F, _01 = (
    np.uint64(n) for n in (0x5555555555555555, 0x3333333333333333, 0x0F0F0F0F0F0F0F0F, 0x0101010101010101)
)
_LOW = np.uint64(0xFFFFFFFF)
_LOW_16 = np.uint64(0xFFFF)
_SHARE_32, _SHARE_16 = 2.0**-32, 2.0**-16
_DEVIATION = 1.0 / (16.0 + 1.0 / 6.0) ** 0.5


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
    """A nearly normal number.

    The number of heads among 64 coins, smoothed by the sum of two 16-bit uniform numbers: mean 0 and variance 1
    exactly, skewness 0, excess kurtosis -0.03, no value beyond 8.2 standard deviations.

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
