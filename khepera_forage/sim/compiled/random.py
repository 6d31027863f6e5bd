"""Random numbers of bodies, camera and policies in compiled worlds.

All are those of `counter_rng`: a number depends on the key, the round and the purpose only.
"""

from typing import Any

import numpy as np

from khepera_forage import counter_rng
from khepera_forage.compilation import overload, rule

DRAWS = 128
"""How many random numbers one round has."""
DRAW_WHEELS, DRAW_PROXIMITY, DRAW_MARKER, DRAW_POLICY = 0, 3, 7, 12
"""The first random number of each purpose within a round."""
DRAW_FOOD, FOOD_DRAWS = 16, 4
"""The first number of food object 0, and how many numbers each of `sim.arena.MOST_FOODS` food objects has."""
DRAW_BIAS = DRAWS - 3
"""The first of three numbers that the start of an episode uses."""

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_FIRST, _SECOND = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
_1, _2, _4, _12, _16, _27, _30, _31, _32, _56 = map(np.uint64, (1, 2, 4, 12, 16, 27, 30, 31, 32, 56))
_5S, _3S, _0F, _01 = map(
    np.uint64, (0x5555555555555555, 0x3333333333333333, 0x0F0F0F0F0F0F0F0F, 0x0101010101010101)
)
_LOW, _LOW_16 = np.uint64(0xFFFFFFFF), np.uint64(0xFFFF)
_DRAWS = np.uint64(DRAWS)
_DEVIATION = 1.0 / (16.0 + 1.0 / 6.0) ** 0.5


@overload(counter_rng.random_bits)  # Python's whole numbers have no size; these wrap around at 64 bits
def _random_bits(key: Any, number: Any) -> Any:
    def bits(key: Any, number: Any) -> Any:
        z = key + np.uint64(number) * _GOLDEN
        z = (z ^ (z >> _30)) * _FIRST
        z = (z ^ (z >> _27)) * _SECOND
        return z ^ (z >> _31)

    return bits


@overload(counter_rng.unit)
def _unit(bits: Any) -> Any:
    def number(bits: Any) -> Any:
        return (np.float64(bits >> _12) + 0.5) * 2.0**-52

    return number


rule(counter_rng.uniform)
rule(counter_rng.standard_normal)


@rule
def draw(robot: Any, number: int) -> Any:
    """64 random bits of this round."""
    return counter_rng.random_bits(robot.key, robot.round * _DRAWS + np.uint64(number))


@rule
def upper(bits: np.uint64) -> float:
    """A uniform number in (0, 1) from the upper half of 64 bits."""
    return (np.float64(bits >> _32) + 0.5) * 2.0**-32


@rule
def lower(bits: np.uint64) -> float:
    """A uniform number in (0, 1) from the lower half of 64 bits."""
    return (np.float64(bits & _LOW) + 0.5) * 2.0**-32


@rule
def halves(bits: np.uint64) -> tuple[np.uint64, np.uint64]:
    """64 random bits as two times 32, each at the lower end: the smoothing of two normal numbers."""
    return bits, bits >> _32


@rule
def normal(coins: np.uint64, smoothing: np.uint64) -> float:
    """A nearly normal number.

    The number of heads among 64 coins, smoothed by the sum of two 16-bit uniform numbers: mean 0 and variance 1
    exactly, skewness 0, excess kurtosis -0.03, no value beyond 8.2 standard deviations.

    Args:
        coins: 64 random bits.
        smoothing: At least 32 random bits, at the lower end.
    """
    n = coins - ((coins >> _1) & _5S)
    n = (n & _3S) + ((n >> _2) & _3S)
    n = (n + (n >> _4)) & _0F
    heads = np.float64((n * _01) >> _56)
    between = (np.float64((smoothing & _LOW_16) + ((smoothing >> _16) & _LOW_16)) + 1.0) * 2.0**-16
    return (heads - 33.0 + between) * _DEVIATION
