"""Random numbers of compiled bodies, and compiled plane geometry."""

import math
from typing import Any

import numba
import numpy as np
from khepera_forage.compilation.trigonometry import cosine_sine, direction
from khepera_forage.sim.compiled.numbers import lower, normal, upper
from scipy import stats

from khepera_forage.counter_rng import key_of, keys_of, random_bits
from khepera_forage.geometry import angles


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


def test_polynomials_are_as_good_as_the_library() -> None:
    turns = np.random.default_rng(0).uniform(-100, 100, 20_000)
    for angle in turns.tolist():
        c, s = cosine_sine(angle)
        assert abs(c - math.cos(angle)) < 4e-15
        assert abs(s - math.sin(angle)) < 4e-15
        assert abs(direction(c, s) - math.atan2(s, c)) < 1e-15
    for x, y in ((0, 0), (1, 0), (-1, 0), (0, 1), (0, -1), (-1, 1e-9)):
        assert direction(x, y) == math.atan2(y, x)


def test_compiled_angles_are_those_of_the_task() -> None:
    from khepera_forage.envs.compiled import rules

    rng = np.random.default_rng(2)
    for a, b in rng.uniform(-400, 400, (5000, 2)).tolist():
        assert abs(rules.turn_to(a, b) - angles.turn_to(a, b)) < 1e-12
        assert abs(rules.bearing_of(a, b) - angles.bearing_of(a, b)) < 1e-12
        assert abs(rules.length(a, b) - angles.length(a, b)) < 1e-12
        assert abs(rules.sine(a) - angles.sine(a)) < 1e-12
        assert abs(rules.arcsine(b / 400) - angles.arcsine(b / 400)) < 1e-10
    assert [rules.heading_of(float(degrees)) for degrees in range(360)] == list(angles.HEADINGS)
