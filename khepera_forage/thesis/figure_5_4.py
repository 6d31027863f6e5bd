"""Figure 5.4, measured: success by the place of the food in the corridor."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from khepera_forage.envs.arguments import checked_arena
from khepera_forage.experiments.figures import GREY, OURS, THESIS, mark, new_figure
from khepera_forage.experiments.statistics import Estimate, Floats, wilson
from khepera_forage.rollouts.rows import IMITATOR, RecallRow
from khepera_forage.rollouts.same_decisions import common_decisions
from khepera_forage.sim.arena import CORRIDOR, Arena
from khepera_forage.thesis.design import training_distance
from khepera_forage.vision.scene import MM_PER_PIXEL

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

TILE = 50.0
"""Approximate side of the map's tiles in mm."""
BIN = 8.0
"""Width of the curve's bins of distance from home, in pixels: 40 mm."""
_WHITE_TEXT_LIMIT = 55.0
"""Percent below which white text is legible on the map's colours."""


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
    figure = new_figure(11.0, 3.9)
    left, right = figure.subplots(1, 2, width_ratios=(1.9, 1.0))
    _map(figure, left, foods, corridor)
    _curve(right, foods, corridor, training_distance(decisions))
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
    for i, j in np.argwhere(counts > 0):
        axes.text(
            edges[0][i : i + 2].mean(),
            edges[1][j : j + 2].mean(),
            f"{counts[i, j]:.0f}",
            ha="center",
            va="center",
            fontsize=7,
            color="white" if share[i, j] < _WHITE_TEXT_LIMIT else "black",
        )
    axes.add_patch(Rectangle((x1, y1), x2 - x1, y2 - y1, fill=False, lw=2, clip_on=False))
    axes.add_patch(Circle((0, 0), corridor.home_radius, fill=False, lw=1.5, ls="--"))
    axes.text(0, 0, "home", ha="center", va="center", fontsize=9)
    marks = (("food in training", "*", corridor.foods[0]), ("start in training", ">", corridor.start))
    for label, marker, place in marks:
        at = (place.x - home.x, place.y - home.y)
        axes.plot(*at, marker, mfc="none", mec=THESIS, mew=2, ms=20, label=label)
    axes.set_aspect("equal")
    axes.set_xlim(x1, x2)
    axes.set_ylim(y1, y2)
    axes.set_xlabel("along the corridor, from the centre of the home (mm)")
    axes.set_ylabel("across (mm)")
    figure.legend(loc="outside lower left", ncols=2, frameon=False, fontsize=8, markerscale=0.6)
    bar = figure.colorbar(picture, ax=axes, location="top", shrink=0.5, aspect=30)
    bar.set_label("food brought home (%); numbers: food objects", fontsize=9)
    bar.ax.tick_params(labelsize=8)


def _curve(axes: "Axes", foods: Floats, corridor: Arena, training: float) -> None:
    """Draw success by distance from home, with Wilson intervals."""
    for middle, _, share in success_by_distance(foods):
        mark(axes, middle, 100 * share.value, Estimate(*(100 * value for value in share)), OURS)
    axes.axvline(training, color=THESIS, lw=1.5, ls="--")
    axes.text(training, 101, "training", color=THESIS, ha="center", va="bottom", fontsize=8)
    radius = corridor.home_radius / MM_PER_PIXEL
    axes.axvspan(0, radius, color=GREY, alpha=0.15, lw=0)
    axes.text(radius / 2, 50, "home", color=GREY, ha="center", va="center", fontsize=8)
    axes.set_xlim(0, None)
    axes.set_ylim(0, 100)
    axes.set_xlabel("distance of the food from home (pixels of 5 mm)\nbars: 95 % Wilson intervals")
    axes.set_ylabel("food brought home (%)")
    axes.grid(axis="y", color="0.9")
    axes.set_axisbelow(True)
