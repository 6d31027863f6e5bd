"""What a reader sees in the figures: all experiments, whole numbers, legible text, legends."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.collections import PathCollection
from matplotlib.figure import Figure
from matplotlib.patches import Patch

from khepera_forage.rollouts.rows import RecallRow, TrainingRow
from khepera_forage.thesis.cells import CellResult
from khepera_forage.thesis.claims.evidence import gather
from khepera_forage.thesis.figures import fig_5_2, fig_5_3, fig_5_4, fig_5_5, fig_5_6, noise_figure
from khepera_forage.thesis.tables import noise_table
from tests.figure_checks import (
    check_points_are_shown,
    check_readable,
    check_shading_is_explained,
    lay_out,
    legends_of,
)
from tests.thesis.synthetic import recall

Draw = Callable[..., Figure]
BY_EPISODES = [fig_5_2, fig_5_3, fig_5_5, fig_5_6]


@pytest.mark.parametrize("draw", [fig_5_2, fig_5_5])
def test_scores_below_zero_are_shown(draw: Draw, results: list[CellResult]) -> None:
    """Penalties make the score of an experiment negative (5.4)."""
    low = [replace(result, scores=(-13.0, *result.scores)) for result in results]
    (axes,) = draw(low).axes
    check_points_are_shown(axes)
    assert axes.get_ylim()[0] < -13
    assert draw(results).axes[0].get_ylim()[0] == pytest.approx(-2), "no empty space without such scores"


@pytest.mark.parametrize("draw", BY_EPISODES)
def test_all_marks_are_inside_the_axes(draw: Draw, results: list[CellResult]) -> None:
    most = [replace(r, scores=(0.0, 100.0), foods=(0, r.cell.available)) for r in results]
    for figure in (draw(results), draw(most), draw(results, results)):
        check_points_are_shown(figure.axes[0])


@pytest.mark.parametrize("draw", BY_EPISODES)
def test_the_more_experiments_have_a_result_the_wider_they_stand(
    draw: Draw, results: list[CellResult]
) -> None:
    same = [replace(r, scores=(50.0,) * 30 + (70.0,), foods=(3,) * 30 + (5,)) for r in results]
    groups = [part for part in draw(same).axes[0].collections if isinstance(part, PathCollection)]
    assert groups
    for dots in groups:
        points = np.asarray(dots.get_offsets())
        assert len({tuple(point) for point in points.round(6)}) == len(points) == 31
        assert np.ptp(points[:, 0]) < 0.36, "no wider than a bar"
        often, once = points[points[:, 1] < points[:, 1].max()], points[points[:, 1] == points[:, 1].max()]
        assert once[:, 0] == pytest.approx(often[:, 0].mean()), "alone, in the middle"


@pytest.mark.parametrize("draw", [fig_5_3, fig_5_6])
def test_every_colour_of_bars_is_in_the_legend(draw: Draw, results: list[CellResult]) -> None:
    figure = draw(results, results)
    (axes,) = figure.axes
    bars = {patch.get_facecolor() for patch in axes.patches}
    (legend,) = legends_of(figure)
    explained = {patch.get_facecolor() for patch in legend.findobj(Patch) if patch.get_alpha() is not None}
    assert len(bars) == 3
    assert bars <= explained


@pytest.mark.parametrize("draw", BY_EPISODES)
@pytest.mark.parametrize("compared", [False, True])
def test_figures_by_episodes_are_readable(draw: Draw, compared: bool, results: list[CellResult]) -> None:
    check_readable(lay_out(draw(results, results if compared else ())))


def test_noise_figure_is_readable(noise_rows: list[RecallRow], trainings: list[TrainingRow]) -> None:
    figure = noise_figure(noise_table(noise_rows, gather([], trainings, [], np.random.default_rng(1))))
    lay_out(figure)
    check_readable(figure)
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["mean and 95 % interval", "without noise"]


# Rows of many foods along and across the corridor, under several set-ups.
SET_UPS = ["v0.1", "v0.1;food_aside=30;start_aside=-25", "v0.1;food_to_home=185;start_to_wall=115"]


def scattered(decisions: str) -> list[RecallRow]:
    places = [(x, y) for x in range(-110, -12, 2) for y in range(-20, 21, 2)]
    return [recall(decisions=decisions, food_x=(float(x),), food_y=(float(y),)) for x, y in places] * 12


@pytest.mark.parametrize("decisions", SET_UPS)
def test_marks_do_not_cover_numbers_of_figure_5_4(decisions: str) -> None:
    figure = lay_out(fig_5_4(scattered(decisions)))
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


def test_figure_5_4_is_readable_and_explains_its_shading() -> None:
    figure = lay_out(fig_5_4(scattered("v0.1")))
    check_readable(figure)
    check_shading_is_explained(figure)
    labels = [text.get_text() for legend in legends_of(figure) for text in legend.get_texts()]
    assert labels == [
        "home",
        "food in training",
        "start in training",
        "ours with 95 % Wilson interval",
        "food in training",
        "home",
    ]
    check_points_are_shown(figure.axes[1])
