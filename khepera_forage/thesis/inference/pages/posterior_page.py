"""The page of the posterior: each decision before and after tables A.1 to A.4, and its influence on the outcome."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from khepera_forage.estimates import Column, Estimate, Table
from khepera_forage.figures import GREY, OURS, SMALL, WIDTH, legend, new_figure
from khepera_forage.study import Page, Picture
from khepera_forage.task.decisions import FIELDS
from khepera_forage.thesis.inference import sensitivity
from khepera_forage.thesis.inference.draw import Drawn
from khepera_forage.thesis.inference.parameters import Parameter
from khepera_forage.thesis.inference.posterior import Posterior
from khepera_forage.thesis.inference.weighted import effective_number, quantiles

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]
INTERVAL = (0.5, 0.05, 0.95)
UNITS = {name: field.unit for name, field in FIELDS.items()} | {
    "placement_error": "mm",
    "placement_heading_error": "degrees",
    "position_jitter": "pixels",
}
"""Units of decisions and of noise, for the picture."""


def page(drawn: Drawn, posterior: Posterior, seed: int, resamples: int = sensitivity.RESAMPLES) -> Page:
    """Marginals of the posterior, and Sobol' indices.

    Args:
        drawn: The sets.
        posterior: What is inferred from them.
        seed: Of the bootstrap of the indices.
        resamples: Number of bootstrap samples of the sets.
    """
    return Page(
        "What tables A.1 to A.4 say about each decision",
        [
            f"{len(posterior.weights) - posterior.held_out} admissible sets are weighted by their likeness to the "
            "corridor's tables. The weights count as much as "
            f"{effective_number(posterior.weights):.0f} sets of equal weight. "
            "[validation.md](validation.md) says how far to trust them, decision by decision.",
            _numbers(posterior),
            _readings(posterior),
            Picture("posterior", "admissible sets and posterior, decision by decision", _picture(posterior)),
            _influence(drawn, seed, resamples),
        ],
    )


def _numbers(posterior: Posterior) -> Table:
    even = np.full_like(posterior.weights, 1.0)
    rows = []
    for parameter, calibration in zip(posterior.parameters, posterior.calibrations, strict=True):
        if not parameter.readings:
            before, after = (
                Estimate(*quantiles(parameter.values, weights, INTERVAL))
                for weights in (even, posterior.weights)
            )
            rows.append((parameter.name, before, after, str(calibration.determined)))
    return Table(
        "posterior_numbers",
        "Numbers",
        "Median and, in brackets, the central 90 %, of the admissible sets and of the posterior.",
        (
            Column("decision or noise"),
            Column("admissible", 2, estimate=True),
            Column("posterior", 2, estimate=True),
            Column("determined"),
        ),
        rows,
    )


def _readings(posterior: Posterior) -> Table:
    rows = []
    for parameter, calibration in zip(posterior.parameters, posterior.calibrations, strict=True):
        shares = parameter.indicators
        for reading, before, after in zip(
            parameter.readings, shares.mean(axis=0), posterior.weights @ shares, strict=True
        ):
            rows.append(
                (
                    parameter.name,
                    str(reading),
                    100 * float(before),
                    100 * float(after),
                    str(calibration.determined),
                )
            )
    return Table(
        "posterior_readings",
        "Readings",
        "Probability of each reading, percent.",
        (
            Column("decision"),
            Column("reading"),
            Column("admissible (%)", 0),
            Column("posterior (%)", 0),
            Column("determined"),
        ),
        rows,
    )


def _picture(posterior: Posterior) -> "Figure":
    columns = 5
    lines = math.ceil(len(posterior.parameters) / columns)
    figure = new_figure(WIDTH, 0.8 + 1.35 * lines)
    axes = figure.subplots(lines, columns, squeeze=False)
    for axis, parameter in zip(axes.flat, posterior.parameters, strict=False):
        _panel(axis, parameter, posterior.weights)
    for axis in axes.flat[len(posterior.parameters) :]:
        axis.set_axis_off()
    legend(figure, axes[0, 0], "height: share of the sets; named readings have their numbers in the table")
    return figure


def _panel(axis: "Axes", parameter: Parameter, weights: Floats) -> None:
    """Histograms of one decision; of readings, their numbers in the order of the table."""
    count = len(parameter.readings)
    edges = np.arange(count + 1) - 0.5 if count else np.linspace(*_ends(parameter.values), 9)
    bins = edges.tolist()
    axis.hist(
        parameter.values,
        bins,
        weights=np.full(len(weights), 1 / len(weights)),
        color="0.8",
        label="admissible sets",
    )
    axis.hist(
        parameter.values, bins, weights=weights, histtype="step", color=OURS, linewidth=1.5, label="posterior"
    )
    unit = UNITS.get(parameter.name)
    axis.set_title(f"{parameter.name}\n({unit})" if unit else parameter.name, fontsize=SMALL)
    axis.tick_params(labelsize=SMALL)
    axis.locator_params(axis="x", nbins=4)
    axis.set_yticks([])
    if count:
        axis.set_xticks(range(count), [str(k + 1) for k in range(count)])
    for side in ("left", "right", "top"):
        axis.spines[side].set_visible(False)
    axis.spines["bottom"].set_color(GREY)


def _ends(values: Floats) -> tuple[float, float]:
    low, high = float(values.min()), float(values.max())
    return (low, high) if low < high else (low - 0.5, low + 0.5)


def _influence(drawn: Drawn, seed: int, resamples: int) -> Table:
    chance = np.random.default_rng(seed).random(len(drawn.admissible))
    parameters = [*drawn.parameters, Parameter("(a random number)", (), chance)]
    indices = [
        sensitivity.first_order(parameters, sensitivity.outcome(drawn.statistics, *outcome), seed, resamples)
        for outcome in sensitivity.OUTCOMES
    ]
    lines: list[tuple[str, Sequence[Estimate]]] = [
        (parameter.name, [_percent(index[k]) for index in indices]) for k, parameter in enumerate(parameters)
    ]
    lines.sort(key=lambda line: -sum(estimate.value for estimate in line[1]))
    return Table(
        "influence",
        "Influence of each decision on the outcome",
        "Sobol' indices of the first order, percent, with 95 % intervals: the share of the variance over the "
        "admissible sets that would vanish on average if this decision alone were known. Score and food are means "
        "over all cells of the arena. What the indices leave unexplained is due to combinations of decisions. The "
        "line of a random number shows what chance alone gives.",
        (
            Column("decision or noise"),
            *(Column(f"{arena} {measure}", 1, estimate=True) for arena, measure in sensitivity.OUTCOMES),
        ),
        [(name, *estimates) for name, estimates in lines],
    )


def _percent(estimate: Estimate) -> Estimate:
    return Estimate(*(100 * value for value in estimate))
