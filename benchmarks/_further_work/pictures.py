"""Curves of means with their intervals."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from _further_work.measures import Measure, RowT, amounts_of, conditions_of, mean, pick
from khepera_forage.thesis.figures import mark, new_figure
from khepera_forage.thesis.statistics import Estimate

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
"""Of Okabe and Ito, told apart by colour-blind readers."""
_CAPTION = "bars: 95 % interval over replications"


def panels(count: int, title: str) -> tuple["Figure", list["Axes"]]:
    """A figure with panels, two a line."""
    lines = math.ceil(count / 2)
    figure = new_figure(8.8, 1.2 + 3.2 * lines)
    axes = figure.subplots(lines, 2, squeeze=False)
    figure.suptitle(title)
    return figure, list(axes.flat)


def curves(
    axes: "Axes",
    rows: Sequence[RowT],
    measure: Measure[RowT],
    amount: str,
    rng: np.random.Generator,
    title: str = "",
    share: bool = True,
) -> None:
    """The mean of a measure against the amount, one curve a condition.

    Args:
        axes: Where.
        rows: All that are shown.
        measure: What is shown.
        amount: Label of the amounts.
        rng: Draws the resamples.
        title: Of the panel.
        share: Whether the measure goes from 0 to 100.
    """
    conditions, amounts = conditions_of(rows), amounts_of(rows, 0)
    places = {count: float(i) for i, count in enumerate(amounts)}
    for i, condition in enumerate(conditions):
        colour = COLOURS[i % len(COLOURS)]
        aside = 0.12 * (i - (len(conditions) - 1) / 2)
        points = [
            (places[count] + aside, mean(cell, measure, rng))
            for count in amounts
            if (cell := pick(rows, condition, count))
        ]
        axes.plot([x for x, _ in points], [e.value for _, e in points], color=colour, lw=1, label=condition)
        for x, estimate in points:
            mark(axes, x, estimate.value, estimate, colour)
    axes.set_xticks(range(len(amounts)), [str(count) for count in amounts])
    axes.set_xlim(-0.5, len(amounts) - 0.5)
    axes.set_xlabel(amount)
    axes.set_ylabel(measure.name)
    axes.set_title(title, fontsize=10)
    axes.grid(axis="y", color="0.9")
    axes.set_axisbelow(True)
    if share:
        axes.set_ylim(min(-4.0, axes.get_ylim()[0]), 104)  # scores go down to -20


def levels(
    axes: "Axes", estimates: Mapping[str, Sequence[Estimate]], names: Sequence[str], label: str
) -> None:
    """Estimates as level bars, several a line.

    Args:
        axes: Where.
        estimates: By the name of the line, one of each kind.
        names: Of the kinds.
        label: What is shown.
    """
    for place, line in enumerate(reversed(list(estimates.values()))):
        for i, estimate in enumerate(line):
            height = place + 0.24 * ((len(line) - 1) / 2 - i)
            mark(axes, estimate.value, height, estimate, COLOURS[i], level=True)
    for name, colour in zip(names, COLOURS, strict=False):
        axes.plot([], [], "o", color=colour, label=name)
    axes.set_yticks(range(len(estimates)), list(estimates)[::-1], fontsize=8)
    axes.set_ylim(-0.6, len(estimates) - 0.4)
    axes.set_xlabel(label)
    axes.grid(axis="x", color="0.9")
    axes.set_axisbelow(True)


def legend(figure: "Figure", axes: "Axes", columns: int = 4) -> None:
    """One legend below all panels."""
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(
        handles,
        labels,
        loc="outside lower center",
        ncols=columns,
        frameon=False,
        fontsize=8,
        title=_CAPTION,
        title_fontsize=8,
    )
