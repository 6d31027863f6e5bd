"""Figures and the page of the report, from synthetic rows."""

import csv
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.collections import PathCollection
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from PIL import Image

from khepera_forage.estimates import pick
from khepera_forage.figures import GREY, OURS
from khepera_forage.rollouts.rows import RANDOM, RecallRow, TrainingRow
from khepera_forage.study import Rows
from khepera_forage.task.decisions import Decisions
from khepera_forage.thesis import figures
from khepera_forage.thesis.claims import Evidence, gather
from khepera_forage.thesis.design import NO_NOISE, training_distance
from khepera_forage.thesis.replication import UntrainedRow
from khepera_forage.thesis.reproduce import PAGE, write_report
from khepera_forage.thesis.tables import CellResult, cell_results, noise_table
from tests.figure_checks import check_points_are_shown, check_readable, check_shading_is_explained, lay_out, legends_of
from tests.thesis.synthetic import failed, recall

Draw = Callable[..., Figure]
BY_EPISODES = [
    (partial(figures.figure_by_episodes, *kind), kind[1], maximum)
    for kind, maximum in zip(figures.BY_EPISODES, (None, 20, None, 24), strict=True)
]
"""Figures with their arena, and the food objects in it."""


def test_success_by_distance_ignores_other_arenas_and_policies() -> None:
    rows = [recall(food_x=(-30.0,), food_y=(1.0,)), failed(food_x=(0.0,), food_y=(30.0,)), failed(food_x=(-90.0,))]
    ignored = [recall(arena="rectangle"), recall(learner=RANDOM)]
    near, far = figures.success_by_distance(figures.food_places(rows + ignored))
    assert (near[0], near[1], near[2].value) == (figures.BIN * 3.5, 2, 50)
    assert (far[1], far[2].value) == (1, 0.0)
    assert figures.BIN * 4 <= training_distance(Decisions.v0_1()) < figures.BIN * 5


def test_figures_show_the_thesis_our_means_and_version_0_1(results: list[CellResult], recalls: list[RecallRow]) -> None:
    """The thesis's values are those of its figures 5.2, 5.3, 5.5 and 5.6; version 0.1 is grey, left of ours."""
    printed = ([52.7, 67.55, 68.2, 73.8], [8, 11, 12, 14], [44.25, 60.33, 67.08], [7, 14, 13])
    old_results = cell_results(pick(recalls, replication=0), np.random.default_rng(12))
    for (draw, arena, scale), values in zip(BY_EPISODES, printed, strict=True):
        (axes,) = draw(results, old_results).axes
        points: dict[str, list[Any]] = {kind: [] for kind in ("D", OURS, GREY)}
        for line in axes.lines:
            if (marker := line.get_marker()) in ("D", "o"):
                kind = "D" if marker == "D" else to_hex(line.get_color()).upper()
                points[kind].append(np.hstack(line.get_data()).tolist())
        thesis, ours, old = (np.array(places) for places in points.values())
        assert thesis[:, 1] == pytest.approx(values, abs=0.01)
        for shown, measured in ((ours, results), (old, old_results)):
            own = [r for r in measured if r.cell.arena == arena]
            means = [scale * r.food.ours.value / r.cell.available if scale else r.score.ours.value for r in own]
            assert shown[:, 1] == pytest.approx(means)
        assert (old[:, 0] < ours[:, 0]).all()
        assert axes.get_ylim()[1] >= (scale or 0)
        legend = axes.get_legend()
        assert legend is not None
        assert "version 0.1, mean and 95 % interval" in [text.get_text() for text in legend.get_texts()]


def test_report_has_page_tables_and_figures(tmp_path: Path, rows: Rows) -> None:
    folder = tmp_path / "results"
    write_report(folder, rows, np.random.default_rng(6), resamples=200)
    assert all(path.stat().st_size > 0 for path in folder.iterdir())
    page = (folder / PAGE).read_text(encoding="utf-8")
    pictures = sorted(path.name for path in folder.glob("*.png"))
    assert pictures == [*(f"figure_5_{i}.png" for i in range(2, 7)), "noise.png"]
    for picture in pictures:
        assert f"({picture})" in page
        with Image.open(folder / picture) as image:
            assert min(image.size) > 400
    assert (
        "6 replications, 636 recall episodes of the imitator, noise: laboratory, decisions: v1, "
        "backend: pymunk." in page
    )
    assert "nan" not in page
    with open(folder / "table_claims.csv", encoding="utf-8", newline="") as file:
        claims = list(csv.DictReader(file))
    assert len(claims) == 16
    assert {claim["verdict"] for claim in claims} <= {"supported", "not supported", "undecided"}
    assert float(claims[0]["value: low"]) <= float(claims[0]["value"]) <= float(claims[0]["value: high"])


@pytest.mark.parametrize(("draw", "scale"), [(figure, scale) for figure, _, scale in BY_EPISODES])
def test_figures_by_episodes_are_readable_and_show_all_experiments(
    draw: Draw, scale: int | None, results: list[CellResult]
) -> None:
    """Penalties make the score of an experiment negative (5.4); many experiments may have the same result."""
    low = [
        r._replace(
            score=r.score._replace(experiments=(-13.0, 100.0) + (50.0,) * 30),
            food=r.food._replace(experiments=(0, r.cell.available)),
        )
        for r in results
    ]
    usual, lowest, compared = (lay_out(figure) for figure in (draw(results), draw(low), draw(results, results)))
    for figure in (usual, lowest, compared):
        check_points_are_shown(figure.axes[0])
    for figure in (usual, compared):
        check_readable(figure)
    for dots in lowest.axes[0].collections:
        if isinstance(dots, PathCollection):
            points = np.asarray(dots.get_offsets()).round(6)
            assert len({tuple(point) for point in points}) == len(points)
    if scale is None:
        assert lowest.axes[0].get_ylim()[0] < -13
        assert usual.axes[0].get_ylim()[0] == pytest.approx(-2), "no empty space without such scores"
    else:
        bars = {patch.get_facecolor() for patch in compared.axes[0].patches}
        (legend,) = legends_of(compared)
        assert len(bars) == 3
        assert bars <= {patch.get_facecolor() for patch in legend.findobj(Patch) if patch.get_alpha()}


def test_noise_figure_is_readable(noise_rows: list[RecallRow], evidence: Evidence) -> None:
    figure = lay_out(figures.noise_figure(noise_table(noise_rows, evidence)))
    check_readable(figure)
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["mean and 95 % interval", "without noise"]


def test_noise_condition_that_cannot_be_trained_is_told(
    recalls: list[RecallRow], trainings: list[TrainingRow], noise_rows: list[RecallRow]
) -> None:
    rows = [row for row in noise_rows if row.noise != NO_NOISE]
    tries = [row for row in trainings if row.noise != NO_NOISE]
    missing = [UntrainedRow(first, 100, NO_NOISE, "none of 200 attempts", "") for first in (0, 100)]
    table = noise_table(rows, gather(recalls, tries, np.random.default_rng(1), 200), missing)
    assert table.note.endswith("as no attempt at a training episode was complete: none (200).")
    figure = lay_out(figures.noise_figure(table))
    check_readable(figure)
    assert [text.get_text() for axes in figure.axes for text in axes.texts] == ["no complete training"] * 3
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["mean and 95 % interval"], "nothing to compare with"


def scattered(decisions: str) -> list[RecallRow]:
    """Recalls of many foods along and across the corridor."""
    places = [(x, y) for x in range(-110, -12, 2) for y in range(-20, 21, 2)]
    return [recall(decisions=decisions, food_x=(float(x),), food_y=(float(y),)) for x, y in places] * 12


@pytest.mark.parametrize(
    "decisions", ["v0.1", "v0.1;food_aside=30;start_aside=-25", "v0.1;food_to_home=185;start_to_wall=115"]
)
def test_figure_5_4_is_readable_explains_its_shading_and_has_no_number_below_a_mark(decisions: str) -> None:
    figure = lay_out(figures.fig_5_4(scattered(decisions)))
    check_readable(figure)
    check_shading_is_explained(figure)
    check_points_are_shown(figure.axes[1])
    labels = [text.get_text() for legend in legends_of(figure) for text in legend.get_texts()]
    of_the_map = ["home", "food in training", "start in training"]
    assert labels == [*of_the_map, "ours with 95 % Wilson interval", "food in training", "home"]
    axes = figure.axes[0]
    numbers = [text for text in axes.texts if text.get_text().isdigit()]
    marks = [line for line in axes.lines if np.asarray(line.get_xydata()).shape == (1, 2)]
    assert len(numbers) > 20
    assert len(marks) == 2
    for line in marks:
        ((x, y),) = axes.transData.transform(np.asarray(line.get_xydata()))
        radius = line.get_markersize() / 2 * figure.dpi / 72
        for number in numbers:
            box = number.get_window_extent()
            dx, dy = max(box.x0 - x, x - box.x1, 0), max(box.y0 - y, y - box.y1, 0)
            assert np.hypot(dx, dy) >= 0.8 * radius, f"{line.get_label()} covers {number.get_text()}"
