"""`benchmarks/agreement.py`: both simulators are compared, and a planted difference is found."""

import sys
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.benchmarks.running import ROOT, help_of, is_picture, quick, read

pytestmark = pytest.mark.skipif(find_spec("numba") is None, reason="the batch needs numba, the extra `fast`")

CONDITIONS = {(policy, arena) for policy in ("teacher", "imitator") for arena in ("corridor", "rectangle")}
EPISODES = 10


@pytest.fixture(scope="module")
def out(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("run") / "agreement"
    printed = quick("agreement.py", folder, "--episodes", str(EPISODES), "--jobs", "2")
    (folder.parent / "printed").write_text(printed, encoding="utf-8")
    return folder


@pytest.fixture
def inside(monkeypatch: pytest.MonkeyPatch) -> tuple[Any, Any]:
    """The script's own modules: samples, comparing."""
    monkeypatch.setattr(sys, "path", [str(ROOT / "benchmarks"), *sys.path])
    from _agreement import comparing, samples

    return samples, comparing


def test_every_condition_and_measure_has_a_line(out: Path) -> None:
    for name in ("agreement.csv", "planted.csv"):
        rows = read(out / name)
        measures = {(r["policy"], r["arena"], r["measure"]) for r in rows}
        assert measures == {(*c, m) for c in CONDITIONS for m in ("score", "steps", "delivered")}
        assert len(rows) == len(measures)
        for row in rows:
            difference = float(row["batch"]) - float(row["pymunk"])
            assert float(row["difference"]) == pytest.approx(difference, abs=2e-3)
            assert float(row["difference: low"]) <= float(row["difference"]) <= float(row["difference: high"])
            for p in ("p of means", "p of shapes"):
                assert 0 <= float(row[p]) <= 1
                if name == "agreement.csv":
                    corrected = float(row[p.replace("p of", "corrected:")])
                    assert float(row[p]) - 1e-6 <= corrected <= 1
    assert {(r["policy"], r["arena"]) for r in read(out / "power.csv")} == CONDITIONS


def test_rows_of_pymunk_are_those_of_the_table(out: Path) -> None:
    rows = read(out / "pymunk_recalls.csv")
    for policy, arena in CONDITIONS:
        own = [r for r in rows if (r["policy"], r["arena"]) == (policy, arena)]
        assert len(own) == EPISODES
        assert {r["memory"] for r in own} == (
            {"-1"} if policy == "teacher" else set(map(str, range(EPISODES)))
        )
        (line,) = (
            r
            for r in read(out / "agreement.csv")
            if (r["policy"], r["arena"], r["measure"]) == (policy, arena, "steps")
        )
        assert float(line["pymunk"]) == pytest.approx(np.mean([int(r["steps"]) for r in own]), rel=1e-4)


def test_tables_are_printed_and_written_with_their_picture(out: Path) -> None:
    page = (out / "agreement.md").read_text(encoding="utf-8")
    printed = (out.parent / "printed").read_text(encoding="utf-8")
    for line in page.splitlines():
        if line.startswith("| "):
            assert line in printed
    assert is_picture(out / "agreement.png")


def test_slow_wheels_are_found_and_equal_ones_are_not(inside: tuple[Any, Any]) -> None:
    samples, comparing = inside
    teacher = samples.Condition("teacher", "corridor")
    same = samples.in_batch(1, teacher, 12_000, ())
    slow = samples.in_batch(1, teacher, 12_000, (), samples.SLOW)
    found = comparing.power(teacher, same, slow, 6000, 20, np.random.default_rng(0))
    assert found.by_mean.value >= 80
    assert found.by_shape.value >= 80
    assert found.false_by_mean.value <= 30
    assert found.false_by_shape.value <= 30


def test_tests_of_samples_that_do_not_vary(inside: tuple[Any, Any]) -> None:
    _, comparing = inside
    always, never = np.full(20, 1.0), np.zeros(30)
    assert comparing.welch(always, always) == ((0, 0, 0), 1.0)
    assert comparing.welch(never, always) == ((1, 1, 1), 0.0)


def test_holm_is_that_of_the_textbook(inside: tuple[Any, Any]) -> None:
    _, comparing = inside
    assert comparing.holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert comparing.holm([0.6, 0.9]) == [1.0, 1.0]


def test_welch_is_that_of_scipy(inside: tuple[Any, Any]) -> None:
    from scipy import stats

    _, comparing = inside
    rng = np.random.default_rng(0)
    a, b = rng.normal(0, 1, 40), rng.normal(0.3, 3, 90)
    theirs = stats.ttest_ind(b, a, equal_var=False)
    difference, p = comparing.welch(a, b)
    assert p == pytest.approx(theirs.pvalue)
    assert difference[1:] == pytest.approx(tuple(theirs.confidence_interval(0.95)))


def test_help_names_every_argument() -> None:
    told = help_of("agreement.py")
    for argument in ("--seed", "--out", "--quick", "--episodes", "--jobs", "results/agreement"):
        assert argument in told
