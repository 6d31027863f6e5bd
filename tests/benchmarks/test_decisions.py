"""`benchmarks/decisions.py`: sets from the prior, whether they are admissible, and what they predict."""

from pathlib import Path

import numpy as np
import pytest

from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import quick, read, refused

pytest.importorskip("numba")


@pytest.fixture(scope="module")
def out(quick_run: QuickRun) -> Path:
    return quick_run("decisions")


def test_as_many_sets_are_admissible_as_were_wanted(out: Path) -> None:
    counts = {row["outcome"]: int(row["sets"]) for row in read(out / "table_admissible.csv")}
    assert counts["admissible"] == 3
    with np.load(out / "sets_00000.npz") as file:
        assert len(file["numbers"]) == 4
        assert file["statistics"].shape[:2] == (4, 2)


def test_every_part_of_the_prior_stands_on_the_page_with_its_source(out: Path) -> None:
    rows = read(out / "table_prior.csv")
    assert {"next_to_food", "orienting", "placement_error"} <= {row["decision or noise"] for row in rows}
    assert all(row["source"] for row in rows)


def test_predictions_stand_beside_the_thesis(out: Path) -> None:
    rows = {row["statistic"]: row for row in read(out / "table_predictions.csv")}
    assert float(rows["corridor 1 food"]["thesis"]) == 0.4
    assert rows["corridor 1 food"]["use"] == "fitted"
    assert rows["rectangle 10 score"]["use"] == "test"
    for row in rows.values():
        assert 0 <= float(row["percentile"]) <= 100


def test_more_sets_continue_the_run_and_other_experiments_are_refused(tmp_path: Path, out: Path) -> None:
    folder = tmp_path / "out"
    quick("decisions", folder, "--sets", "1", "--jobs", "1")
    first = (folder / "sets_00000.npz").stat().st_mtime_ns
    with np.load(folder / "sets_00000.npz") as mine, np.load(out / "sets_00000.npz") as theirs:
        for name in mine.files:
            assert np.array_equal(mine[name], theirs[name], equal_nan=mine[name].dtype.kind == "f"), name
    quick("decisions", folder, "--sets", "2", "--jobs", "1")
    assert (folder / "sets_00000.npz").stat().st_mtime_ns == first
    told = refused("decisions", "--out", str(folder), "--experiments", "1")
    assert "experiments 2; allowed: the same as in this run" in told
