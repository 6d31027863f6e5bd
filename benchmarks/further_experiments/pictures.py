"""Curves of means with their intervals."""

import textwrap
from collections.abc import Sequence
from typing import TYPE_CHECKING

from further_experiments.analysis import Analysis, RowT, amounts_of, conditions_of
from khepera_forage.estimates import Measure, pick
from khepera_forage.figures import COLOURS, MARKERS, entry, grid, mark

if TYPE_CHECKING:
    from matplotlib.axes import Axes

INTERVALS = "bars: 95 % interval over replications"
_LABEL = 30
"""Most characters in a line of the label beside a panel."""


def curves(
    axes: "Axes",
    found: Analysis,
    rows: Sequence[RowT],
    measure: Measure[RowT],
    amount: str,
    title: str = "",
    share: bool = True,
    amounts: Sequence[int] = (),
) -> None:
    """The mean of a measure against the amount, one curve a condition.

    Args:
        axes: Where.
        found: Draws the resamples.
        rows: All that are shown.
        measure: What is shown.
        amount: Label of the amounts.
        title: Of the panel.
        share: Whether the measure goes from 0 to 100.
        amounts: That are shown, with rows or without; empty for those that occur.
    """
    conditions, amounts = conditions_of(rows), amounts or amounts_of(rows, 0)
    places = {count: float(i) for i, count in enumerate(amounts)}
    for i, condition in enumerate(conditions):
        colour, marker = COLOURS[i % len(COLOURS)], MARKERS[i % len(MARKERS)]
        shift = 0.12 * (i - (len(conditions) - 1) / 2)
        points = [
            (places[count] + shift, found.mean(cell, measure))
            for count in amounts
            if (cell := pick(rows, condition=condition, amount=count))
        ]
        axes.plot([x for x, _ in points], [e.value for _, e in points], color=colour, lw=1)
        entry(axes, condition, colour, marker, "-")
        for x, estimate in points:
            mark(axes, x, estimate.value, estimate, colour, marker=marker)
    axes.set_xticks(range(len(amounts)), [str(count) for count in amounts])
    axes.set_xlim(-0.5, len(amounts) - 0.5)
    axes.set_xlabel(amount)
    axes.set_ylabel(textwrap.fill(measure.name, _LABEL))
    axes.set_title(title, fontsize=10)
    grid(axes)
    if share:
        axes.set_ylim(min(-4.0, axes.get_ylim()[0]), 104)  # scores go down to -20
    else:
        highest = max(1.0, axes.get_ylim()[1])
        axes.set_ylim(-0.03 * highest, highest)  # marks at 0 are shown whole
