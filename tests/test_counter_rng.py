"""The counter-based generator: SplitMix64, its statistics, and the same numbers from Python and numpy."""

from collections.abc import Callable
from statistics import NormalDist
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from khepera_forage.counter_rng import key_of, random_bits, standard_normal, uniform

WORDS = st.integers(0, 2**64 - 1)
COUNT = 20_000


PUBLISHED = {
    1234567: "599ed017fb08fc85 2c73f08458540fa5 883ebce5a3f27c77 3fbef740e9177b3f e3b8346708cb5ecd",
    0: "e220a8397b1dcdaf 6e789e6aa1b965f4 06c45d188009454f",
}


@pytest.mark.parametrize("seed", PUBLISHED)
def test_random_bits_are_the_published_outputs_of_splitmix64(seed: int) -> None:
    outputs = [int(output, 16) for output in PUBLISHED[seed].split()]
    assert [random_bits(seed, number) for number in range(1, len(outputs) + 1)] == outputs


@given(key=WORDS, number=st.integers(0, 2**48))
def test_random_bits_agree_between_python_and_numpy(key: int, number: int) -> None:
    expected = random_bits(key, number)
    assert 0 <= expected < 2**64
    keys = np.full(3, key, np.uint64)
    numbers = np.full(3, number, np.uint64)
    assert random_bits(keys, numbers).tolist() == [expected] * 3


def test_key_of_a_seed_uses_all_of_its_bits() -> None:
    seeds = [0, 1, 2**32, 2**63, 2**64, 2**64 + 1, 2**128, 3 * 2**200]
    keys = {key_of(seed) for seed in seeds}
    assert len(keys) == len(seeds)
    assert all(type(key) is int and 0 <= key < 2**64 for key in keys)


SEQUENCES: dict[str, Callable[[int], float]] = {
    "numbers of a key": lambda i: uniform(key_of(7), i),
    "first numbers of the keys of seeds": lambda i: uniform(key_of(i), 0),
    "probabilities of normal numbers": lambda i: NormalDist().cdf(standard_normal(key_of(3), i)),
}


def chi_squared(counts: NDArray[Any]) -> float:
    """How far counts are from equal ones."""
    return float(np.sum((counts - counts.mean()) ** 2) / counts.mean())


@pytest.mark.parametrize("name", SEQUENCES)
def test_numbers_are_uniform_and_independent(name: str) -> None:
    values = np.array([SEQUENCES[name](i) for i in range(COUNT)])
    counts, _ = np.histogram(values, bins=20, range=(0.0, 1.0))
    assert chi_squared(counts) < 43.8, "19 degrees of freedom, p = 0.001"
    for lag in (1, 2, 3):
        pairs, *_ = np.histogram2d(values[lag:], values[:-lag], bins=10, range=((0, 1), (0, 1)))
        assert chi_squared(pairs) < 148.2, "99 degrees of freedom, p = 0.001"
