"""`benchmarks/agreement.py`: both backends are compared, and an artificial difference is detected."""

from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from backend_agreement import samples, two_sample_tests

from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import read
from tests.benchmarks.test_scripts import SCRIPTS

pytestmark = pytest.mark.skipif(
    find_spec("numba") is None, reason="the compiled backend needs numba, the extra `fast`"
)

CONDITIONS = {(policy, arena) for policy in ("teacher", "imitator") for arena in ("corridor", "rectangle")}
EPISODES = 10


@pytest.fixture(scope="module")
def out(quick_run: QuickRun) -> Path:
    return quick_run("agreement", *SCRIPTS["agreement"].run)


def test_every_condition_and_measure_has_a_line(out: Path) -> None:
    for name in ("table_agreement.csv", "table_slow_wheels.csv"):
        rows = read(out / name)
        measures = {(r["policy"], r["arena"], r["measure"]) for r in rows}
        assert measures == {(*c, m) for c in CONDITIONS for m in ("score", "steps", "delivered")}
        assert len(rows) == len(measures)
        for row in rows:
            difference = float(row["compiled"]) - float(row["pymunk"])
            assert float(row["difference"]) == pytest.approx(difference, abs=2e-3)
            assert float(row["difference: low"]) <= float(row["difference"]) <= float(row["difference: high"])
            for p in ("p of means", "p of distributions"):
                assert 0 <= float(row[p]) <= 1
                if name == "table_agreement.csv":
                    corrected = float(row[p.replace("p of", "corrected:")])
                    assert float(row[p]) - 1e-6 <= corrected <= 1
    assert {(r["policy"], r["arena"]) for r in read(out / "table_power.csv")} == CONDITIONS


def test_the_table_is_that_of_pymunks_rows(out: Path) -> None:
    rows = read(out / "pymunk_recalls.csv")
    for policy, arena in CONDITIONS:
        own = [r for r in rows if (r["policy"], r["arena"]) == (policy, arena)]
        assert len(own) == EPISODES
        assert {r["imitator"] for r in own} == (
            {"-1"} if policy == "teacher" else set(map(str, range(EPISODES)))
        )
        (line,) = (
            r
            for r in read(out / "table_agreement.csv")
            if (r["policy"], r["arena"], r["measure"]) == (policy, arena, "steps")
        )
        assert float(line["pymunk"]) == pytest.approx(np.mean([int(r["steps"]) for r in own]), rel=1e-4)


def test_slow_wheels_are_detected_and_equal_ones_are_not() -> None:
    teacher = samples.Condition("teacher", "corridor")
    same = samples.compiled(1, teacher, 12_000, ())
    slow = samples.compiled(1, teacher, 12_000, (), samples.SLOW)
    found = two_sample_tests.power(teacher, same, slow, 6000, 20, np.random.default_rng(0))
    assert found.by_mean.value >= 80
    assert found.by_distribution.value >= 80
    assert found.false_by_mean.value <= 30
    assert found.false_by_distribution.value <= 30


def test_samples_without_variance_can_be_compared() -> None:
    always, never = np.full(20, 1.0), np.zeros(30)
    assert two_sample_tests.welch(always, always) == ((0, 0, 0), 1.0)
    assert two_sample_tests.welch(never, always) == ((1, 1, 1), 0.0)


def test_holm_correction_by_hand() -> None:
    assert two_sample_tests.holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert two_sample_tests.holm([0.6, 0.9]) == [1.0, 1.0]


def test_welch_agrees_with_scipy() -> None:
    from scipy import stats

    rng = np.random.default_rng(0)
    a, b = rng.normal(0, 1, 40), rng.normal(0.3, 3, 90)
    theirs = stats.ttest_ind(b, a, equal_var=False)
    difference, p = two_sample_tests.welch(a, b)
    assert p == pytest.approx(theirs.pvalue)
    assert difference[1:] == pytest.approx(tuple(theirs.confidence_interval(0.95)))
