"""Random numbers of compiled bodies."""

import math
from typing import Any

import numba
import numpy as np
from scipy import stats

from khepera_forage.counter_rng import key_of, keys_of, lower, normal, random_bits, upper


@numba.njit
def _draws(key: Any, count: Any) -> Any:
    normals, highs, lows = np.empty(count), np.empty(count), np.empty(count)
    for n in range(count):
        bits, dither = random_bits(key, np.uint64(2 * n)), random_bits(key, np.uint64(2 * n + 1))
        normals[n], highs[n], lows[n] = normal(bits, dither), upper(bits), lower(bits)
    return normals, highs, lows


def test_normals_are_normal_and_uniforms_uniform() -> None:
    normals, highs, lows = _draws(np.uint64(key_of(1)), 400_000)
    assert abs(normals.mean()) < 0.006
    assert abs(normals.std() - 1) < 0.005
    assert abs(stats.skew(normals)) < 0.02
    assert abs(stats.kurtosis(normals) + 0.03) < 0.03
    for beyond in (1.0, 2.0, 3.0):
        expected = 2 * stats.norm.sf(beyond)
        assert abs((np.abs(normals) > beyond).mean() - expected) < 0.04 * expected + 3 * math.sqrt(
            expected / 400_000
        )
    assert stats.kstest(highs, "uniform").pvalue > 1e-3
    assert stats.kstest(lows, "uniform").pvalue > 1e-3
    assert abs(np.corrcoef(highs, lows)[0, 1]) < 0.006
    assert abs(np.corrcoef(normals[1:], normals[:-1])[0, 1]) < 0.006


def test_keys_of_seeds_are_distinct() -> None:
    assert len(np.unique(keys_of(np.arange(5000, dtype=np.uint64)))) == 5000
