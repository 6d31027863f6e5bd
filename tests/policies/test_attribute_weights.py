"""Attribute weights learned from experience."""

import itertools

import numpy as np
import pytest
from numpy.typing import NDArray

from khepera_forage.policies import NearestNeighbourImitator, WeightedImitator

Data = tuple[NDArray[np.int64], NDArray[np.int64]]


def misleading(seed: int, count: int = 200) -> Data:
    """Only the food distance decides the behaviour; the home distance is noise with four times the range."""
    rng = np.random.default_rng(seed)
    food = rng.integers(0, 30, count)
    rows = np.column_stack(
        [np.zeros(count), rng.integers(0, 120, count), np.zeros(count), np.full(count, 215), food]
    )
    return rows.astype(np.int64), np.where(food <= 15, 2, 0)


def left_out(data: Data, weights: tuple[int, ...], groups: NDArray[np.int64]) -> float:
    """The leave-one-out error, one vector at a time: the share of votes for another behaviour."""
    wrong = []
    for row, heard, group in zip(*data, groups, strict=True):
        others = groups != group
        if others.any():
            rest = WeightedImitator(weights=weights).fit(data[0][others], data[1][others])
            levels = dict(zip(rest.classes_.tolist(), rest.predict_proba([row])[0], strict=True))
            wrong.append(1 - levels.get(int(heard), 0.0))
    return float(np.mean(wrong))


def test_significant_attribute_gets_the_larger_weight() -> None:
    plain = NearestNeighbourImitator(arithmetic="exact").fit(*misleading(0))
    learned = WeightedImitator(random_state=0).fit(*misleading(0))
    assert learned.weights_[4] > learned.weights_[1]
    rows, expected = misleading(1)
    assert (learned.predict(rows) == expected).mean() > (plain.predict(rows) == expected).mean() + 0.03
    assert learned.error_ < learned.plain_error_


def test_error_equals_leave_one_out_error() -> None:
    data = misleading(2, 40)
    for groups in (np.arange(40), np.arange(40) // 8):
        learned = WeightedImitator(choices=(0, 1, 4), random_state=0).fit(*data, groups=groups)
        assert learned.plain_error_ == pytest.approx(left_out(data, (1,) * 5, groups))
        assert learned.error_ == pytest.approx(left_out(data, learned.weights_, groups))
        for column, choice in itertools.product(range(5), (0, 1, 4)):  # no single change improves it
            tried = (*learned.weights_[:column], choice, *learned.weights_[column + 1 :])
            if any(tried):
                assert left_out(data, tried, groups) >= learned.error_ - 1e-9


def test_equal_weights_equal_the_imitator() -> None:
    rng = np.random.default_rng(3)
    rows = np.column_stack([rng.integers(0, high, 200) for high in (2, 9, 4, 3, 9)]) + np.array(
        [0, 0, 0, 215, 0]
    )
    heard = rng.integers(0, 10, 200)
    same = WeightedImitator(weights=(3,) * 5).fit(rows, heard)
    np.testing.assert_array_equal(
        same.predict_proba(rows + 1),
        NearestNeighbourImitator(arithmetic="exact").fit(rows, heard).predict_proba(rows + 1),
    )
    assert not hasattr(same, "error_")
