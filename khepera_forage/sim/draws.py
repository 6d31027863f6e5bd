"""Random numbers of bodies, camera and policies: each depends on the key, the round and the purpose only.

They are those of `counter_rng`. So a source of noise can be changed without shifting the numbers of another, and both
backends draw the same ones. Plain functions, also compiled; 64 random bits are a whole number in Python.
"""

from typing import Any

from khepera_forage.counter_rng import heads, random_bits

DRAWS = 128
"""How many random numbers one round has."""
DRAW_WHEELS, DRAW_PROXIMITY, DRAW_MARKER, DRAW_POLICY = 0, 3, 7, 12
"""The first random number of each purpose within a round."""
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
    exactly, skewness 0, excess kurtosis -0.03, no value beyond 8.2 standard deviations.

    Args:
        coins: 64 random bits.
        smoothing: At least 32 random bits, at the lower end.
    """
    between = (float((smoothing & 0xFFFF) + ((smoothing >> 16) & 0xFFFF)) + 1.0) * 2.0**-16
    return (float(heads(coins)) - 33.0 + between) * _DEVIATION
