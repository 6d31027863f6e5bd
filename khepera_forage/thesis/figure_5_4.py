"""Figure 5.4, measured: success by the place of the food in the corridor."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from khepera_forage.envs.arguments import checked_arena
from khepera_forage.estimates import Estimate, Floats, wilson
from khepera_forage.figures import GREY, OURS, SMALL, THESIS, WIDTH, mark, new_figure, padded
from khepera_forage.rollouts.rows import IMITATOR, RecallRow
from khepera_forage.rollouts.same_decisions import common_decisions
from khepera_forage.sim.arena import Arena
from khepera_forage.sim.arenas.thesis import CORRIDOR
from khepera_forage.thesis.design import training_distance
from khepera_forage.vision.scene import MM_PER_PIXEL

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.collections import QuadMesh
    from matplotlib.figure import Figure

TILE = 50.0
"""Approximate side of the map's tiles in mm."""
BIN = 8.0
"""Width of the curve's bins of distance from home, in pixels: 40 mm."""
_WHITE_TEXT_LIMIT = 55.0
"""Percent below which white text is legible on the map's colours."""
_ASIDE = 0.32
"""Share of a tile by which its number is moved away from a mark in the tile."""


def fig_5_4(recalls: Sequence[RecallRow]) -> "Figure":
    """A map of success by the food's place, and a curve of success by its distance from home.

    Args:
        recalls: Rows of the imitator in the corridor; other rows are ignored.

    Raises:
        ValueError: Rows of different decisions.
    """
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
    """For each non-empty bin of distance from home: its middle in pixels, number of food objects, and success."""
    bins = (np.hypot(foods[:, 0], foods[:, 1]) // BIN).astype(int)
    groups = [(i, foods[bins == i, 2]) for i in np.unique(bins)]
    return [(BIN * (i + 0.5), len(done), wilson(int(done.sum()), len(done))) for i, done in groups]


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
    for label, marker, size, at in (
        ("food in training", "*", 12, food),
        ("start in training", ">", 9, start),
    ):
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
        percent = Estimate(*(100 * value for value in share))
        mark(axes, MM_PER_PIXEL * middle, percent.value, percent, OURS)
    axes.plot([], [], "o-", color=OURS, ms=7, mec="white", label="ours with 95 % Wilson interval")
    axes.axvline(MM_PER_PIXEL * training, color=THESIS, lw=1.5, ls="--", label="food in training")
    axes.axvspan(0, corridor.home_radius, color=GREY, alpha=0.15, lw=0, label="home")
    axes.set_xlim(0, None)
    axes.set_ylim(*padded(0, 100))
    axes.set_xlabel("distance of the food from the centre of the home (mm)")
    axes.set_ylabel("food brought home (%)")
    axes.grid(axis="y", color="0.9")
    axes.set_axisbelow(True)
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.01), ncols=3, frameon=False, fontsize=SMALL)
