"""Measures of the inference's pages, on data whose answer is known."""

import warnings

import numpy as np
import pytest

from khepera_forage.thesis.inference import page
from khepera_forage.thesis.inference.page import Predictions, explained, first_order, outcome, outcomes
from khepera_forage.thesis.inference.posterior import Parameter
from khepera_forage.thesis.inference.summary import NAMES, SLOPES, thesis_statistics

pytest.importorskip("SALib")
SETS = 2000
WIDTH = len(NAMES) + len(SLOPES)


@pytest.fixture(scope="module")
def parameters() -> list[Parameter]:
    rng = np.random.default_rng(0)
    return [
        Parameter("strong", (), rng.uniform(size=SETS)),
        Parameter("weak", (), rng.uniform(size=SETS)),
        Parameter("reading", ("a", "b"), rng.integers(2, size=SETS).astype(float)),
        Parameter("nothing", (), rng.uniform(size=SETS)),
    ]


def test_influence_is_the_share_of_the_variance(parameters: list[Parameter]) -> None:
    """Variances: 9/12 and 1/12 of uniform numbers, 1/4 of a coin: together 13/12."""
    strong, weak, reading, _ = (parameter.values for parameter in parameters)
    state, filters = str(np.random.get_state()), list(warnings.filters)  # noqa: NPY002
    found = first_order(parameters, 3 * strong + weak + reading, seed=0)
    assert [one.value for one in found] == pytest.approx([9 / 13, 1 / 13, 3 / 13, 0.0], abs=0.06)
    assert all(one.low <= one.value <= one.high for one in found)
    assert str(np.random.get_state()) == state  # noqa: NPY002
    assert warnings.filters == filters
    assert first_order(parameters, strong, seed=0) == first_order(parameters, strong, seed=0)


def test_knowing_a_decision_explains_what_depends_on_it(parameters: list[Parameter]) -> None:
    rng = np.random.default_rng(1)
    strong, _, reading, _ = (parameter.values for parameter in parameters)
    means = np.stack([strong, 2 * reading, np.ones(SETS)], axis=1)
    weights = rng.uniform(size=SETS) * (rng.random(SETS) < 0.9)
    found = {p.name: explained(p, weights, means, rng) for p in parameters}
    assert found["strong"].share == pytest.approx(0.5 * 0.96, abs=0.02), (
        "five classes explain 24/25 of a number"
    )
    assert found["reading"].share == pytest.approx(0.5, abs=0.02)
    assert found["nothing"].share < found["nothing"].chance + 0.005 < 0.02


def test_weights_decide_what_is_explained(parameters: list[Parameter]) -> None:
    strong, _, reading, _ = (parameter.values for parameter in parameters)
    means = np.where(reading == 1, strong, 0.3)[:, None]
    rng = np.random.default_rng(0)
    assert explained(parameters[0], (reading == 1).astype(float), means, rng).share > 0.9
    assert explained(parameters[0], (reading == 0).astype(float), means, rng).share == 0, "nothing varies"


def test_outcomes_are_means_of_experiments() -> None:
    statistics = np.arange(2 * 3 * WIDTH, dtype=np.float32).reshape(2, 3, WIDTH)
    assert outcomes(statistics).shape == (2, 14)
    score = [k for k, name in enumerate(NAMES) if name.startswith("corridor") and name.endswith(" score")]
    assert outcome(statistics, "corridor", "score")[1] == pytest.approx(statistics[1][:, score].mean())


def test_a_set_predicts_what_lies_among_its_own_experiments() -> None:
    rng = np.random.default_rng(3)
    thesis = np.nan_to_num(thesis_statistics())
    statistics = np.stack([thesis + rng.normal(size=(20, WIDTH)), thesis + 9 + rng.normal(size=(20, WIDTH))])
    statistics[0, :15, NAMES.index("rectangle 5 right_failed")] = np.nan
    found = page.predicted(statistics)
    tested = page.tested_columns()
    assert len(tested) == 19
    missing = tested.index(NAMES.index("rectangle 5 right_failed"))
    assert not found[0, tested][missing], "most experiments have no such value"
    assert found[0, tested].sum() >= 15
    assert not found[1].any()


def test_predictions_weigh_experiments() -> None:
    experiments = np.full((3, WIDTH), np.nan)
    experiments[:, 0] = [10.0, 20.0, 30.0]
    experiments[:2, 1] = [1.0, 3.0]
    predictions = Predictions("p", experiments, np.array([0.0, 1.0, 3.0]))
    assert predictions.interval(0) == (30.0, 20.0, 30.0)
    assert predictions.means([0, 1]).tolist() == [27.5, 3.0]
    assert np.isnan(predictions.interval(2)).all()
