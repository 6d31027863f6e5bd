"""Figures 5.2, 5.3, 5.5 and 5.6 with the thesis's values and ours, and what all figures are drawn with.

They use matplotlib's figure objects directly, without a window system or global state.
"""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from khepera_forage.estimates import Estimate
from khepera_forage.figures import (
    GREY,
    OURS,
    SMALL,
    THESIS,
    mark,
    new_figure,
    padded,
)
from khepera_forage.thesis.cells import CellResult

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_OF_TWO, _OF_THREE = (-0.2, 0.2), (0.0, 0.4)
"""Horizontal offsets in episodes of our marks and the thesis's, without and with marks of version 0.1."""
_V0_1 = -0.4
"""Horizontal offset of the marks of version 0.1."""
_WIDTH = 0.36
"""Of a bar, in episodes."""
_SCORE_STEP = 1.0
"""Percent: scores this near to each other are spread sideways."""
_PALE = 0.35
"""Opacity of bars."""


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


def _score_figure(
    results: Sequence[CellResult], v0_1_results: Sequence[CellResult], arena: str, title: str
) -> "Figure":
    figure, axes = _episode_axes(title)
    ours, thesis = _OF_THREE if v0_1_results else _OF_TWO
    for result in _in_arena(v0_1_results, arena):
        mark(axes, result.cell.episodes + _V0_1, result.score.value, result.score, GREY)
    for result in _in_arena(results, arena):
        x = result.cell.episodes
        _experiments(axes, x + ours, result.scores, _SCORE_STEP)
        mark(axes, x + ours, result.score.value, result.score, OURS)
        axes.plot(x + thesis, result.thesis_score, "D", color=THESIS, ms=8, mec="white", zorder=4)
    lowest = _lowest_score(_in_arena(results, arena), _in_arena(v0_1_results, arena))
    axes.set_ylim(*padded(lowest, 100))
    axes.set_yticks(range(lowest, 101, 10))
    axes.set_ylabel("average score of recall episodes (%)")
    _legend(axes, bool(v0_1_results), bars=False)
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
        _experiments(axes, x + ours, [scale * count for count in result.foods], scale)
        food = scale * result.thesis_food
        axes.bar(x + thesis, food, _WIDTH, color=THESIS, alpha=_PALE, zorder=1)
        axes.plot(x + thesis, food, "D", color=THESIS, ms=8, mec="white", zorder=4)
        if scale != 1:
            note = f"of {result.cell.available},\ntimes {scale:g}"
            axes.text(x + thesis + 0.35, 0.2, note, va="bottom", fontsize=SMALL, color=GREY)
    axes.set_ylim(*padded(0, maximum))
    axes.set_yticks(range(0, maximum + 1, 4))
    axes.set_ylabel(f"food objects carried home (of {maximum})")
    _legend(axes, bool(v0_1_results), bars=True)
    return figure


def _lowest_score(results: Sequence[CellResult], v0_1_results: Sequence[CellResult]) -> int:
    """The multiple of ten, at most 0, below which no score is shown; penalties make scores negative (5.4)."""
    shown = [score for r in results for score in (*r.scores, r.thesis_score, *r.score)]
    shown += [score for r in v0_1_results for score in r.score]
    return 10 * math.floor(min([0.0, *filter(math.isfinite, shown)]) / 10)


def _in_arena(results: Sequence[CellResult], arena: str) -> list[CellResult]:
    return [result for result in results if result.cell.arena == arena]


def _food_mark(axes: "Axes", x: float, result: CellResult, maximum: int, colour: str) -> None:
    """Draw the food of a cell, scaled to `maximum` available objects, as a bar with its interval."""
    food = Estimate(*(maximum / result.cell.available * value for value in result.food))
    axes.bar(x, food.value, _WIDTH, color=colour, alpha=_PALE, zorder=1)
    mark(axes, x, food.value, food, colour)


def _episode_axes(title: str) -> tuple["Figure", "Axes"]:
    figure = new_figure(6.4, 4.4)
    axes = figure.subplots()
    axes.set_title(title)
    axes.set_xlabel("number of training episodes")
    axes.set_xlim(0, 12)
    axes.set_xticks((1, 3, 5, 10))
    axes.grid(axis="y", color="0.9")
    axes.set_axisbelow(True)
    return figure, axes


def _experiments(axes: "Axes", x: float, values: Sequence[float], step: float) -> None:
    """Draw single experiments as dots: the more have about the same value, the wider they are spread.

    Args:
        axes: Where.
        x: The middle.
        values: One an experiment.
        step: Values in the same multiple of it are spread.
    """
    if not values:
        return
    classes = np.floor(np.asarray(values) / step + 1e-9).astype(int)
    counts = {int(number): int((classes == number).sum()) for number in np.unique(classes)}
    places = np.empty(len(values))
    for number, count in counts.items():
        # From -1 to 1, symmetric: one dot stands in the middle.
        spread = (2 * np.arange(count) + 1 - count) / max(counts.values())
        places[classes == number] = x + 0.9 * _WIDTH / 2 * spread
    axes.scatter(places, values, s=4, color=OURS, alpha=0.5, lw=0, zorder=2)


def _legend(axes: "Axes", v0_1: bool, bars: bool) -> None:
    from matplotlib.legend_handler import HandlerTuple
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    kinds = [("thesis", THESIS, "D", 8.0, ""), ("ours, mean and 95 % interval", OURS, "o", 7.0, "-")]
    if v0_1:
        kinds.append(("version 0.1, mean and 95 % interval", GREY, "o", 7.0, "-"))
    handles: list[Line2D | tuple[Patch, Line2D]] = []
    for _, colour, marker, size, line in kinds:
        shown = Line2D([], [], marker=marker, color=colour, ls=line, ms=size, mec="white")
        handles.append((Patch(color=colour, alpha=_PALE), shown) if bars else shown)
    handles.insert(2, Line2D([], [], marker="o", color=OURS, ls="", ms=3, alpha=0.5))
    labels = [label for label, *_ in kinds]
    labels.insert(2, "ours, single experiments (wider: more)")
    axes.legend(
        handles,
        labels,
        handler_map={tuple: HandlerTuple(ndivide=1)},
        loc="upper center",
        bbox_to_anchor=(0.5, -0.14),
        ncols=2 if v0_1 else 3,
        frameon=False,
        fontsize=SMALL,
    )
