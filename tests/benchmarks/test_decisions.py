"""`khepera-forage infer`: sets from the prior, and the page of what is inferred from them."""

from pathlib import Path

import numpy as np
import pytest

from khepera_forage.study import Count, parse
from khepera_forage.thesis.inference.claims import CLAIMS
from khepera_forage.thesis.inference.prior import PRIOR
from khepera_forage.thesis.inference.simulate import Drawn, draw
from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import read, refused

pytest.importorskip("numba")
pytest.importorskip("SALib")


@pytest.fixture(scope="module")
def out(quick_run: QuickRun) -> Path:
    return quick_run("decisions")


def test_as_many_sets_are_admissible_as_were_wanted(out: Path) -> None:
    counts = {row["outcome"]: int(row["sets"]) for row in read(out / "table_admissible.csv")}
    assert counts["admissible"] == 3


def test_every_part_of_the_prior_stands_on_the_page_with_its_source(out: Path) -> None:
    rows = read(out / "table_prior.csv")
    assert {row["decision or noise"] for row in rows} == set(PRIOR.names)
    assert all(row["source"] for row in rows)


def test_every_decision_is_calibrated_and_has_a_posterior(out: Path) -> None:
    assert {row["decision or noise"] for row in read(out / "table_calibration.csv")} == set(PRIOR.names)
    numbers = {row["decision or noise"] for row in read(out / "table_posterior_numbers.csv")}
    readings = {row["decision"] for row in read(out / "table_posterior_readings.csv")}
    assert numbers | readings == set(PRIOR.names)
    shares = [
        float(row["posterior (%)"])
        for row in read(out / "table_posterior_readings.csv")
        if row["decision"] == "orienting"
    ]
    assert sum(shares) == pytest.approx(100, abs=0.01)


def test_influence_has_an_interval_and_a_line_of_chance(out: Path) -> None:
    rows = {row["decision or noise"]: row for row in read(out / "table_influence.csv")}
    assert set(rows) == {*PRIOR.names, "(a random number)"}
    row = rows["next_to_food"]
    assert (
        float(row["corridor score: low"])
        <= float(row["corridor score"])
        <= float(row["corridor score: high"])
    )


def test_cells_stand_beside_the_thesis(out: Path) -> None:
    rows = {row["statistic"]: row for row in read(out / "table_cells.csv")}
    assert float(rows["corridor 1 food"]["thesis"]) == 0.4
    assert rows["corridor 1 food"]["use"] == "fitted"
    assert rows["rectangle 10 score"]["use"] == "test"
    for row in rows.values():
        for name in ("version 0.1", "posterior"):
            rank = row[f"percentile ({name})"]
            assert rank == "" or 0 <= float(rank) <= 100
    fit = {row["measure"]: row for row in read(out / "table_fit.csv")}
    assert 0 <= float(fit["means of the thesis within the central 95 %, of 14"]["version 0.1"]) <= 14


def test_nothing_of_the_test_set_is_fitted(out: Path) -> None:
    rows = read(out / "table_test_set.csv")
    assert len(rows) == 19
    assert all(row["statistic"].startswith("rectangle") for row in rows)
    assert {row["predicted"] for row in rows} <= {"yes", "no"}


def test_every_claim_has_a_share_of_laboratories(out: Path) -> None:
    assert [row["claim"] for row in read(out / "table_claims.csv")] == [claim.name for claim in CLAIMS]


def test_three_questions_are_asked(out: Path) -> None:
    text = (out / "decisions.md").read_text()
    assert [line[:2] for line in text.splitlines() if line[:2] in ("1.", "2.", "3.", "4.")] == [
        "1.",
        "2.",
        "3.",
    ]


def drawn(folder: Path, sets: int, *options: str) -> Drawn:
    wanted = Count("sets", 10, sets, "admissible sets", adds_units=True)
    experiments = Count("experiments", 20, 2, "experiments")
    given = parse(
        "decisions", "", wanted, experiments, given=["--quick", "--seed", "1", "--out", str(folder), *options]
    )
    return draw(given, given.sets, given.experiments)


def test_more_sets_continue_the_run_and_other_experiments_are_refused(tmp_path: Path) -> None:
    few = drawn(tmp_path, 1, "--jobs", "1")
    assert len(few.admissible) == len(few.laboratories) == 1
    more = drawn(tmp_path, 2, "--jobs", "1")
    assert repr(more.rows[: len(few.rows)]) == repr(few.rows)
    assert np.array_equal(more.statistics[0], few.statistics[0], equal_nan=True)
    told = refused("decisions", "--out", str(tmp_path), "--seed", "1", "--experiments", "1")
    assert "with experiments '2', and this run has '1'; allowed: the same" in told
