"""Posteriors by forests and their calibration, on simulators whose true posterior is known."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy import stats

from khepera_forage import Noise
from khepera_forage.thesis.inference.posterior import (
    UNBOUNDED,
    Coverage,
    Parameter,
    Told,
    calibrate,
    central,
    effective_number,
    forest_weights,
    parameters_of,
    prior_check,
    quantiles,
    rank,
    shortest,
)
from khepera_forage.thesis.inference.prior import LabModel, Prior, PriorRange, Shares
from tests.version_0_1 import V0_1

pytest.importorskip("numba")
SETS, EXPERIMENTS, SPREAD = 3000, 4, 0.5


@pytest.fixture(scope="module")
def simulator() -> tuple[list[Parameter], Any]:
    """A number measured with errors of 0.5, an alternative that moves another statistic, and one that does nothing."""
    rng = np.random.default_rng(1)
    number = rng.normal(size=SETS)
    alternative = rng.integers(3, size=SETS).astype(float)
    nothing = rng.uniform(size=SETS)
    errors = rng.normal(size=(SETS, EXPERIMENTS, 3))
    statistics = errors * [SPREAD, SPREAD, 1.0]
    statistics[..., 0] += number[:, None]
    statistics[..., 1] += alternative[:, None] == 2
    statistics[rng.random((SETS, EXPERIMENTS)) < 0.05, 2] = np.nan
    parameters = [
        Parameter("number", (), number),
        Parameter("alternative", ("a", "b", "c"), alternative),
        Parameter("nothing", (), nothing),
    ]
    return parameters, statistics


def weights_of(parameters: list[Parameter], statistics: Any, queries: Any) -> Any:
    targets = np.hstack([parameter.targets for parameter in parameters])
    return forest_weights(statistics, targets, queries, 0, 100)


def test_right_posteriors_are_calibrated_and_wrong_ones_are_not(simulator: tuple[list[Parameter], Any]) -> None:
    """Wrong: of other experiments, shifted, and too sure of themselves."""
    parameters, statistics = simulator
    learned, held_out = np.split(np.arange(SETS), [SETS - 500])
    own, true = ([parameter.of(sets) for parameter in parameters] for sets in (learned, held_out))
    weights = weights_of(own, statistics[learned], statistics[held_out, 0])
    guesses = np.full(weights.shape, 1 / len(learned))

    def calibrated(parameter: Parameter, weights: Any, true: Parameter) -> Coverage:
        return calibrate(parameter, weights, true, np.random.default_rng(0), guesses)

    right = [calibrated(parameter, weights, values) for parameter, values in zip(own, true, strict=True)]
    for found in right:
        assert stats.kstest(found.ranks, "uniform").pvalue > 0.001, found.name
        assert found.half.low - 5 < 50 < found.half.high + 5
        assert found.most.low - 3 < 90 < found.most.high + 3
    assert [found.told for found in right] == [Told.SOMETHING, Told.SOMETHING, Told.NOTHING]
    number = own[0]
    swapped = calibrated(number, np.random.default_rng(0).permutation(weights), true[0])
    assert swapped.error.value > 1
    shifted = calibrated(replace(number, values=number.values + 0.5), weights, true[0])
    assert stats.kstest(shifted.ranks, "uniform").pvalue < 1e-6
    sure = np.exp(-0.5 * ((number.values - (weights @ number.values)[:, None]) / 0.1) ** 2)
    sure /= sure.sum(axis=1, keepdims=True)
    assert calibrated(number, sure, true[0]).most.high < 50


def test_error_of_a_number_is_the_ranked_probability_score() -> None:
    """Of a posterior that is surely 2 where 5 is true: 3; of the guess 2 or 4: mean 2, less half of 1."""
    learned, true = Parameter("n", (), np.array([4.0, 2.0])), Parameter("n", (), np.full(6, 5.0))
    posteriors, guesses = np.array([[0.0, 1.0]] * 6), np.full((6, 2), 0.5)
    found = calibrate(learned, posteriors, true, np.random.default_rng(0), guesses)
    assert found.error.value == pytest.approx(3 / (2 - 0.5))


def test_parameters_are_numbers_in_the_order_of_the_prior() -> None:
    ways = ("lowered over food", "lowered before food")
    prior = Prior(
        {"next_to_food": PriorRange(12, 24, "-"), "orienting": Shares(dict.fromkeys(ways, 0.5), "-")},
        {"placement_error": PriorRange(0, 5, "-")},
    )
    laboratories = [
        LabModel(replace(V0_1, next_to_food=17), Noise.none()),
        LabModel(replace(V0_1, orienting="lowered over food"), Noise(placement_error=3.0)),
    ]
    found = parameters_of(prior, laboratories)
    assert [(p.name, p.alternatives, p.values.tolist(), p.ends) for p in found] == [
        ("next_to_food", (), [17.0, 20.0], (12, 24)),
        ("orienting", ways, [1.0, 0.0], UNBOUNDED),
        ("placement_error", (), [0.0, 3.0], (0, 5)),
    ]
    assert Parameter("same", (), np.ones(3)).targets.tolist() == [[1.0]] * 3


def test_experiment_unlike_all_simulated_ones_is_told() -> None:
    """By its values, or by an unlikely combination of usual values."""
    rng = np.random.default_rng(0)
    statistics = rng.normal(size=(300, 4, 5)).astype(np.float32)
    statistics[:20, :, 1] = np.nan
    usual = prior_check(statistics, np.array([0.5, -0.5, 0.0, 1.0, np.nan]), rng)
    assert usual.warning == ""
    assert usual.tail > 0.2
    assert usual.ranks[:4] == pytest.approx([69, 31, 50, 84], abs=4)
    far = prior_check(statistics, np.array([3.0, -3.0, 3.0, 0.0, 0.0]), rng)
    assert far.outside == 3
    assert far.tail < 0.02
    assert "3 of 5 statistics" in far.warning
    alike = (statistics[..., :1] + [0, 0.1] * rng.normal(size=(300, 4, 2))).astype(np.float32)
    combined = prior_check(alike, np.array([1.5, -1.5]), rng)
    assert combined.outside == 0
    assert combined.tail < 0.02
    assert combined.warning


def test_shortest_interval_with_hardly_any_weight_beyond_contains_the_end_of_the_range() -> None:
    """Of continuous draws none is exactly at an end."""
    values = np.random.default_rng(0).uniform(size=2000)
    assert 0 < values.min() < values.max() < 1
    low, high = shortest(values, np.exp(-5 * values), 0.9, (0, 1))
    assert low == 0
    assert high == pytest.approx(0.45, abs=0.03)
    low, high = shortest(values, np.exp(5 * values), 0.9, (0, 1))
    assert low == pytest.approx(0.55, abs=0.03)
    assert high == 1
    low, high = shortest(values, np.exp(-50 * (values - 0.5) ** 2), 0.9, (0, 1))
    assert (low, high) == pytest.approx((0.335, 0.665), abs=0.03)
    tail = np.append(values, 1e-6), np.append(np.exp(-5 * values), 1e-6)
    assert shortest(*tail, 0.9, (0, 1))[0] == 0, "a draw of hardly any weight is no bound"
    assert shortest(np.array([2.0, 1.0]), np.array([1.0, 0.0]), 0.5, (0, 3)) == (0, 3), "nor is one draw alone"


def test_weighted_quantiles_and_ranks() -> None:
    values = np.array([3.0, 1.0, 2.0])
    weights = np.array([1.0, 1.0, 2.0])
    assert quantiles(values, weights, (0.0, 0.25, 0.5, 0.75, 1.0)) == [1, 1, 2, 2, 3]
    assert rank(values, weights, 2.0) == 50.0
    assert rank(values, weights, 9.0) == 100.0
    assert np.isnan(rank(np.array([np.nan]), np.ones(1), 1.0))
    assert np.isnan(central(np.array([np.nan, 1.0]), np.array([1.0, 0.0]))).all()
    assert effective_number(np.array([1.0, 1.0, 0.0])) == 2.0
