"""The figures of the report: figures 5.2 to 5.6 with the thesis's values and ours, and the effect of noise."""

import math
from collections import Counter
from collections.abc import Sequence
from itertools import product
from typing import TYPE_CHECKING

import numpy as np

from khepera_forage.envs.arguments import checked_arena
from khepera_forage.estimates import UNKNOWN, Estimate, Floats, Table, percent
from khepera_forage.figures import GREY, OURS, SMALL, THESIS, WIDTH, grid, levels, mark, new_figure, padded
from khepera_forage.rollouts.rows import IMITATOR, RecallRow, common_decisions
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.arenas.thesis import CORRIDOR, RECTANGLE
from khepera_forage.thesis.design import NO_NOISE, training_distance
from khepera_forage.thesis.tables import CellResult
from khepera_forage.vision.scene import MM_PER_PIXEL

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import QuadMesh
    from matplotlib.figure import Figure

BY_EPISODES = ((2, CORRIDOR, False), (3, CORRIDOR, True), (5, RECTANGLE, False), (6, RECTANGLE, True))
"""Figures of chapter 5 against the number of episodes: their number, arena, and whether of food or of scores."""
_BESIDE = 0.4
"""Horizontal distance, in episodes, between the marks of the thesis, ours, and those of version 0.1."""
_WIDTH = 0.36
"""Of a bar, in episodes."""
_PALE = 0.35
"""Opacity of bars."""


def figure_by_episodes(
    number: int, arena: str, food: bool, results: Sequence[CellResult], v0_1_results: Sequence[CellResult] = ()
) -> "Figure":
    """Scores, or the food carried home, against the number of training episodes: figures 5.2, 5.3, 5.5 and 5.6."""
    figure = new_figure(6.4, 4.4)
    axes = figure.subplots()
    axes.set_title(f"Figure 5.{number}: {'food carried home' if food else 'recall score'} in the {arena}")
    maximum = 20 if arena == CORRIDOR else 24
    own, old = ([r for r in some if r.cell.arena == arena] for some in (results, v0_1_results))
    for ours, result in (*product([False], old), *product([True], own)):
        x = result.cell.episodes - (_BESIDE if not ours else 0.0 if old else _BESIDE / 2)
        scale, colour = maximum / result.cell.available if food else 1.0, OURS if ours else GREY
        shown = result.food if food else result.score
        estimate = shown.ours.times(scale)
        mark(axes, x, estimate.value, estimate, colour)
        bars = [(x, estimate.value, colour)]
        if ours:
            _experiments(axes, x, [scale * value for value in shown.experiments], scale)
            beside, printed = x + _BESIDE, scale * shown.thesis
            axes.plot(beside, printed, "D", color=THESIS, ms=8, mec="white", zorder=4)
            bars.append((beside, printed, THESIS))
            if scale != 1:
                note = f"of {result.cell.available},\ntimes {scale:g}"
                axes.text(beside + 0.35, 0.2, note, va="bottom", fontsize=SMALL, color=GREY)
        for place, height, shade in bars if food else ():
            axes.bar(place, height, _WIDTH, color=shade, alpha=_PALE, zorder=1)
    # The multiple of ten, at most 0, below which no score is shown; penalties make scores negative (5.4).
    scores = [score for r in own for score in (*r.score.experiments, r.score.thesis)]
    scores += [score for r in (*own, *old) for score in r.score.ours]
    lowest = 0 if food else 10 * math.floor(min([0.0, *filter(math.isfinite, scores)]) / 10)
    highest, step = (maximum, 4) if food else (100, 10)
    axes.set_ylim(*padded(lowest, highest))
    axes.set_yticks(range(lowest, highest + 1, step))
    axes.set_ylabel(f"food objects carried home (of {maximum})" if food else "average score of recall episodes (%)")
    axes.set_xlabel("number of training episodes")
    axes.set_xlim(0, 12)
    axes.set_xticks((1, 3, 5, 10))
    grid(axes)
    _legend(axes, bool(v0_1_results), food)
    return figure


def _experiments(axes: "Axes", x: float, values: Sequence[float], step: float) -> None:
    """Draw single experiments as dots: the more have values in the same multiple of a step, the wider they spread."""
    classes = np.floor(np.asarray(values) / step + 1e-9).astype(int)
    counts = Counter(classes.tolist())
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

    def shown(colour: str, marker: str, size: float, line: str) -> "Line2D | tuple[Patch, Line2D]":
        drawn = Line2D([], [], marker=marker, color=colour, ls=line, ms=size, mec="white")
        return (Patch(color=colour, alpha=_PALE), drawn) if bars else drawn

    entries = {
        "thesis": shown(THESIS, "D", 8.0, ""),
        "ours, mean and 95 % interval": shown(OURS, "o", 7.0, "-"),
        "ours, single experiments (wider: more)": Line2D([], [], marker="o", color=OURS, ls="", ms=3, alpha=0.5),
    }
    if v0_1:
        entries["version 0.1, mean and 95 % interval"] = shown(GREY, "o", 7.0, "-")
    axes.legend(
        list(entries.values()),
        list(entries),
        handler_map={tuple: HandlerTuple(ndivide=1)},
        loc="upper center",
        bbox_to_anchor=(0.5, -0.14),
        ncols=2 if v0_1 else 3,
        frameon=False,
        fontsize=SMALL,
    )


TILE = 50.0
"""Approximate side of the map's tiles in mm."""
BIN = 8.0
"""Width of the curve's bins of distance from home, in pixels: 40 mm."""
_WHITE_TEXT_LIMIT = 55.0
"""Percent below which white text is legible on the map's colours."""
_ASIDE = 0.32
"""Share of a tile by which its number is moved away from a mark in the tile."""


def fig_5_4(recalls: Sequence[RecallRow]) -> "Figure":
    """A map of the imitator's success in the corridor by the food's place, and a curve by its distance from home."""
    decisions = common_decisions(recalls)
    corridor = checked_arena(CORRIDOR, decisions)
    foods = food_places(recalls)
    figure = new_figure(WIDTH, 6.6)
    upper, lower = figure.subplots(2, 1, height_ratios=(1.35, 1.0))
    _map(figure, upper, foods, corridor)
    _curve(lower, foods, corridor, training_distance(decisions))
    figure.suptitle("Figure 5.4: success by where the food lay in the corridor")
    return figure


def food_places(recalls: Sequence[RecallRow]) -> Floats:
    """One line for each food object in the imitator's recalls in the corridor: x, y in pixels, 1 if delivered."""
    rows = [row for row in recalls if (row.learner, row.arena) == (IMITATOR, CORRIDOR)]
    foods = [food for r in rows for food in zip(r.food_x, r.food_y, r.food_delivered, strict=True)]
    return np.array(foods, dtype=np.float64).reshape(-1, 3)


def success_by_distance(foods: Floats) -> list[tuple[float, int, Estimate]]:
    """For each non-empty bin of distance from home: middle (pixels), number of food objects, success (%)."""
    bins = (np.hypot(foods[:, 0], foods[:, 1]) // BIN).astype(int)
    groups = [(i, foods[bins == i, 2]) for i in np.unique(bins)]
    return [(BIN * (i + 0.5), len(done), percent(int(done.sum()), len(done))) for i, done in groups]


def _map(figure: "Figure", axes: "Axes", foods: Floats, corridor: Arena) -> None:
    """Draw the share of food brought home by tile of the floor, in mm from the centre of the home."""
    from matplotlib.patches import Circle, Rectangle

    home = corridor.home
    x1, y1, x2, y2 = (a - b for a, b in zip(corridor.bounds, (*home, *home), strict=True))
    edges = [np.linspace(a, b, round((b - a) / TILE) + 1) for a, b in ((x1, x2), (y1, y2))]
    x, y = MM_PER_PIXEL * foods[:, 0], MM_PER_PIXEL * foods[:, 1]
    counts = np.histogram2d(x, y, edges)[0]
    done = np.histogram2d(x, y, edges, weights=foods[:, 2])[0]
    share = np.ma.masked_array(100 * done / np.maximum(counts, 1), counts == 0)
    picture = axes.pcolormesh(*edges, share.T, cmap="cividis", vmin=0, vmax=100)
    axes.add_patch(Rectangle((x1, y1), x2 - x1, y2 - y1, fill=False, lw=2, clip_on=False, zorder=3))
    axes.add_patch(Circle((0, 0), corridor.home_radius, fill=False, lw=1.5, ls="--", label="home", zorder=2))
    food, start = ((at.x - home.x, at.y - home.y) for at in (corridor.foods[0], corridor.start))
    for label, marker, size, at in (("food in training", "*", 12, food), ("start in training", ">", 9, start)):
        axes.plot(*at, marker, color=THESIS, mec="white", ms=size, ls="", label=label, zorder=5)
    _numbers(axes, picture, edges, counts, share, (food, start))
    axes.set_aspect("equal")
    axes.set_xlim(x1, x2)
    axes.set_ylim(y1, y2)
    axes.set_xlabel("along the corridor, from the centre of the home (mm)")
    axes.set_ylabel("across (mm)")
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.01), ncols=3, frameon=False, fontsize=SMALL)
    bar = figure.colorbar(picture, ax=axes, shrink=0.8, aspect=15, pad=0.02)
    bar.set_label("food brought home (%)\nnumbers: food objects", fontsize=SMALL)
    bar.ax.tick_params(labelsize=SMALL)


def _numbers(
    axes: "Axes",
    picture: "QuadMesh",
    edges: Sequence[Floats],
    counts: Floats,
    share: "np.ma.MaskedArray",
    marks: Sequence[tuple[float, float]],
) -> None:
    """Write the number of food objects into each tile, away from marks and in front of lines."""
    from matplotlib.patheffects import withStroke

    x_edges, y_edges = edges
    for i, j in np.argwhere(counts > 0):
        (left, right), (bottom, top) = x_edges[i : i + 2], y_edges[j : j + 2]
        y = (bottom + top) / 2
        inside = [at for at in marks if left <= at[0] <= right and bottom <= at[1] <= top]
        if inside:
            y += _ASIDE * (top - bottom) * (-1 if inside[0][1] >= y else 1)
        axes.text(
            (left + right) / 2,
            y,
            f"{counts[i, j]:.0f}",
            ha="center",
            va="center",
            fontsize=SMALL,
            color="white" if share[i, j] < _WHITE_TEXT_LIMIT else "black",
            # A rim of the tile's colour keeps the number clear of the line around the home.
            path_effects=[withStroke(linewidth=3, foreground=picture.to_rgba(share[i, j]))],
            zorder=4,
        )


def _curve(axes: "Axes", foods: Floats, corridor: Arena, training: float) -> None:
    """Draw success by distance from home, with Wilson intervals."""
    for middle, _, share in success_by_distance(foods):
        mark(axes, MM_PER_PIXEL * middle, share.value, share, OURS)
    axes.plot([], [], "o-", color=OURS, ms=7, mec="white", label="ours with 95 % Wilson interval")
    axes.axvline(MM_PER_PIXEL * training, color=THESIS, lw=1.5, ls="--", label="food in training")
    axes.axvspan(0, corridor.home_radius, color=GREY, alpha=0.15, lw=0, label="home")
    axes.set_xlim(0, None)
    axes.set_ylim(*padded(0, 100))
    axes.set_xlabel("distance of the food from the centre of the home (mm)")
    axes.set_ylabel("food brought home (%)")
    grid(axes)
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.01), ncols=3, frameon=False, fontsize=SMALL)


def noise_figure(table: Table) -> "Figure":
    """Draw the table of `noise_table`: a panel for each cell, and one for the attempts; lines without result say so."""
    from matplotlib.lines import Line2D

    names = dict.fromkeys(str(row[0]) for row in table.rows)
    cells = dict.fromkeys(str(row[1]) for row in table.rows)
    panels = {
        f"score (%)\n{cell} episodes": {str(row[0]): row[2] for row in table.rows if row[1] == cell} for cell in cells
    }
    panels["attempts per complete\ntraining episode"] = {str(row[0]): row[5] for row in table.rows}
    figure = new_figure(WIDTH, 1.6 + 0.3 * len(names))
    columns = figure.subplots(1, len(panels), sharey=True)
    handles = [Line2D([], [], marker="o", color=OURS, ms=7, mec="white", label="mean and 95 % interval")]
    without = Line2D([], [], color=GREY, lw=1, ls=":", label="without noise")
    for axes, (label, values) in zip(columns, panels.items(), strict=True):
        estimates = {name: value for name, value in values.items() if isinstance(value, Estimate)}
        levels(axes, {name: [estimates.get(name, UNKNOWN)] for name in names}, label)
        noiseless = estimates.get(NO_NOISE, UNKNOWN).value
        if math.isfinite(noiseless):
            axes.axvline(noiseless, color=GREY, lw=1, ls=":", zorder=1)
            handles[1:] = [without]
        for place, name in enumerate(reversed(names)):
            if math.isnan(estimates.get(name, UNKNOWN).value):
                across = axes.get_yaxis_transform()
                axes.text(
                    0.5, place, "no complete training", transform=across, ha="center", va="center", fontsize=SMALL
                )
        axes.margins(x=0.08)
        axes.tick_params(labelsize=SMALL)
        axes.tick_params(axis="y", length=0)
    figure.suptitle("Effect of each source of noise")
    figure.legend(handles=handles, loc="outside lower center", ncols=2, frameon=False, fontsize=SMALL)
    return figure
