"""The search for the best single set: distance, children within the prior, natural values."""

import dataclasses

import numpy as np
import pytest

from khepera_forage import Decisions
from khepera_forage.sim.arenas.thesis import THESIS_ARENAS
from khepera_forage.thesis.inference.evolution import child, natural, natural_step, simpler_values
from khepera_forage.thesis.inference.individual_recalls import of_thesis, p_value
from khepera_forage.thesis.inference.moments import Moments, means_of
from khepera_forage.thesis.inference.prior import PRIOR, Range, Shares, possible_decisions
from khepera_forage.thesis.inference.summary import FITTED, NAMES, SLOPES, thesis_statistics

pytest.importorskip("numba")
WIDTH = len(NAMES) + len(SLOPES)
NAMED = np.array([name in FITTED for name in (*NAMES, *SLOPES)])


@pytest.fixture(scope="module")
def statistics() -> np.ndarray:
    rng = np.random.default_rng(0)
    means = np.nan_to_num(thesis_statistics()) + rng.normal(size=(30, 1, len(NAMED)))
    return np.asarray(means + rng.normal(size=(30, 20, len(NAMED))), dtype=np.float32)


def test_surprise_is_in_the_spread_of_experiments(statistics: np.ndarray) -> None:
    """Here all statistics have a standard deviation of 1, are independent, 25 are looked at."""
    moments = Moments(statistics, np.ones(len(statistics)))
    assert moments.spread == pytest.approx(np.ones(25), abs=0.1)
    thesis = np.nan_to_num(thesis_statistics())
    off = np.random.default_rng(1).normal(size=(400, len(NAMED)))
    off -= off.mean(axis=0)
    assert moments.surprise(thesis + off) == pytest.approx(0.0, abs=1e-9)
    assert moments.surprise(thesis + 2 + off) == pytest.approx(4 * 23, rel=0.25)
    assert moments.surprise(thesis + 2 + 4 * off) == pytest.approx(4 * 23 / 16, rel=0.25), (
        "in the set's own spread"
    )
    own = [moments.surprise(thesis + row + off) for row in np.random.default_rng(2).normal(size=(300, WIDTH))]
    assert np.mean(own) == pytest.approx(23, rel=0.1)


def test_misfit_is_that_of_the_means_unless_the_thesis_is_a_surprise(statistics: np.ndarray) -> None:
    moments = Moments(statistics, np.ones(len(statistics)))
    thesis = np.nan_to_num(thesis_statistics())
    off = np.random.default_rng(1).normal(size=(400, len(NAMED)))
    off -= off.mean(axis=0)
    food = np.isin(NAMES + SLOPES, "corridor 3 food")
    slope = np.isin(NAMES + SLOPES, "corridor slope of score")
    spread = np.isin(NAMES + SLOPES, "corridor 3 spread")
    assert moments.misfit(thesis + off) == pytest.approx(0.0, abs=1e-9)
    assert moments.misfit(thesis + 2 * food + off) == pytest.approx(4, rel=0.2)
    assert moments.misfit(thesis + 2 * slope + off) == pytest.approx(4, rel=0.2), "a slope, the same means"
    assert moments.misfit(thesis + 2 * spread + off) == pytest.approx(0.0, abs=1e-9), "possible, and no mean"
    assert moments.misfit(thesis + 9 * spread + off) == pytest.approx(81 - 23, rel=0.3)


def test_sets_without_weight_do_not_count(statistics: np.ndarray) -> None:
    weights = np.r_[np.full(15, 1 / 15), np.zeros(15)]
    other = statistics.copy()
    other[15:] *= 9
    assert np.array_equal(Moments(other, weights).spread, Moments(statistics, weights).spread)


def test_misfit_does_not_look_at_the_rectangle(statistics: np.ndarray) -> None:
    own = statistics[3].astype(np.float64)
    moments = Moments(statistics, np.ones(len(statistics)))
    assert moments.misfit(np.where(NAMED, own, 99.0)) == moments.misfit(own)


def test_sets_without_failures_or_successes_do_not_fit(statistics: np.ndarray) -> None:
    own = statistics[3].astype(np.float64)
    own[:15, NAMES.index("corridor 3 right_failed")] = np.nan
    assert Moments(statistics, np.ones(len(statistics))).misfit(own) == np.inf


def test_children_stay_in_the_prior_and_mix_their_parents() -> None:
    rng = np.random.default_rng(5)
    parents = [natural(PRIOR.draw(rng).decisions, PRIOR) for _ in range(3)]
    children = [child(PRIOR, parents, rng) for _ in range(30)]
    inherited = 0
    for one in children:
        for name, part in PRIOR.decisions.items():
            value = getattr(one, name)
            if isinstance(part, Range):
                assert part.least <= value <= part.most
            else:
                assert value in part.of
            inherited += value in [getattr(parent, name) for parent in parents]
    assert inherited / (30 * len(PRIOR.decisions)) == pytest.approx(0.85, abs=0.07)
    assert child(PRIOR, parents, np.random.default_rng(1)) == child(PRIOR, parents, np.random.default_rng(1))


def test_rounded_sets_have_natural_values_in_the_prior() -> None:
    drawn = PRIOR.draw(np.random.default_rng(2)).decisions
    round_values = natural(drawn, PRIOR)
    assert round_values == natural(round_values, PRIOR)
    for field in dataclasses.fields(Decisions):
        value, part = getattr(round_values, field.name), PRIOR.decisions.get(field.name)
        if isinstance(part, Range):
            assert abs(value - getattr(drawn, field.name)) <= natural_step(part) / 2 + 1e-9
            assert len(f"{value:g}") <= 5, field.name
            assert part.least <= value <= part.most
        else:
            assert value == getattr(drawn, field.name)


@pytest.mark.parametrize(("most", "step"), [(15.0, 1.0), (0.3, 0.02), (90.0, 5.0), (29.0, 1.0), (30.0, 2.0)])
def test_natural_steps(most: float, step: float) -> None:
    assert natural_step(Range(0.0, most, "-"), 15) == pytest.approx(step)


def test_simpler_values_begin_with_version_0_1_and_stay_in_the_prior() -> None:
    drawn = PRIOR.draw(np.random.default_rng(2)).decisions
    for name, part in PRIOR.decisions.items():
        values, old = simpler_values(drawn, name, PRIOR), getattr(Decisions.v0_1(), name)
        assert simpler_values(Decisions.v0_1(), name, PRIOR) == []
        assert getattr(drawn, name) not in values
        if isinstance(part, Range):
            assert all(part.least <= value <= part.most for value in values)
        elif getattr(drawn, name) != old:
            assert values == [old]
    assert simpler_values(Decisions(slow_speed=5.2), "slow_speed", PRIOR) == [8.0, 5.0]


def test_rules_between_decisions_are_checked() -> None:
    with pytest.raises(ValueError, match="slow_speed is 9"):
        possible_decisions({"slow_speed": 9.0, "search_speed": 6.0})
    with pytest.raises(ValueError, match="home_radius"):
        possible_decisions({"home_radius": 110.0, "home_to_wall": 60.0})
    assert possible_decisions({"rounds_after_training": 3.6}).rounds_after_training == 4
    assert isinstance(PRIOR.decisions["orienting"], Shares)


def test_individual_recalls_of_the_thesis() -> None:
    corridor, rectangle = map(of_thesis, THESIS_ARENAS)
    assert corridor.steps.max() == 500
    assert rectangle.steps.max() == 700
    assert 55 < corridor.steps.shape[1] <= 70
    assert corridor.score.max() < 100
    assert (corridor.right >= corridor.score).all()


def test_p_value_compares_whole_experiments() -> None:
    """Recalls of an experiment are alike here: as independent recalls, its own experiments would be rejected."""
    rng = np.random.default_rng(4)
    experiments = rng.normal(size=(200, 1)) + 0.1 * rng.normal(size=(200, 20))
    assert p_value(experiments[7] + 0.0, experiments) > 0.05
    assert p_value(np.full(20, 9.0), experiments) < 0.02


def test_means_leave_out_what_is_missing() -> None:
    own = np.array([[[1.0, np.nan], [3.0, np.nan]], [[np.nan, 2.0], [4.0, 6.0]]])
    assert np.array_equal(means_of(own), [[2.0, np.nan], [4.0, 4.0]], equal_nan=True)
