"""Figures and the page of the report, from synthetic rows."""

import csv
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from khepera_forage.rollouts.rows import RANDOM, RecallRow, TrainingRow
from khepera_forage.task.decisions import Decisions
from khepera_forage.thesis.cells import CellResult, cell_results
from khepera_forage.thesis.claims.evidence import gather
from khepera_forage.thesis.design import training_distance
from khepera_forage.thesis.figures import (
    BIN,
    fig_5_2,
    fig_5_3,
    fig_5_4,
    fig_5_5,
    fig_5_6,
    food_places,
    noise_figure,
    success_by_distance,
)
from khepera_forage.thesis.report import PAGE, write_report
from khepera_forage.thesis.tables import noise_table
from tests.thesis import synthetic
from tests.thesis.synthetic import failed, recall


def test_success_by_distance_ignores_other_arenas_and_policies() -> None:
    rows = [
        recall(food_x=(-30.0,), food_y=(1.0,)),
        failed(food_x=(0.0,), food_y=(30.0,)),
        failed(food_x=(-90.0,)),
    ]
    ignored = [recall(arena="rectangle"), recall(learner=RANDOM)]
    near, far = success_by_distance(food_places(rows + ignored))
    assert (near[0], near[1], near[2].value) == (BIN * 3.5, 2, 0.5)
    assert (far[1], far[2].value) == (1, 0.0)
    assert BIN * 4 <= training_distance(Decisions.v0_1()) < BIN * 5


def test_figures_show_the_thesis_and_our_means(results: list[CellResult]) -> None:
    """The thesis's values are those of its figures 5.2, 5.3, 5.5 and 5.6."""
    for figure, arena, values, scale in (
        (fig_5_2(results), "corridor", [52.7, 67.55, 68.2, 73.8], None),
        (fig_5_3(results), "corridor", [8, 11, 12, 14], 20),
        (fig_5_5(results), "rectangle", [44.25, 60.33, 67.08], None),
        (fig_5_6(results), "rectangle", [7, 14, 13], 24),
    ):
        (axes,) = figure.axes
        points = [(line.get_marker(), np.ravel(line.get_ydata())) for line in axes.lines]
        thesis = [y[0] for marker, y in points if marker == "D"]
        ours = [y[0] for marker, y in points if marker == "o"]
        assert thesis == pytest.approx(values, abs=0.01)
        mine = [r for r in results if r.cell.arena == arena]
        if scale is None:
            assert ours == pytest.approx([r.score.value for r in mine])
        else:
            assert ours == pytest.approx([scale * r.food.value / r.cell.available for r in mine])
            assert axes.get_ylim()[1] >= scale


def test_figures_without_rows_can_be_drawn() -> None:
    results = cell_results([], np.random.default_rng(1))
    for figure in (fig_5_2(results), fig_5_3(results), fig_5_4([])):
        figure.draw_without_rendering()


def test_noise_figure_has_a_panel_for_each_cell(
    noise_rows: list[RecallRow], trainings: list[TrainingRow]
) -> None:
    table = noise_table(noise_rows, gather([], trainings, [], np.random.default_rng(1)))
    labels = [axes.get_xlabel() for axes in noise_figure(table).axes]
    assert labels == [
        "score (%)\ncorridor, 10 episodes",
        "score (%)\nrectangle, 10 episodes",
        "attempts per complete\ntraining episode",
    ]


def test_report_has_page_tables_and_figures(
    tmp_path: Path,
    recalls: list[RecallRow],
    trainings: list[TrainingRow],
    teachers: list[RecallRow],
    noise_rows: list[RecallRow],
) -> None:
    folder = tmp_path / "results"
    rng = np.random.default_rng(6)
    written = write_report(folder, recalls, trainings, teachers, noise_rows, rng, resamples=200)
    assert all(path.stat().st_size > 0 for path in written)
    page = (folder / PAGE).read_text(encoding="utf-8")
    pictures = sorted(path.name for path in written if path.suffix == ".png")
    assert pictures == [*(f"figure_5_{i}.png" for i in range(2, 7)), "noise.png"]
    for picture in pictures:
        assert f"({picture})" in page
        with Image.open(folder / picture) as image:
            assert min(image.size) > 400
    assert (
        "6 replications, 636 recall episodes of the imitator, noise: laboratory, decisions: v0.1, "
        "backend: pymunk." in page
    )
    assert "nan" not in page
    with open(folder / "table_claims.csv", encoding="utf-8", newline="") as file:
        claims = list(csv.DictReader(file))
    assert len(claims) == 18
    assert {claim["verdict"] for claim in claims} <= {"supported", "not supported", "undecided"}
    assert float(claims[0]["value: low"]) <= float(claims[0]["value"]) <= float(claims[0]["value: high"])


def test_report_on_one_replication_has_no_supported_claim(tmp_path: Path) -> None:
    rows = synthetic.reproduction(1, np.random.default_rng(7))
    write_report(tmp_path, rows, [], [], [], np.random.default_rng(8), resamples=200)
    page = (tmp_path / PAGE).read_text(encoding="utf-8")
    assert "1 replication, 106 recall episodes" in page
    assert "| undecided |" in page
    assert "| supported |" not in page
    assert "Effect of each source of noise" not in page


def test_report_with_the_same_generator_is_the_same(tmp_path: Path, recalls: list[RecallRow]) -> None:
    pages = []
    for name in ("a", "b"):
        write_report(tmp_path / name, recalls, [], [], [], np.random.default_rng(9), resamples=200)
        pages.append((tmp_path / name / PAGE).read_text(encoding="utf-8"))
    assert pages[0] == pages[1]
