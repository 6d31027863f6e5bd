"""Intervals over replications, and percentile ranks among experiments."""

import math
from typing import NamedTuple

import numpy as np
import pytest

from khepera_forage import estimates


class Row(NamedTuple):
    replication: int
    value: float


def _value(row: Row) -> float:
    return row.value


def _rows(rng: np.random.Generator, count: int, each: int, between: float, within: float) -> list[Row]:
    centres = rng.normal(0, between, count)
    return [Row(i, float(v)) for i in range(count) for v in rng.normal(centres[i], within, each)]


def _sums(rows: list[Row]) -> estimates.Floats:
    return estimates.sums_by_replication(rows, estimates.replications(rows), _value, lambda row: 1.0)


def test_bootstrap_intervals_have_their_nominal_coverage() -> None:
    """Rows of a replication are correlated here; intervals over rows would be too narrow."""
    rng = np.random.default_rng(5)
    covered = 0
    for _ in range(300):
        estimate = estimates.bootstrap(_sums(_rows(rng, 30, 10, between=1.0, within=0.5)), estimates.ratio, rng, 400)
        covered += estimate.low <= 0.0 <= estimate.high
    assert 0.89 <= covered / 300 <= 0.98


def test_contrast_cancels_differences_between_replications() -> None:
    rng = np.random.default_rng(7)
    first = _rows(rng, 15, 4, between=5.0, within=0.01)
    second = [Row(row.replication, row.value + 1.0) for row in first]
    estimate = estimates.bootstrap(np.hstack([_sums(second), _sums(first)]), estimates.contrast(1, -1), rng)
    assert estimate == pytest.approx((1.0, 1.0, 1.0))


def test_few_replications_have_no_interval_and_none_have_no_value() -> None:
    rows = [Row(i, value) for i in range(estimates.MIN_REPLICATIONS - 1) for value in (1.0, 3.0)]
    rng = np.random.default_rng(1)
    few = estimates.bootstrap(_sums(rows), estimates.ratio, rng), estimates.bootstrap_quantile(rows, _value, 0.95, rng)
    assert [estimate.value for estimate in few] == [2.0, 3.0]
    assert all(math.isnan(end) for estimate in few for end in estimate[1:])
    for sums in (np.zeros((0, 2)), np.zeros((5, 2))):
        assert all(map(math.isnan, estimates.bootstrap(sums, estimates.ratio, rng)))
    assert all(map(math.isnan, estimates.bootstrap_quantile([], _value, 0.95, rng)))
    assert all(map(math.isnan, estimates.wilson(0, 0)))


def test_bootstrap_of_a_mostly_undefined_statistic_has_no_interval() -> None:
    """Each mean has rows in only one of twenty replications, so that only 40 % of the resamples contain both."""
    first, second = np.zeros((20, 2)), np.zeros((20, 2))
    first[3] = second[11] = 1.0
    rng = np.random.default_rng(1)
    assert estimates.bootstrap(first, estimates.ratio, rng) == (1.0, 1.0, 1.0)
    both = estimates.bootstrap(np.hstack([first, second]), estimates.contrast(1, 1), rng)
    assert both.value == 2.0
    assert math.isnan(both.low)


def test_quantile_is_not_exceeded_by_its_share_of_the_rows_and_may_be_infinite() -> None:
    rng = np.random.default_rng(1)
    rows = [Row(i % 5, float(i)) for i in range(1, 101)]
    estimate = estimates.bootstrap_quantile(rows, _value, 0.95, rng)
    assert estimate.value == 95.0
    assert 85 <= estimate.low <= 95 <= estimate.high <= 100
    rows = [Row(i % 5, math.inf if i % 10 == 0 else 100.0) for i in range(100)]
    assert estimates.bootstrap_quantile(rows, _value, 0.95, rng).value == math.inf
    assert estimates.bootstrap_quantile(rows, _value, 0.5, rng) == (100.0, 100.0, 100.0)


def test_percentile_rank_counts_experiments_below_the_value() -> None:
    experiments = [float(i) for i in range(1, 20)]
    ranks = {10.0: (50.0, 1.0), 2.0: (100 * 1.5 / 19, 2 * 3 / 20), 25.0: (100.0, 2 / 20)}
    for value, rank in ranks.items():
        assert estimates.percentile_rank(value, experiments) == pytest.approx(rank)
    for few in ([], [3.0]):
        assert all(map(math.isnan, estimates.percentile_rank(3.0, few)))


def test_wilson_equals_a_published_example() -> None:
    """Newcombe (1998): 81 of 263."""
    assert estimates.wilson(81, 263) == pytest.approx((0.3080, 0.2553, 0.3662), abs=5e-5)
    assert estimates.wilson(0, 10) == pytest.approx((0.0, 0.0, 0.2775), abs=5e-5)
