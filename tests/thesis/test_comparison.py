"""The thesis's cells under the decisions of version 0.1, beside those under other decisions."""

import csv
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_hex

from khepera_forage.envs.backends import COMPILED
from khepera_forage.figures import GREY, OURS
from khepera_forage.rollouts.row_files import read_rows, write_rows
from khepera_forage.rollouts.rows import IMITATOR, RecallRow
from khepera_forage.task.decisions import Decisions
from khepera_forage.thesis.design import LABORATORY, THESIS
from khepera_forage.thesis.replication import comparison_counts, pymunk_jobs
from khepera_forage.thesis.reproduce import PAGE, SUMMARY, V0_1_RECALLS, reproduce, write_report
from khepera_forage.thesis.tables import CellResult, cell_results
from tests.thesis import synthetic
from tests.thesis.synthetic import BY_EPISODES, recall

V0_1 = Decisions.v0_1()
OTHER = replace(V0_1, next_to_food=22)
TEXT = "v0.1;next_to_food=22"


@pytest.fixture(scope="module")
def v0_1_results() -> list[CellResult]:
    rows = synthetic.reproduction(5, np.random.default_rng(11))
    return cell_results(rows, np.random.default_rng(12), resamples=200)


@pytest.mark.parametrize(("replications", "expected"), [(1, 1), (2, 2), (24, 5), (1000, 200)])
def test_comparison_has_a_share_of_the_replications(replications: int, expected: int) -> None:
    jobs = pymunk_jobs(0, comparison_counts(replications), V0_1)
    assert [job.arguments for job in jobs] == [(0, i, LABORATORY, THESIS, V0_1) for i in range(expected)]


@pytest.mark.usefixtures("no_pictures")
def test_reproduction_compares_with_version_0_1(tmp_path: Path) -> None:
    """The rows are those of a reproduction under version 0.1, which has no comparison itself."""
    pytest.importorskip("numba")
    first, second, old = (tmp_path / name for name in ("first", "second", "old"))
    for out, decisions in ((first, OTHER), (second, OTHER), (old, V0_1)):
        reproduce(3, 1, out, quick=True, backend=COMPILED, decisions=decisions)
    ours, v0_1 = (read_rows(first / name, RecallRow) for name in ("recalls.csv", V0_1_RECALLS))
    assert {row.decisions for row in ours} == {TEXT}
    assert v0_1 == [
        row
        for row in read_rows(old / "recalls.csv", RecallRow)
        if row.learner == IMITATOR and row.noise == LABORATORY
    ]
    assert len(v0_1) == sum(cell.size for cell in THESIS)
    assert not (old / V0_1_RECALLS).exists()
    for name in ("recalls.csv", V0_1_RECALLS, "table_cells.csv", PAGE, SUMMARY):
        assert (first / name).read_bytes() == (second / name).read_bytes()


@pytest.mark.usefixtures("one_job")
def test_page_table_and_summary_have_both_decisions(tmp_path: Path) -> None:
    page = reproduce(0, 1, tmp_path, backend=COMPILED, decisions=OTHER).read_text()
    size = "1 replication, 1 recall episodes of the imitator"
    assert f"{size}, noise: laboratory, decisions: v0.1, next_to_food=22, backend: compiled. " in page
    assert f"For comparison: {size}, decisions: v0.1. " in page
    assert f"`{V0_1_RECALLS}`" in page
    with open(tmp_path / "table_cells.csv", encoding="utf-8", newline="") as file:
        fourth = list(csv.DictReader(file))[3]
    assert float(fourth["ours: score (%)"]) == float(fourth["v0.1: score (%)"]) == 80.0
    assert {"v0.1: score percentile", "v0.1: food: low", "v0.1: food percentile"} <= fourth.keys()
    heading = "arena      episodes  score (%): thesis  ours  v0.1  food: thesis  ours  v0.1"
    assert heading in (tmp_path / SUMMARY).read_text().splitlines()


@pytest.mark.usefixtures("one_job")
@pytest.mark.parametrize(("decisions", "comparison"), [(V0_1, True), (OTHER, False), (V0_1, False)])
def test_reproduction_without_comparison(decisions: Decisions, comparison: bool, tmp_path: Path) -> None:
    page = reproduce(0, 1, tmp_path, backend=COMPILED, decisions=decisions, comparison=comparison)
    assert not (tmp_path / V0_1_RECALLS).exists()
    assert "For comparison" not in page.read_text()
    assert "v0.1" not in (tmp_path / "table_cells.csv").read_text()
    assert "v0.1" not in (tmp_path / SUMMARY).read_text()


@pytest.mark.usefixtures("one_job")
def test_reproduction_replaces_only_rows_of_version_0_1(tmp_path: Path) -> None:
    path = tmp_path / V0_1_RECALLS
    for _ in range(2):
        reproduce(0, 1, tmp_path, backend=COMPILED, decisions=OTHER)
        assert [row.decisions for row in read_rows(path, RecallRow)] == ["v0.1"]
    write_rows(path, RecallRow, [recall(decisions=TEXT)])
    ours = tmp_path / "recalls.csv"
    ours.unlink()
    message = f"{path} has rows of other decisions: next_to_food is 22, not 20; allowed: "
    with pytest.raises(ValueError, match=re.escape(message)):
        reproduce(0, 1, tmp_path, backend=COMPILED, decisions=OTHER)
    assert not ours.exists(), "the command stops before the first experiment"
    reproduce(0, 1, tmp_path, backend=COMPILED, decisions=OTHER, comparison=False)
    assert [row.decisions for row in read_rows(path, RecallRow)] == [TEXT]


def test_report_refuses_other_rows_as_those_of_version_0_1(tmp_path: Path) -> None:
    rows, rng = [recall(decisions=TEXT)], np.random.default_rng(0)
    with pytest.raises(ValueError, match="v0_1_recalls have other decisions: next_to_food is 22, not 20; "):
        write_report(tmp_path, rows, [], [], [], rng, v0_1_recalls=rows)
    assert not list(tmp_path.iterdir())


@pytest.mark.usefixtures("no_pictures")
def test_comparison_does_not_change_the_other_results(tmp_path: Path, recalls: list[RecallRow]) -> None:
    rows = synthetic.reproduction(5, np.random.default_rng(11))
    for name, v0_1_recalls in (("alone", []), ("beside", rows)):
        rng = np.random.default_rng(9)
        write_report(tmp_path / name, recalls, [], [], [], rng, resamples=200, v0_1_recalls=v0_1_recalls)
    claims = [(tmp_path / name / "table_claims.csv").read_bytes() for name in ("alone", "beside")]
    assert claims[0] == claims[1]


def test_figures_show_version_0_1_in_grey_left_of_ours(
    results: list[CellResult], v0_1_results: list[CellResult]
) -> None:
    for draw, arena, maximum in BY_EPISODES:
        (axes,) = draw(results, v0_1_results).axes
        marks = [(to_hex(line.get_color()).upper(), line) for line in axes.lines if line.get_marker() == "o"]
        grey, ours = (
            np.array([np.hstack(line.get_data()) for colour, line in marks if colour == wanted])
            for wanted in (GREY, OURS)
        )
        mine = [r for r in v0_1_results if r.cell.arena == arena]
        values = [r.food.value * maximum / r.cell.available if maximum else r.score.value for r in mine]
        assert grey[:, 1].tolist() == pytest.approx(values)
        assert (grey[:, 0] < ours[:, 0]).all()
        legend = axes.get_legend()
        assert legend is not None
        assert "version 0.1, mean and 95 % interval" in [text.get_text() for text in legend.get_texts()]
