"""The page of the seven cells: thesis, version 0.1, and what the posterior predicts for experiments of that size."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.estimates import Column, Estimate, Table, Value, holm
from khepera_forage.figures import SMALL, THESIS, WIDTH, grid, legend, new_figure, padded
from khepera_forage.study import Page, Picture
from khepera_forage.thesis.inference.individual_recalls import INDIVIDUAL, IndividualRecalls, p_value
from khepera_forage.thesis.inference.summary import FITTED, NAMES, SLOPES, STATISTICS, thesis_statistics
from khepera_forage.thesis.inference.weighted import quantiles, rank

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]
CENTRAL = (0.5, 0.025, 0.975)
_LINES = ("--", "-.", ":")
"""Of the predictions; the thesis's lines are solid."""
LABELS = {
    "score": "score (%)",
    "food": "food (share)",
    "right_failed": "correct steps of\nfailed recalls (%)",
    "steps_successful": "median steps of recalls\nthat left no food",
}


class Predictions(NamedTuple):
    """What one or many laboratories predict for experiments of the thesis's size.

    Attributes:
        name: For headings.
        colour: For pictures.
        experiments: Statistics, shape (experiments, statistics); they may be missing.
        weights: One an experiment.
        recalls: Individual recalls of some of them, by arena.
    """

    name: str
    colour: str
    experiments: Floats
    weights: Floats
    recalls: dict[str, IndividualRecalls]

    def interval(self, column: int) -> Estimate:
        """Median and central 95 % of a statistic."""
        values = self.experiments[:, column]
        known = np.isfinite(values)
        if not self.weights[known].sum() > 0:
            return Estimate(np.nan, np.nan, np.nan)
        return Estimate(*quantiles(values[known], self.weights[known], CENTRAL))

    def means(self, columns: list[int]) -> Floats:
        """Means of some statistics over the experiments that have them."""
        values = self.experiments[:, columns]
        known = np.isfinite(values)
        weights = self.weights[:, None] * known
        return np.asarray((weights * np.where(known, values, 0.0)).sum(axis=0) / weights.sum(axis=0))


def page(predictions: list[Predictions], thesis: dict[str, IndividualRecalls]) -> Page:
    """A table and a picture of the cells, and individual recalls."""
    return Page(
        "The seven cells: thesis, and what laboratories predict",
        [
            _fit(predictions, thesis),
            _table(predictions),
            Picture("cells", "the seven cells", _cells(predictions)),
            Picture("recalls", "individual recalls", _recalls(predictions, thesis)),
        ],
    )


def shown_statistics() -> list[int]:
    """Places of the statistics that the thesis has."""
    return np.flatnonzero(np.isfinite(thesis_statistics())).tolist()


def _fit(predictions: list[Predictions], thesis: dict[str, IndividualRecalls]) -> Table:
    """How near each is to the thesis, in a few numbers."""
    rows: list[tuple[Value, ...]] = []
    values = thesis_statistics()
    means = [k for k, name in enumerate(NAMES) if name.endswith((" score", " food"))]
    inside = []
    for one in predictions:
        intervals = [one.interval(k) for k in means]
        inside.append(sum(i.low <= values[k] <= i.high for i, k in zip(intervals, means, strict=True)))
    rows.append((f"means of the thesis within the central 95 %, of {len(means)}", *inside))
    for statistic, words in (("score", "scores (points)"), ("food", "food (share)")):
        columns = [k for k in means if NAMES[k].endswith(f" {statistic}")]
        distances = [
            float(np.sqrt(np.mean((one.means(columns) - values[columns]) ** 2))) for one in predictions
        ]
        rows.append((f"root mean square difference of {words}", *distances))
    for arena in thesis:
        columns = [
            k for k, name in enumerate(NAMES) if name.startswith(arena) and name.endswith("right_failed")
        ]
        rows.append(
            (
                f"right steps of failed recalls (%), {arena}",
                *(float(one.means(columns).mean()) for one in predictions),
            )
        )
    for k, name in enumerate(SLOPES):
        rows.append((name, *(float(one.means([len(NAMES) + k])[0]) for one in predictions)))
    tests = [(arena, measure) for arena in thesis for measure in INDIVIDUAL]
    p_values = [
        holm([p_value(getattr(thesis[arena], m), getattr(one.recalls[arena], m)) for arena, m in tests])
        for one in predictions
    ]
    for place, (arena, measure) in enumerate(tests):
        label = f"p of individual recalls: {INDIVIDUAL[measure]}, {arena}"
        rows.append((label, *(found[place] for found in p_values)))
    return Table(
        "fit",
        "How near to the thesis",
        "The last lines test whether the thesis's individual recalls are from the same distribution (Kolmogorov and "
        f"Smirnov's distance, compared with that of whole experiments of ours; corrected for {len(tests)} tests by "
        "Holm's rule).",
        (Column("measure"), *(Column(one.name, 2) for one in predictions)),
        rows,
    )


def _table(predictions: list[Predictions]) -> Table:
    thesis, names = thesis_statistics(), (*NAMES, *SLOPES)
    rows = []
    for k in shown_statistics():
        row: list[str | float | Estimate] = [
            names[k],
            "fitted" if names[k] in FITTED else "test",
            float(thesis[k]),
        ]
        for one in predictions:
            row += [one.interval(k), rank(one.experiments[:, k], one.weights, float(thesis[k]))]
        rows.append(tuple(row))
    return Table(
        "cells",
        "All statistics",
        "Median and, in brackets, the central 95 % of experiments of the thesis's size, and the percentile of the "
        "thesis among them. Scores and shares of correct steps (`right`) are in percent, food is a share, `spread` is "
        "the standard deviation between training files, `slope` the change from the fewest training episodes to the "
        "most. Medians of steps are those of recalls that left no food. `test`: never fitted.",
        (
            Column("statistic"),
            Column("use"),
            Column("thesis", 2),
            *(
                column
                for one in predictions
                for column in (Column(one.name, 2, estimate=True), Column(f"percentile ({one.name})", 0))
            ),
        ),
        rows,
    )


def _cells(predictions: list[Predictions]) -> "Figure":
    thesis = thesis_statistics()
    figure = new_figure(WIDTH, 4.8)
    axes = figure.subplots(1, len(LABELS), sharey=True)
    cells = [name.removesuffix(f" {STATISTICS[0]}") for name in NAMES if name.endswith(f" {STATISTICS[0]}")]
    for axis, (statistic, label) in zip(axes, LABELS.items(), strict=True):
        columns = [NAMES.index(f"{cell} {statistic}") for cell in cells]
        for i, one in enumerate(predictions):
            _bars(axis, one, columns, 0.22 * (i - (len(predictions) - 1) / 2))
        axis.plot(thesis[columns], range(len(cells)), "D", color=THESIS, markersize=5, label="thesis")
        axis.set_xlabel(label, fontsize=9)
        axis.tick_params(labelsize=SMALL)
        grid(axis, "x")
    axes[0].set_yticks(range(len(cells)), [cell.replace(" ", ",\nepisodes: ") for cell in cells])
    axes[0].invert_yaxis()
    legend(figure, axes[0], "marks: medians; lines: central 95 % of experiments of the thesis's size")
    return figure


def _bars(axis: "Axes", one: Predictions, columns: list[int], shift: float) -> None:
    for place, column in enumerate(columns):
        middle, low, high = one.interval(column)
        height = place + shift
        axis.plot([low, high], [height, height], color=one.colour, linewidth=2, alpha=0.6)
        axis.plot(middle, height, "|", color=one.colour, markersize=7, label=one.name if not place else None)


def _recalls(predictions: list[Predictions], thesis: dict[str, IndividualRecalls]) -> "Figure":
    figure = new_figure(WIDTH, 5.2)
    axes = figure.subplots(len(thesis), len(INDIVIDUAL), squeeze=False)
    for line, (arena, own) in zip(axes, thesis.items(), strict=True):
        for axis, measure in zip(line, INDIVIDUAL, strict=True):
            for one, style in zip(predictions, _LINES, strict=False):
                _distribution(axis, getattr(one.recalls[arena], measure), one.colour, one.name, style)
            _distribution(axis, getattr(own, measure), THESIS, "thesis", "-")
            axis.set_xlabel(INDIVIDUAL[measure], fontsize=9)
            axis.set_title(arena, fontsize=9)
            axis.tick_params(labelsize=SMALL)
            axis.set_ylim(*padded(0, 1))
            grid(axis, "both")
        line[0].set_ylabel("share of recalls\nup to the value", fontsize=9)
    legend(figure, axes[0, 0])
    return figure


def _distribution(axis: "Axes", values: Floats, colour: str, name: str, style: str) -> None:
    axis.ecdf(values.ravel(), color=colour, label=name, linewidth=1.4, linestyle=style)
