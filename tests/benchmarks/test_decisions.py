"""`khepera-forage infer`: sets from the prior, and the page of what is inferred from them."""

import shutil
from dataclasses import replace
from functools import partial
from importlib import resources
from pathlib import Path

import numpy as np
import pytest

from khepera_forage import study
from khepera_forage.cli.main import main
from khepera_forage.study import Count, parse
from khepera_forage.thesis.inference import page, posterior
from khepera_forage.thesis.inference.claims import CLAIMS
from khepera_forage.thesis.inference.prior import PRIOR
from khepera_forage.thesis.inference.simulate import FILE, KEPT, Sets, draw
from khepera_forage.thesis.inference.summary import fitted_columns, tables_statistics, thesis_statistics
from tests.benchmarks.conftest import QuickRun
from tests.benchmarks.running import read

pytest.importorskip("numba")


@pytest.fixture(scope="module")
def out(quick_run: QuickRun) -> Path:
    return quick_run("decisions")


def test_every_part_of_the_prior_has_a_source_a_calibration_and_a_posterior(out: Path) -> None:
    prior = read(out / "table_prior.csv")
    assert {row["decision or noise"] for row in prior} == set(PRIOR.parts)
    assert all(row["source"] for row in prior)
    assert {row["decision or noise"] for row in read(out / "table_calibration.csv")} == set(PRIOR.parts)
    numbers = {row["decision or noise"] for row in read(out / "table_posterior_numbers.csv")}
    alternatives = read(out / "table_posterior_alternatives.csv")
    assert numbers | {row["decision"] for row in alternatives} == set(PRIOR.parts)
    shares = [float(row["posterior (%)"]) for row in alternatives if row["decision"] == "orienting"]
    assert sum(shares) == pytest.approx(100, abs=0.01)


def test_cells_stand_beside_the_thesis(out: Path) -> None:
    rows = {row["statistic"]: row for row in read(out / "table_cells.csv")}
    assert float(rows["corridor 1 food"]["thesis"]) == 0.4
    assert rows["corridor 1 food"]["use"] == "fitted"
    assert rows["rectangle 10 score"]["use"] == "test"
    for row in rows.values():
        for name in ("version 0.1", "posterior"):
            rank = row[f"percentile ({name})"]
            assert rank == "" or 0 <= float(rank) <= 100


def test_nothing_of_the_test_set_is_fitted(out: Path) -> None:
    rows = [row for row in read(out / "table_cells.csv") if row["use"] == "test"]
    assert len(rows) == 19
    assert all(row["statistic"].startswith("rectangle") for row in rows)
    assert all(0 <= float(row["posterior sets (%)"]) <= 100 for row in rows)


def test_figures_of_the_text_and_all_claims_are_in_tables(out: Path) -> None:
    counts = {row["outcome"]: int(row["sets"]) for row in read(out / "table_admissible.csv")}
    values = {row["quantity"]: float(row["value"]) for row in read(out / "table_sizes.csv")}
    assert counts["admissible"] == values["admissible sets"] == 3
    assert 1 <= values["sets of equal weight that the posterior is worth"] <= 3
    assert 0 < values["joint p"] <= 1
    assert [row["claim"] for row in read(out / "table_claims.csv")] == [claim.name for claim in CLAIMS]


def test_three_sets_explain_nothing_and_determine_nothing(out: Path) -> None:
    assert "too few sets" in (out / "decisions.md").read_text()
    assert {row["explained (%)"] for row in read(out / "table_questions.csv")} == {""}
    assert {row["tables say"] for row in read(out / "table_calibration.csv")} <= {"nothing", "not calibrated"}


def test_sets_of_a_run_are_kept_as_in_the_package(out: Path) -> None:
    columns, numbers = len(fitted_columns()), len(PRIOR.parts)
    with np.load(out / KEPT) as kept:
        assert kept["statistics"].shape == (3, 2, columns)
        assert kept["values"].shape == (3, numbers)
        assert str(kept["prior"]) == PRIOR.text
    sets = Sets.load()
    assert sets.statistics.shape == (10_000, 1, columns)
    assert [one.name for one in sets.parameters] == list(PRIOR.parts)


def test_sets_of_the_package_are_of_its_prior() -> None:
    with resources.files("khepera_forage.thesis.inference").joinpath(KEPT).open("rb") as kept:
        assert str(np.load(kept)["prior"]) == PRIOR.text, "make new ones by khepera-forage infer --experiments 1"


def infer(capsys: pytest.CaptureFixture[str], *options: str) -> tuple[int, str]:
    status = main(["infer", *options])
    told = capsys.readouterr()
    return status, told.err if status else told.out


def test_known_decisions_are_recovered_from_tables_of_a_pseudo_thesis(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of a round of 0.15 s, where sets of the prior have 0.22 s in the median.

    Of trees and sets a twentieth is enough, and a hundredth for the warning. The quick run draws the pictures.
    """
    monkeypatch.setattr(study, "save", lambda figure, path: None)
    every = Sets.load()

    def keep_one_of(number: int) -> None:
        few = [replace(one, values=one.values[::number]) for one in every.parameters]
        monkeypatch.setattr(page, "infer", partial(posterior.infer, trees=posterior.TREES // number))
        monkeypatch.setattr(Sets, "load", lambda: every._replace(parameters=few, statistics=every.statistics[::number]))

    keep_one_of(20)
    pseudo = tmp_path / "pseudo"
    decisions = ("--decision", "v0.1", "--decision", "round_duration=0.15")
    options = ("--replications", "1", *decisions, "--no-comparison")
    assert main(["reproduce", *options, "--quick", "--out", str(pseudo)]) == 0
    capsys.readouterr()
    status, told = infer(capsys, "--tables", str(pseudo / "recalls.csv"), "--out", str(tmp_path))
    assert status == 0
    assert f"are in {tmp_path / 'recalls'}" in told
    rows = read(tmp_path / "recalls" / "table_posterior_numbers.csv")
    (row,) = (row for row in rows if row["decision or noise"] == "round_duration")
    assert float(row["admissible"]) == pytest.approx(0.22, abs=0.01)
    assert float(row["posterior"]) == pytest.approx(0.15, abs=0.03)
    keep_one_of(100)
    assert main(["infer", "--tables", "thesis", "--out", str(tmp_path)]) == 0
    assert "do not resemble these tables" in capsys.readouterr().err


def test_printed_tables_are_read_like_the_thesis_s_own(tmp_path: Path) -> None:
    text = resources.files("khepera_forage.thesis").joinpath("appendix_a.csv").read_text()
    path = tmp_path / "tables.csv"
    path.write_text(text)
    own = thesis_statistics()[fitted_columns()]
    assert tables_statistics(path) == pytest.approx(own)
    path.write_text("\n".join(line for line in text.split("\n") if "rectangle" not in line))
    assert tables_statistics(path) == pytest.approx(own)
    path.write_text("\n".join(line for line in text.split("\n") if not line.startswith("A.4,3,")))
    with pytest.raises(ValueError, match=r"has \[9\] recalls after 10 training .*; allowed: 10 each with g1234"):
        tables_statistics(path)


def test_more_sets_continue_the_run(out: Path, tmp_path: Path) -> None:
    with np.load(out / KEPT) as kept:
        few, draws = kept["statistics"], int(kept["draws"])
    shutil.copy(out / FILE, tmp_path)
    counts = (Count("sets", 10, 4, "admissible sets", adds_units=True), Count("experiments", 20, 2, "experiments"))
    options = ["--quick", "--seed", "1", "--out", str(tmp_path), "--jobs", "1"]
    more = draw(parse("decisions", "", *counts, given=options), 4, 2).sets
    assert len(more.statistics) == 4
    assert more.draws > draws
    assert np.array_equal(more.statistics[:3], few, equal_nan=True)
