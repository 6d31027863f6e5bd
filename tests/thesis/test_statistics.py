"""Intervals over replications, and percentile ranks among experiments."""

import math
from typing import NamedTuple

import numpy as np
import pytest

from khepera_forage.estimates import (
    MIN_REPLICATIONS,
    Floats,
    bootstrap,
    bootstrap_quantile,
    contrast,
    percentile_rank,
    ratio,
    replications,
    sums_by_replication,
    wilson,
)


class Row(NamedTuple):
    replication: int
    value: float


def _one(row: Row) -> float:
    return 1.0


def _value(row: Row) -> float:
    return row.value


def _rows(rng: np.random.Generator, count: int, each: int, between: float, within: float) -> list[Row]:
    centres = rng.normal(0, between, count)
    return [Row(i, float(v)) for i in range(count) for v in rng.normal(centres[i], within, each)]


def _sums(rows: list[Row]) -> Floats:
    return sums_by_replication(rows, replications(rows), _value, _one)


def test_bootstrap_intervals_have_their_nominal_coverage() -> None:
    """Rows of a replication are correlated here; intervals over rows would be too narrow."""
    rng = np.random.default_rng(5)
    covered = 0
    for _ in range(300):
        estimate = bootstrap(_sums(_rows(rng, 30, 10, between=1.0, within=0.5)), ratio, rng, 400)
        covered += estimate.low <= 0.0 <= estimate.high
    assert 0.89 <= covered / 300 <= 0.98


def test_contrast_cancels_differences_between_replications() -> None:
    rng = np.random.default_rng(7)
    first = _rows(rng, 15, 4, between=5.0, within=0.01)
    second = [Row(row.replication, row.value + 1.0) for row in first]
    estimate = bootstrap(np.hstack([_sums(second), _sums(first)]), contrast(1, -1), rng)
    assert estimate == pytest.approx((1.0, 1.0, 1.0))


@pytest.mark.parametrize("count", [1, MIN_REPLICATIONS - 1])
def test_few_replications_have_no_interval(count: int) -> None:
    rows = [Row(i, value) for i in range(count) for value in (1.0, 3.0)]
    rng = np.random.default_rng(1)
    for estimate, value in (
        (bootstrap(_sums(rows), ratio, rng), 2.0),
        (bootstrap_quantile(rows, _value, 0.95, rng), 3.0),
    ):
        assert estimate.value == value
        assert math.isnan(estimate.low)
        assert math.isnan(estimate.high)


def test_estimates_without_data_are_nan() -> None:
    rng = np.random.default_rng(1)
    for sums in (np.zeros((0, 2)), np.zeros((5, 2))):
        assert all(map(math.isnan, bootstrap(sums, ratio, rng)))
    assert all(map(math.isnan, bootstrap_quantile([], _value, 0.95, rng)))
    assert all(map(math.isnan, wilson(0, 0)))


def test_bootstrap_of_a_mostly_undefined_statistic_has_no_interval() -> None:
    """Each mean has rows in only one of twenty replications, so that only 40 % of the resamples contain both."""
    first, second = np.zeros((20, 2)), np.zeros((20, 2))
    first[3] = second[11] = 1.0
    rng = np.random.default_rng(1)
    assert bootstrap(first, ratio, rng) == (1.0, 1.0, 1.0)
    both = bootstrap(np.hstack([first, second]), contrast(1, 1), rng)
    assert both.value == 2.0
    assert math.isnan(both.low)


def test_quantile_is_not_exceeded_by_its_share_of_the_rows() -> None:
    rows = [Row(i % 5, float(i)) for i in range(1, 101)]
    estimate = bootstrap_quantile(rows, _value, 0.95, np.random.default_rng(1))
    assert estimate.value == 95.0
    assert 85 <= estimate.low <= 95 <= estimate.high <= 100


def test_quantile_may_be_infinite() -> None:
    rows = [Row(i % 5, math.inf if i % 10 == 0 else 100.0) for i in range(100)]
    assert bootstrap_quantile(rows, _value, 0.95, np.random.default_rng(1)).value == math.inf
    assert bootstrap_quantile(rows, _value, 0.5, np.random.default_rng(1)) == (100.0, 100.0, 100.0)


def test_percentile_rank_counts_experiments_below_the_value() -> None:
    experiments = [float(i) for i in range(1, 20)]
    ranks = {10.0: (50.0, 1.0), 2.0: (100 * 1.5 / 19, 2 * 3 / 20), 25.0: (100.0, 2 / 20)}
    for value, rank in ranks.items():
        assert percentile_rank(value, experiments) == pytest.approx(rank)
    for few in ([], [3.0]):
        assert all(map(math.isnan, percentile_rank(3.0, few)))


def test_percentile_rank_tail_has_its_nominal_frequency() -> None:
    """One more experiment has a tail of at most 0.1 in at most a tenth of all cases."""
    rng = np.random.default_rng(9)
    outer = sum(percentile_rank(v[0], v[1:].tolist())[1] <= 0.1 for v in rng.normal(size=(4000, 40)))
    assert 0.08 <= outer / 4000 <= 0.11


def test_wilson_equals_a_published_example() -> None:
    """Newcombe (1998): 81 of 263."""
    assert wilson(81, 263) == pytest.approx((0.3080, 0.2553, 0.3662), abs=5e-5)
    assert wilson(0, 10) == pytest.approx((0.0, 0.0, 0.2775), abs=5e-5)
