"""Measures of the inference's pages, on data whose answer is known."""

from dataclasses import replace

import numpy as np
import pytest

from khepera_forage.thesis.inference import page
from khepera_forage.thesis.inference.page import explained
from khepera_forage.thesis.inference.posterior import Parameter, Posterior, PriorCheck
from khepera_forage.thesis.inference.summary import ALL, FITTED, NAMES, SLOPES, thesis_statistics

SETS = 2000
WIDTH = len(NAMES) + len(SLOPES)


@pytest.fixture(scope="module")
def posterior() -> Posterior:
    rng = np.random.default_rng(0)
    parameters = (
        Parameter("strong", (), rng.uniform(size=SETS)),
        Parameter("alternative", ("a", "b"), rng.integers(2, size=SETS).astype(float)),
        Parameter("nothing", (), rng.uniform(size=SETS)),
    )
    weights = rng.uniform(size=SETS) * (rng.random(SETS) < 0.9)
    return Posterior(parameters, weights / weights.sum(), (), 0, PriorCheck([], np.zeros(0), 1.0, 1))


def test_knowing_a_decision_explains_what_depends_on_it(posterior: Posterior) -> None:
    strong, alternative, _ = (parameter.values for parameter in posterior.parameters)
    statistics = np.ones((SETS, 1, WIDTH), np.float32)
    statistics[:, 0, page.MEANS[0]] = strong
    statistics[:, 0, page.MEANS[1]] = 2 * alternative
    found = explained(posterior, statistics, np.random.default_rng(1))
    by_name = {one.name: one for one in found}
    assert by_name["strong"].share == pytest.approx(0.5 * 0.96, abs=0.02), "five classes explain 24/25 of a number"
    assert by_name["alternative"].share == pytest.approx(0.5, abs=0.02)
    assert by_name["nothing"].share < by_name["nothing"].chance + 0.005 < 0.02
    assert found[-1].name == "nothing"


def test_weights_decide_what_is_explained(posterior: Posterior) -> None:
    strong, alternative, _ = (parameter.values for parameter in posterior.parameters)
    statistics = np.where(alternative == 1, strong, 0.3)[:, None, None] * np.ones((1, 1, WIDTH), np.float32)
    for value, least, most in ((1, 0.9, 1.0), (0, 0.0, 0.0)):
        weights = (alternative == value) / (alternative == value).sum()
        found = explained(replace(posterior, weights=weights), statistics.astype(np.float32), np.random.default_rng(0))
        (own,) = (one.share for one in found if one.name == "strong")
        assert least <= own <= most


def test_few_sets_explain_nothing(posterior: Posterior) -> None:
    few = np.zeros(SETS)
    few[:3] = 1 / 3
    found = explained(replace(posterior, weights=few), np.zeros((SETS, 1, WIDTH), np.float32), np.random.default_rng(0))
    assert np.isnan([one.share for one in found]).all()


def test_a_set_predicts_what_lies_among_its_own_experiments() -> None:
    rng = np.random.default_rng(3)
    thesis = np.nan_to_num(thesis_statistics())
    statistics = np.stack([thesis + rng.normal(size=(20, WIDTH)), thesis + 9 + rng.normal(size=(20, WIDTH))])
    statistics[0, :15, NAMES.index("rectangle 5 right_failed")] = np.nan
    found = page.predicted(statistics)
    tested = [k for k in np.flatnonzero(np.isfinite(thesis_statistics())).tolist() if ALL[k] not in FITTED]
    assert len(tested) == 19
    missing = tested.index(NAMES.index("rectangle 5 right_failed"))
    assert not found[0, tested][missing], "most experiments have no such value"
    assert found[0, tested].sum() >= 15
    assert not found[1].any()
    alike = thesis + rng.normal(size=(2000, 1, WIDTH)) + rng.normal(size=(2000, 5, WIDTH))
    assert page.predicted(alike)[:, tested].mean() == pytest.approx(0.95, abs=0.01), "also of few experiments"
