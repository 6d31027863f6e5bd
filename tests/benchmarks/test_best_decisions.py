"""`benchmarks/best_decisions.py`: sets evolve from those of `khepera-forage infer`."""

from pathlib import Path

import numpy as np
import pytest
from best_decisions import arguments, evolved

from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import quick_here, read, refused

pytest.importorskip("numba")


@pytest.fixture(scope="module")
def out(quick_run: QuickRun, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("best")
    quick_here("best_decisions", folder, "--start", str(quick_run("decisions")))
    return folder


def test_generations_and_finalists_are_reported(out: Path) -> None:
    rows = read(out / "table_generations.csv")
    assert [row["generation"] for row in rows] == ["0", "1"]
    assert float(rows[1]["best misfit"]) <= float(rows[0]["best misfit"]), "the best live on"
    assert 1 <= len(read(out / "table_finalists.csv")) <= 4
    for row in read(out / "table_trials.csv"):
        assert row["kept"] == "no" or row["outcome"] == "admissible"
    assert "```python\nDecisions(" in (out / "best_decisions.md").read_text()
    assert {row["use"] for row in read(out / "table_means.csv")} == {"fitted", "test"}


def test_killed_run_continues_with_the_same_sets(out: Path, quick_run: QuickRun, tmp_path: Path) -> None:
    before = (out / "sets_00001.npz").read_bytes()
    (out / "sets_00001.npz").unlink()
    first = (out / "sets_00000.npz").stat().st_mtime_ns
    start = str(quick_run("decisions"))
    evolved(arguments(["--quick", "--seed", "1", "--out", str(out), "--start", start, "--jobs", "1"]))
    assert (out / "sets_00000.npz").stat().st_mtime_ns == first
    (tmp_path / "before.npz").write_bytes(before)
    with np.load(tmp_path / "before.npz") as old, np.load(out / "sets_00001.npz") as new:
        assert old["laboratories"].tolist() == new["laboratories"].tolist()
        assert np.array_equal(old["statistics"], new["statistics"], equal_nan=True)


def test_folder_without_sets_is_refused(tmp_path: Path) -> None:
    told = refused("best_decisions", "--out", str(tmp_path / "out"), "--start", str(tmp_path / "none"))
    assert "has no sets_00000.npz; allowed: a folder of simulated sets" in told
