"""The page of the test set: what was never fitted, and how much of it posterior and random sets predict."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from khepera_forage.estimates import Column, Estimate, Table, Value
from khepera_forage.figures import OURS, SMALL, grid, new_figure
from khepera_forage.study import Page, Picture
from khepera_forage.thesis.inference.pages.cells_page import Predictions, shown_statistics
from khepera_forage.thesis.inference.summary import FITTED, NAMES, SLOPES, thesis_statistics
from khepera_forage.thesis.inference.weighted import quantiles, rank

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]


def tested_columns() -> list[int]:
    """Places of the statistics of tables A.5 to A.7 that the thesis has."""
    return [k for k in shown_statistics() if (*NAMES, *SLOPES)[k] not in FITTED]


def predicted(statistics: Floats) -> NDArray[np.bool_]:
    """Whether the thesis's value lies within the central 95 % of a set's own experiments.

    With few experiments the central 95 % are those of a normal distribution with their mean and standard deviation.

    Args:
        statistics: Shape (sets, experiments, statistics); they may be missing.

    Returns:
        Shape (sets, statistics).
    """
    count = statistics.shape[1]
    known = np.isfinite(statistics)
    number = np.maximum(known.sum(axis=1), 1)
    mean = np.where(known, statistics, 0.0).sum(axis=1) / number
    squares = np.where(known, (statistics - mean[:, None]) ** 2, 0.0).sum(axis=1)
    deviation = np.sqrt(squares / np.maximum(number - 1, 1) * (1 + 1 / number))
    enough = 2 * known.sum(axis=1) >= count
    return np.asarray(enough & (np.abs(mean - thesis_statistics()) <= 1.96 * deviation))


def page(
    predictions: Predictions, statistics: NDArray[np.float32], weights: Floats, single: Sequence[Predictions]
) -> Page:
    """What is predicted of the rectangle's tables.

    Args:
        predictions: Of the posterior.
        statistics: Of all admissible sets, shape (sets, experiments, statistics).
        weights: The posterior, one a set.
        single: Of single sets: version 0.1 first, then the defaults if they are others.
    """
    columns = tested_columns()
    hits = predicted(statistics.astype(np.float64))[:, columns]
    counts = hits.sum(axis=1).astype(np.float64)
    own = {one.name: int(predicted(one.experiments[None])[0, columns].sum()) for one in single}
    return Page(
        "The test set: what was never fitted",
        [
            "Tables A.5 to A.7, of the rectangle, took no part in the inference. They are not unknown to us, though: "
            "before the inference was written, a manual exploration had looked at all seven cells, and the choice of "
            "alternatives and of summary statistics cannot be blind to that. [claims.md](claims.md) has the "
            "observations of sections 5.4.1.2 and 5.4.2.2, which were not fitted either.",
            _table(predictions, hits, weights),
            _counts(counts, weights, own, len(columns)),
            Picture(
                "test_set",
                "statistics that a set predicts",
                _picture(counts, weights, own, [one.colour for one in single]),
            ),
        ],
    )


def _table(predictions: Predictions, hits: NDArray[np.bool_], weights: Floats) -> Table:
    thesis, rows = thesis_statistics(), []
    for place, k in enumerate(tested_columns()):
        interval = predictions.interval(k)
        rows.append(
            (
                (*NAMES, *SLOPES)[k],
                float(thesis[k]),
                interval,
                rank(predictions.experiments[:, k], predictions.weights, float(thesis[k])),
                "yes" if interval.low <= thesis[k] <= interval.high else "no",
                100 * float(weights @ hits[:, place]),
                100 * float(hits[:, place].mean()),
            )
        )
    return Table(
        "test_set",
        "Statistics of the rectangle",
        "The posterior's median and, in brackets, its central 95 % for experiments of the thesis's size; the "
        "percentile of the thesis, and whether it lies in that interval. The last columns take sets one by one: the "
        "share whose own experiments include the thesis's value in their central 95 %.",
        (
            Column("statistic"),
            Column("thesis", 2),
            Column("posterior", 2, estimate=True),
            Column("percentile", 0),
            Column("predicted"),
            Column("posterior sets (%)", 0),
            Column("admissible sets (%)", 0),
        ),
        rows,
    )


def _counts(counts: Floats, weights: Floats, single: Mapping[str, int], number: int) -> Table:
    before = next(iter(single.values()))
    even = np.full(len(counts), 1 / len(counts))
    rows: list[tuple[Value, ...]] = []
    for name, own in (("posterior", weights), ("admissible, at random", even)):
        middle = Estimate(*quantiles(counts, own, (0.5, 0.025, 0.975)))
        rows.append((name, middle, *(100 * float(own @ (counts >= least)) for least in (before, number - 1))))
    rows += [(name, Estimate(count, np.nan, np.nan), np.nan, np.nan) for name, count in single.items()]
    return Table(
        "test_counts",
        "How many of them a set predicts",
        f"Of {number} statistics: median and, in brackets, the central 95 % over sets, and the share of sets that "
        "predict at least as many as version 0.1 does, or all but one.",
        (
            Column("sets"),
            Column("predicted", 0, estimate=True),
            Column("as many as version 0.1 (%)", 0),
            Column("all but one (%)", 0),
        ),
        rows,
    )


def _picture(counts: Floats, weights: Floats, single: Mapping[str, int], colours: Sequence[str]) -> "Figure":
    figure = new_figure(6.4, 3.2)
    axis = figure.subplots()
    bins = (np.arange(len(tested_columns()) + 2) - 0.5).tolist()
    axis.hist(
        counts, bins, weights=np.full(len(counts), 1 / len(counts)), color="0.8", label="admissible sets"
    )
    axis.hist(counts, bins, weights=weights, histtype="step", color=OURS, linewidth=1.5, label="posterior")
    for (name, count), colour in zip(single.items(), colours, strict=True):
        axis.axvline(count, color=colour, linestyle="--", label=name)
    axis.set_xticks(range(0, len(bins), 2))
    axis.set_xlabel(f"statistics of the rectangle that a set predicts, of {len(tested_columns())}")
    axis.set_ylabel("share of sets")
    axis.legend(frameon=False, fontsize=SMALL)
    grid(axis)
    return figure
