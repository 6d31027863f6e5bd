"""The noise table as a figure: scores and training attempts under each source of noise."""

import math
from typing import TYPE_CHECKING

from khepera_forage.estimates import UNKNOWN, Estimate, Table
from khepera_forage.figures import GREY, OURS, SMALL, WIDTH, mark, new_figure
from khepera_forage.thesis.design import NO_NOISE

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def noise_figure(table: Table) -> "Figure":
    """Draw the table of `noise_table`: a panel for each cell, and one for the attempts."""
    from matplotlib.lines import Line2D

    names = list(dict.fromkeys(str(row[0]) for row in table.rows))
    cells = list(dict.fromkeys(str(row[1]) for row in table.rows))
    panels = [
        (f"score (%)\n{cell} episodes", {str(r[0]): r[2] for r in table.rows if r[1] == cell})
        for cell in cells
    ]
    panels.append(("attempts per complete\ntraining episode", {str(row[0]): row[5] for row in table.rows}))
    figure = new_figure(WIDTH, 1.6 + 0.3 * len(names))
    columns = figure.subplots(1, len(panels), sharey=True)
    for axes, (label, estimates) in zip(columns, panels, strict=True):
        for place, name in enumerate(reversed(names)):
            estimate = estimates.get(name, UNKNOWN)
            assert isinstance(estimate, Estimate)
            mark(axes, estimate.value, place, estimate, OURS, level=True)
            if name == NO_NOISE and math.isfinite(estimate.value):
                axes.axvline(estimate.value, color=GREY, lw=1, ls=":", zorder=1)
        axes.set_xlabel(label, fontsize=9)
        axes.grid(axis="x", color="0.9")
        axes.set_axisbelow(True)
        axes.margins(x=0.08)
        axes.tick_params(labelsize=SMALL)
        axes.tick_params(axis="y", length=0)
    columns[0].set_yticks(range(len(names)), names[::-1])
    columns[0].set_ylim(-0.6, len(names) - 0.4)
    figure.suptitle("Effect of each source of noise")
    handles = [
        Line2D([], [], marker="o", color=OURS, ms=7, mec="white", label="mean and 95 % interval"),
        Line2D([], [], color=GREY, lw=1, ls=":", label="without noise"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=2, frameon=False, fontsize=SMALL)
    return figure
