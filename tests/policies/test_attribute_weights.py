"""Weights learned from experience: which attribute matters is found out, by the error that counts."""

import itertools
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from khepera_forage.policies import NearestNeighbourImitator, WeightedImitator, distance
from khepera_forage.task.states import StateVector

Data = tuple[NDArray[np.int64], NDArray[np.int64]]


def misleading(seed: int, count: int = 200) -> Data:
    """Food distance alone decides what is heard; the home distance is noise, four times as loud."""
    rng = np.random.default_rng(seed)
    food = rng.integers(0, 30, count)
    rows = np.column_stack(
        [np.zeros(count), rng.integers(0, 120, count), np.zeros(count), np.full(count, 215), food]
    )
    return rows.astype(np.int64), np.where(food <= 15, 2, 0)


def left_out(data: Data, weights: tuple[int, ...], groups: NDArray[np.int64]) -> float:
    """The error once more, one vector at a time: the share of the vote of all others that goes elsewhere."""
    wrong = []
    for row, heard, group in zip(*data, groups, strict=True):
        others = groups != group
        if others.any():
            rest = WeightedImitator(weights=weights).fit(data[0][others], data[1][others])
            levels = dict(zip(rest.classes_.tolist(), rest.predict_proba([row])[0], strict=True))
            wrong.append(1 - levels.get(int(heard), 0.0))
    return float(np.mean(wrong))


def test_what_matters_is_weighted_above_what_does_not() -> None:
    plain = NearestNeighbourImitator().fit(*misleading(0))
    learned = WeightedImitator(random_state=0).fit(*misleading(0))
    assert learned.weights_[4] > learned.weights_[1]
    rows, said = misleading(1)
    assert (learned.predict(rows) == said).mean() > (plain.predict(rows) == said).mean() + 0.03
    assert learned.error_ < learned.plain_error_


def test_the_error_is_that_of_leaving_out() -> None:
    data = misleading(2, 40)
    for groups in (np.arange(40), np.arange(40) // 8):
        learned = WeightedImitator(choices=(0, 1, 4), random_state=0).fit(*data, groups=groups)
        assert learned.plain_error_ == pytest.approx(left_out(data, (1,) * 5, groups))
        assert learned.error_ == pytest.approx(left_out(data, learned.weights_, groups))
        for column, choice in itertools.product(range(5), (0, 1, 4)):  # no single change betters it
            tried = (*learned.weights_[:column], choice, *learned.weights_[column + 1 :])
            if any(tried):
                assert left_out(data, tried, groups) >= learned.error_ - 1e-9


def test_equal_weights_are_the_imitator() -> None:
    rng = np.random.default_rng(3)
    rows = np.column_stack([rng.integers(0, high, 200) for high in (2, 9, 4, 3, 9)]) + np.array(
        [0, 0, 0, 215, 0]
    )
    heard = rng.integers(0, 10, 200)
    same = WeightedImitator(weights=(3,) * 5).fit(rows, heard)
    np.testing.assert_array_equal(
        same.predict_proba(rows + 1), NearestNeighbourImitator().fit(rows, heard).predict_proba(rows + 1)
    )
    assert not hasattr(same, "error_")


def test_weights_weigh() -> None:
    rows = [StateVector(0, 50, 0, 215, 20), StateVector(0, 60, 0, 215, 17)]
    query = StateVector(0, 60, 0, 215, 20)
    assert distance(rows[1], query, 138) < distance(rows[0], query, 138)
    assert WeightedImitator(weights=(1, 1, 1, 1, 1)).fit(rows, [0, 1]).predict([query]) == [1]
    assert WeightedImitator(weights=(1, 1, 1, 1, 4)).fit(rows, [0, 1]).predict([query]) == [0]
    assert WeightedImitator(weights=(1, 0, 1, 1, 1)).fit(rows, [0, 1]).predict([query]) == [0]


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ({"weights": (1, 2)}, r"weights are \(1, 2\); allowed: 5 whole numbers, not all 0"),
        ({"weights": (0,) * 5}, r"weights are \(0, 0, 0, 0, 0\); allowed"),
        ({"weights": (1, -1, 1, 1, 1)}, "weights are .*; allowed: whole numbers, at least 0"),
        ({"choices": (0.5, 1)}, "choices are .*; allowed: whole numbers, at least 0"),
        ({"diagonal": 0}, "diagonal is 0; allowed"),
    ],
)
def test_parameters_out_of_range(parameters: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        WeightedImitator(**parameters).fit(*misleading(0))


def test_a_group_for_each_vector() -> None:
    with pytest.raises(ValueError, match=r"groups have shape \(3,\); allowed: \(200,\)"):
        WeightedImitator().fit(*misleading(0), groups=[1, 2, 3])


def test_a_single_episode_has_nobody_to_vote_on_it() -> None:
    learned = WeightedImitator().fit(*misleading(0), groups=np.zeros(200))
    assert learned.weights_ == (1,) * 5
