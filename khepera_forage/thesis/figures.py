"""Figures 5.2, 5.3, 5.5 and 5.6 with the thesis's values and ours, and a figure of the noise table.

They use matplotlib's figure objects directly, without a window system or global state.
"""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from khepera_forage.experiments.figures import GREY, OURS, THESIS, mark, new_figure
from khepera_forage.experiments.statistics import UNKNOWN, Estimate
from khepera_forage.experiments.tables import Table
from khepera_forage.thesis.cells import CellResult
from khepera_forage.thesis.design import NO_NOISE

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_OF_TWO, _OF_THREE = (-0.2, 0.2), (0.0, 0.4)
"""Horizontal offsets in episodes of our marks and the thesis's, without and with marks of version 0.1."""
_V0_1 = -0.4
"""Horizontal offset of the marks of version 0.1."""
_WIDTH = 0.36
"""Of a bar, in episodes."""


def fig_5_2(results: Sequence[CellResult], v0_1_results: Sequence[CellResult] = ()) -> "Figure":
    """Average scores in the corridor against the number of training episodes."""
    return _score_figure(results, v0_1_results, "corridor", "Figure 5.2: recall score in the corridor")


def fig_5_3(results: Sequence[CellResult], v0_1_results: Sequence[CellResult] = ()) -> "Figure":
    """Food carried home in the corridor, of 20."""
    return _food_figure(
        results, v0_1_results, "corridor", 20, "Figure 5.3: food carried home in the corridor"
    )


def fig_5_5(results: Sequence[CellResult], v0_1_results: Sequence[CellResult] = ()) -> "Figure":
    """Average scores in the rectangle against the number of training episodes."""
    return _score_figure(results, v0_1_results, "rectangle", "Figure 5.5: recall score in the rectangle")


def fig_5_6(results: Sequence[CellResult], v0_1_results: Sequence[CellResult] = ()) -> "Figure":
    """Food carried home in the rectangle, of 24."""
    return _food_figure(
        results, v0_1_results, "rectangle", 24, "Figure 5.6: food carried home in the rectangle"
    )


def noise_figure(table: Table) -> "Figure":
    """The noise table as a figure: scores and training attempts under each source of noise."""
    names = list(dict.fromkeys(str(row[0]) for row in table.rows))
    cells = list(dict.fromkeys(str(row[1]) for row in table.rows))
    panels = [
        (f"score (%)\n{cell} episodes", {str(r[0]): r[2] for r in table.rows if r[1] == cell})
        for cell in cells
    ]
    panels.append(("attempts per complete\ntraining episode", {str(row[0]): row[5] for row in table.rows}))
    figure = new_figure(2.6 + 2.5 * len(panels), 1.6 + 0.36 * len(names))
    columns = figure.subplots(1, len(panels), sharey=True)
    for axes, (label, estimates) in zip(columns, panels, strict=True):
        for place, name in enumerate(reversed(names)):
            estimate = estimates.get(name, UNKNOWN)
            assert isinstance(estimate, Estimate)
            mark(axes, estimate.value, place, estimate, OURS, level=True)
            if name == NO_NOISE and math.isfinite(estimate.value):
                axes.axvline(estimate.value, color=GREY, lw=1, ls=":", zorder=1)
        axes.set_xlabel(label)
        axes.grid(axis="x", color="0.9")
        axes.margins(x=0.08)
        axes.tick_params(axis="y", length=0)
    columns[0].set_yticks(range(len(names)), names[::-1])
    columns[0].set_ylim(-0.6, len(names) - 0.4)
    figure.suptitle("Effect of each source of noise")
    figure.supxlabel("dotted: no noise; bars: 95 % interval over replications", fontsize=8, color=GREY)
    return figure


def _score_figure(
    results: Sequence[CellResult], v0_1_results: Sequence[CellResult], arena: str, title: str
) -> "Figure":
    figure, axes = _episode_axes(title)
    ours, thesis = _OF_THREE if v0_1_results else _OF_TWO
    for result in _in_arena(v0_1_results, arena):
        mark(axes, result.cell.episodes + _V0_1, result.score.value, result.score, GREY)
    for result in _in_arena(results, arena):
        x = result.cell.episodes
        _experiments(axes, x + ours, result.scores)
        mark(axes, x + ours, result.score.value, result.score, OURS)
        axes.plot(x + thesis, result.thesis_score, "D", color=THESIS, ms=8, mec="white", zorder=4)
    axes.set_ylim(0, 100)
    axes.set_yticks(range(0, 101, 10))
    axes.set_ylabel("average score of recall episodes (%)")
    _legend(axes, v0_1=bool(v0_1_results))
    return figure


def _food_figure(
    results: Sequence[CellResult], v0_1_results: Sequence[CellResult], arena: str, maximum: int, title: str
) -> "Figure":
    figure, axes = _episode_axes(title)
    ours, thesis = _OF_THREE if v0_1_results else _OF_TWO
    for result in _in_arena(v0_1_results, arena):
        _food_mark(axes, result.cell.episodes + _V0_1, result, maximum, GREY)
    for result in _in_arena(results, arena):
        x = result.cell.episodes
        scale = maximum / result.cell.available
        _food_mark(axes, x + ours, result, maximum, OURS)
        _experiments(axes, x + ours, [scale * count for count in result.foods])
        food = scale * result.thesis_food
        axes.bar(x + thesis, food, _WIDTH, color=THESIS, alpha=0.35, zorder=1)
        axes.plot(x + thesis, food, "D", color=THESIS, ms=8, mec="white", zorder=4)
        if scale != 1:
            note = f"of {result.cell.available},\ntimes {scale:g}"
            axes.text(x + thesis + 0.35, 0.2, note, va="bottom", fontsize=8, color=GREY)
    axes.set_ylim(0, maximum * 1.02)
    axes.set_yticks(range(0, maximum + 1, 4))
    axes.set_ylabel(f"food objects carried home (of {maximum})")
    _legend(axes, v0_1=bool(v0_1_results))
    return figure


def _in_arena(results: Sequence[CellResult], arena: str) -> list[CellResult]:
    return [result for result in results if result.cell.arena == arena]


def _food_mark(axes: "Axes", x: float, result: CellResult, maximum: int, colour: str) -> None:
    """Draw the food of a cell, scaled to `maximum` available objects, as a bar with its interval."""
    food = Estimate(*(maximum / result.cell.available * value for value in result.food))
    axes.bar(x, food.value, _WIDTH, color=colour, alpha=0.35, zorder=1)
    mark(axes, x, food.value, food, colour)


def _episode_axes(title: str) -> tuple["Figure", "Axes"]:
    figure = new_figure(6.4, 4.4)
    axes = figure.subplots()
    axes.set_title(title)
    axes.set_xlabel("number of training episodes")
    axes.set_xlim(0, 12)
    axes.set_xticks((0, 1, 3, 5, 10))
    axes.grid(axis="y", color="0.9")
    axes.set_axisbelow(True)
    return figure, axes


def _experiments(axes: "Axes", x: float, values: Sequence[float]) -> None:
    """Draw single experiments as faint dots, spread sideways in a fixed pattern."""
    if not values:
        return
    spread = 0.13 * np.sin(2.4 * np.arange(len(values)))
    fade = max(0.08, min(0.5, 8 / len(values)))
    axes.scatter(x + spread, values, s=9, color=OURS, alpha=fade, lw=0, zorder=2)


def _legend(axes: "Axes", v0_1: bool) -> None:
    from matplotlib.lines import Line2D

    label = "version 0.1, mean and 95 % interval"
    old = Line2D([], [], marker="o", color=GREY, ls="-", ms=7, mec="white", label=label)
    axes.legend(
        handles=[
            Line2D([], [], marker="D", color=THESIS, ls="", ms=8, mec="white", label="thesis"),
            Line2D(
                [],
                [],
                marker="o",
                color=OURS,
                ls="-",
                ms=7,
                mec="white",
                label="ours, mean and 95 % interval",
            ),
            Line2D([], [], marker="o", color=OURS, ls="", ms=4, alpha=0.4, label="ours, single experiments"),
            *([old] if v0_1 else ()),
        ],
        loc="upper center",
        bbox_to_anchor=(0.5, -0.14),
        ncols=2 if v0_1 else 3,
        frameon=False,
        fontsize=8,
    )
