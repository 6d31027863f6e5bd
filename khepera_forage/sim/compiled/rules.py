"""Makes the rules of simulated bodies known to numba: compiled worlds execute the functions that Python calls."""

from typing import Any

import numpy as np

from khepera_forage import counter_rng
from khepera_forage.compilation import overload, register, rule
from khepera_forage.geometry import plane
from khepera_forage.robots import khepera
from khepera_forage.sim import driving, sensing
from khepera_forage.vision import association, shapes

_1, _2, _4, _12, _27, _30, _31, _56 = map(np.uint64, (1, 2, 4, 12, 27, 30, 31, 56))
_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_FIRST, _SECOND = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
_5S, _3S, _0F, _01 = map(np.uint64, (0x5555555555555555, 0x3333333333333333, 0x0F0F0F0F0F0F0F0F, 0x0101010101010101))


# Python's whole numbers have no size; these wrap around at 64 bits.
@overload(counter_rng.random_bits)
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


@overload(counter_rng.heads)
def _heads(bits: Any) -> Any:
    def count(bits: Any) -> Any:
        n = bits - ((bits >> _1) & _5S)
        n = (n & _3S) + ((n >> _2) & _3S)
        n = (n + (n >> _4)) & _0F
        return (n * _01) >> _56

    return count


for _function in (
    *(counter_rng.uniform, counter_rng.standard_normal, counter_rng.draw),
    *(counter_rng.upper, counter_rng.lower, counter_rng.normal),
):
    rule(_function)
register(plane, khepera, shapes, association, driving, sensing)
