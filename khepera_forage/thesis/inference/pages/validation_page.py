"""The page that checks the inference before its result is used: can known laboratories be recovered?"""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from scipy import stats

from khepera_forage.estimates import Column, Table
from khepera_forage.figures import GREY, OURS, SMALL, WIDTH, grid, legend, new_figure
from khepera_forage.study import Page, Picture
from khepera_forage.thesis.inference.calibration import Calibration, Determined
from khepera_forage.thesis.inference.posterior import Posterior

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BINS = 10


def page(posterior: Posterior) -> Page:
    """Table and rank histograms."""
    named = {d: [c.name for c in posterior.calibrations if c.determined is d] for d in Determined}
    return Page(
        "Can the inference recover a laboratory that is known?",
        [
            f"{posterior.held_out} admissible sets were kept from the forest. One experiment of each stood in for the "
            "thesis: the same numbers of files and recalls, and the corridor's tables alone. The posterior was then "
            "compared with the set that had made the experiment.",
            "\n".join(
                [
                    f"- **Determined** by tables of this size: {_listed(named[Determined.YES])}.",
                    f"- Determined **a little**: {_listed(named[Determined.LITTLE])}.",
                    f"- **Not determined**: {_listed(named[Determined.NO])}. About these the tables say nothing that "
                    "this inference can find, whatever their values in the posterior.",
                ]
            ),
            _table(posterior.calibrations),
            Picture("ranks", "ranks of the true values in their posteriors", _picture(posterior)),
        ],
    )


def _listed(names: Sequence[str]) -> str:
    return ", ".join(f"`{name}`" for name in names) or "none"


def _table(calibrations: Sequence[Calibration]) -> Table:
    ordered = sorted(calibrations, key=lambda found: found.error.value)
    return Table(
        "calibration",
        "Calibration and error of each decision",
        "The posterior's error, divided by the error of guessing from the admissible sets: 1 or more means that the "
        "tables say nothing. The error is the continuous ranked probability score of a number, and Brier's score of a "
        "reading. `determined` is `yes` if the upper end of its interval is below 0.9, and `a little` if it is below "
        "1. The central 50 % and 90 % of a right posterior contain the true value in 50 % and 90 % of the sets. The "
        f"last column tests whether all ranks are equally frequent (chi-squared, {BINS} classes; among "
        f"{len(ordered)} tests, the smallest is expected to be about {1 / (len(ordered) + 1):.2f}).",
        (
            Column("decision or noise"),
            Column("determined"),
            Column("error / guess", 2, estimate=True),
            Column("within 50 % (%)", 0, estimate=True),
            Column("within 90 % (%)", 0, estimate=True),
            Column("p of equal ranks", 3),
        ),
        [
            (
                found.name,
                str(found.determined),
                found.error,
                type(found.half)(*(100 * value for value in found.half)),
                type(found.most)(*(100 * value for value in found.most)),
                _equal_ranks(found),
            )
            for found in ordered
        ],
    )


def _equal_ranks(found: Calibration) -> float:
    counts, _ = np.histogram(found.ranks, BINS, range=(0.0, 1.0))
    return float(stats.chisquare(counts).pvalue)


def _picture(posterior: Posterior) -> "Figure":
    calibrations, columns = posterior.calibrations, 5
    lines = math.ceil(len(calibrations) / columns)
    figure = new_figure(WIDTH, 0.8 + 1.2 * lines)
    axes = figure.subplots(lines, columns, sharex=True, sharey=True, squeeze=False)
    expected = posterior.held_out / BINS
    low, high = stats.binom.ppf([0.025, 0.975], posterior.held_out, 1 / BINS)
    for axis, found in zip(axes.flat, calibrations, strict=False):
        axis.hist(
            found.ranks, BINS, range=(0.0, 1.0), color=OURS, alpha=0.8, label="sets in a class of ranks"
        )
        axis.axhspan(
            low, high, color="0.85", zorder=0, lw=0, label="central 95 % if ranks are equally frequent"
        )
        axis.axhline(expected, color=GREY, linewidth=0.8, label="mean number of sets in a class")
        axis.set_title(found.name, fontsize=SMALL)
        axis.tick_params(labelsize=SMALL)
        axis.set_xticks((0, 0.5, 1), ("0", "0.5", "1"))
        grid(axis)
    for axis in axes.flat[len(calibrations) :]:
        axis.set_axis_off()
    figure.supylabel("sets", fontsize=9)
    legend(figure, axes[0, 0], "across: rank of the true value in its posterior, from 0 to 1")
    return figure
