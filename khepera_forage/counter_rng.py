"""Counter-based random numbers: number n of a key follows from the key and n alone.

The generator is SplitMix64 (Steele, Lea and Flood 2014), whose n-th number is a hash of key + n * golden ratio.
Layouts and food types are drawn by it, so that a seed has the same ones on every backend, in a batch of any size.
So are the random numbers of bodies, camera and policies, which depend on the key, the round and the purpose only: a
source of noise can be changed without shifting the numbers of another.

Plain functions. Compiled code has its own `random_bits`, `unit` and `heads` on machine words (`sim.compiled.world`),
with equal results.
"""

import math
from collections.abc import Sequence
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


def keys_of(seeds: Sequence[int] | NDArray[np.integer[Any]]) -> NDArray[np.uint64]:
    """`key_of` of many seeds, such as those of a range."""
    if max(seeds) > _MASK:
        return np.array([key_of(seed) for seed in seeds], np.uint64)
    keys: NDArray[np.uint64] = random_bits(np.array(seeds, np.uint64), np.uint64(1))
    return keys


DRAWS = 128
"""How many random numbers one round has."""
DRAW_WHEELS, DRAW_PROXIMITY, DRAW_MARKER, DRAW_POLICY = 0, 3, 7, 12
"""The first random number of each purpose within a round: wheels have 3, infra-reds 4, the marker 5, a policy 1.

Those from 13 to 15, and from 80 to 124, are free.
"""
DRAW_FOOD, FOOD_DRAWS = 16, 4
"""The first number of food object 0, and how many numbers each of `sim.arena.MOST_FOODS` food objects has."""
DRAW_BIAS = DRAWS - 3
"""The first of three numbers that the start of an episode uses."""

_DEVIATION = 1.0 / (16.0 + 1.0 / 6.0) ** 0.5


def draw(robot: Any, number: int) -> Any:
    """64 random bits of this round."""
    return random_bits(robot.key, robot.round * DRAWS + number)


def upper(bits: Any) -> float:
    """A uniform number in (0, 1) from the upper half of 64 bits."""
    return (float(bits >> 32) + 0.5) * 2.0**-32


def lower(bits: Any) -> float:
    """A uniform number in (0, 1) from the lower half of 64 bits."""
    return (float(bits & 0xFFFFFFFF) + 0.5) * 2.0**-32


def normal(coins: Any, smoothing: Any) -> float:
    """A nearly normal number.

    The number of heads among 64 coins, smoothed by the sum of two 16-bit uniform numbers: mean 0 and variance 1
    (up to 1e-11), skewness 0, excess kurtosis -0.03, no value beyond 8.21 standard deviations.

    Args:
        coins: 64 random bits.
        smoothing: At least 32 random bits, at the lower end.
    """
    between = (float((smoothing & 0xFFFF) + ((smoothing >> 16) & 0xFFFF)) + 1.0) * 2.0**-16
    return (float(heads(coins)) - 33.0 + between) * _DEVIATION
