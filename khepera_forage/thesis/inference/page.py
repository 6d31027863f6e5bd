"""The page of the inference: what could have been, what the tables say about it, and what follows from that."""

import math
import warnings
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy import stats

from khepera_forage.estimates import Column, Estimate, Table, Value
from khepera_forage.figures import GREY, OURS, SMALL, WIDTH, grid, legend, new_figure
from khepera_forage.noise import Noise
from khepera_forage.study import Arguments, Page, Picture
from khepera_forage.task.decisions import FIELDS, Decisions
from khepera_forage.thesis.design import ARENAS, THESIS
from khepera_forage.thesis.inference.claims import claim_tables, measured
from khepera_forage.thesis.inference.posterior import (
    Calibration,
    Determined,
    Floats,
    Parameter,
    Posterior,
    effective_number,
    infer,
    quantiles,
    rank,
)
from khepera_forage.thesis.inference.prior import PRIOR, Laboratory, Range
from khepera_forage.thesis.inference.simulate import Drawn, recalls_under
from khepera_forage.thesis.inference.summary import (
    FITTED,
    NAMES,
    SLOPES,
    of_recalls,
    thesis_statistics,
    with_slopes,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure

EXPERIMENTS, QUICK_EXPERIMENTS = 500, 4
"""Replications under the decisions of version 0.1, and under the defaults."""
QUICK_RESAMPLES = 10
INTERVAL, CENTRAL = (0.5, 0.05, 0.95), (0.5, 0.025, 0.975)
BINS = 10
"""Classes of ranks."""
PARTS, PERMUTATIONS, QUESTIONS = 5, 200, 3
"""Classes of a number, of equal weight; for the upper end of chance; questions that are asked."""


class Predictions(NamedTuple):
    """What one or many laboratories predict for experiments of the thesis's size.

    Attributes:
        name: For headings.
        experiments: Statistics, shape (experiments, statistics); they may be missing.
        weights: One an experiment.
    """

    name: str
    experiments: Floats
    weights: Floats

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


def page(given: Arguments, drawn: Drawn) -> Page:
    """All tables, and pictures of the posterior and of its validation."""
    posterior = infer(drawn.parameters, drawn.statistics, given.seed)
    single = [_predicted_under("version 0.1", Decisions.v0_1(), given)]
    if Decisions() != Decisions.v0_1():
        single.append(_predicted_under("default", Decisions(), given))
    sets, experiments, width = drawn.statistics.shape
    inferred = Predictions(
        "posterior",
        drawn.statistics.reshape(sets * experiments, width).astype(np.float64),
        np.repeat(posterior.weights / experiments, experiments),
    )
    named = {d: [c.name for c in posterior.calibrations if c.determined is d] for d in Determined}
    determined = "; ".join(
        f"{kind}: {', '.join(f'`{name}`' for name in names) or 'none'}" for kind, names in named.items()
    )
    rng = np.random.default_rng(given.seed)
    means = outcomes(drawn.statistics)
    found = [explained(parameter, posterior.weights, means, rng) for parameter in posterior.parameters]
    found.sort(key=lambda one: one.chance - one.share)
    parts: list[str | Table | Picture] = [
        f"{sets - posterior.held_out} admissible sets are weighted by their likeness to tables A.1 to A.4; the weights "
        f"count as much as {effective_number(posterior.weights):.0f} sets of equal weight. Do tables of this size "
        f"determine a decision? {determined}.",
        "Questions to the author whose answers would tell most:\n\n"
        + "\n".join(f"{k + 1}. {_question(one.name)}" for k, one in enumerate(found[:QUESTIONS])),
        _prior(),
        _reasons([row.reason or "admissible" for row in drawn.rows]),
        _calibrations(posterior.calibrations),
        Picture("ranks", "ranks of the true values in their posteriors", _ranks(posterior)),
        _numbers(posterior),
        _readings(posterior),
        Picture("posterior", "admissible sets and posterior, decision by decision", _marginals(posterior)),
        _influence(drawn, given.seed, QUICK_RESAMPLES if given.quick else RESAMPLES),
        _fit([*single, inferred]),
        _cells([*single, inferred]),
        *_test_set(inferred, drawn.statistics, posterior.weights, single),
        *claim_tables(*measured(given, drawn.laboratories, posterior.weights)),
        _questions(found),
    ]
    return Page("Which readings of the thesis do its own tables support?", parts)


def _predicted_under(name: str, decisions: Decisions, given: Arguments) -> Predictions:
    """Experiments under one set of decisions and the laboratory's noise."""
    count = QUICK_EXPERIMENTS if given.quick else EXPERIMENTS
    cells = recalls_under(Laboratory(decisions, Noise.laboratory()), given.seed, count)
    statistics = with_slopes([of_recalls(cell, own) for cell, own in zip(THESIS, cells, strict=True)])
    return Predictions(name, statistics, np.ones(count))


def _prior() -> Table:
    rows = []
    for name, part in (*PRIOR.decisions.items(), *PRIOR.noise.items()):
        if isinstance(part, Range):
            values = f"{part.least:g} to {part.most:g}"
        else:
            values = "; ".join(f"{reading} ({share:.0%})" for reading, share in part.of.items())
        rows.append((name, values, part.source))
    return Table(
        "prior",
        "The prior",
        "Numbers are uniform in their range; readings have the probability in brackets. Everything else has the "
        "value of version 0.1, or the laboratory's noise. The ranges were written before anything was fitted.",
        (Column("decision or noise"), Column("values"), Column("source")),
        rows,
    )


def _reasons(reasons: Sequence[str]) -> Table:
    counts = Counter(reasons)
    return Table(
        "admissible",
        "Which sets are admissible",
        "A set is admissible if the teacher brings home at least 98 % of the food in both arenas, its fastest forage "
        "leaves room for the fastest recalls of the thesis (65 and 205 steps), it delivers nothing with SEARCH in the "
        "place of ORIENT, and at least half of the attempts at a training episode are complete. The first reason "
        "counts. No learner is looked at.",
        (Column("outcome"), Column("sets"), Column("share (%)")),
        [(name, count, 100.0 * count / len(reasons)) for name, count in counts.most_common()],
    )


def _calibrations(calibrations: Sequence[Calibration]) -> Table:
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
                found.half,
                found.most,
                _equal_ranks(found),
            )
            for found in ordered
        ],
    )


def _equal_ranks(found: Calibration) -> float:
    counts, _ = np.histogram(found.ranks, BINS, range=(0.0, 1.0))
    return float(stats.chisquare(counts).pvalue)


def _ranks(posterior: Posterior) -> "Figure":
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


def _marginals(posterior: Posterior) -> "Figure":
    """Histograms of each decision; of readings, their numbers in the order of the table."""
    columns = 5
    lines = math.ceil(len(posterior.parameters) / columns)
    figure = new_figure(WIDTH, 0.8 + 1.35 * lines)
    axes = figure.subplots(lines, columns, squeeze=False)
    even = np.full(len(posterior.weights), 1 / len(posterior.weights))
    for axis, parameter in zip(axes.flat, posterior.parameters, strict=False):
        values, count = parameter.values, len(parameter.readings)
        low, high = float(values.min()), float(values.max())
        ends = (low, high) if low < high else (low - 0.5, low + 0.5)
        bins = (np.arange(count + 1) - 0.5 if count else np.linspace(*ends, 9)).tolist()
        axis.hist(values, bins, weights=even, color="0.8", label="admissible sets")
        axis.hist(
            values, bins, weights=posterior.weights, histtype="step", color=OURS, lw=1.5, label="posterior"
        )
        unit = FIELDS[parameter.name].unit if parameter.name in FIELDS else _NOISE_UNITS[parameter.name]
        axis.set_title(f"{parameter.name}\n({unit})" if unit else parameter.name, fontsize=SMALL)
        axis.tick_params(labelsize=SMALL)
        axis.locator_params(axis="x", nbins=4)
        axis.set_yticks([])
        if count:
            axis.set_xticks(range(count), [str(k + 1) for k in range(count)])
        for side in ("left", "right", "top"):
            axis.spines[side].set_visible(False)
        axis.spines["bottom"].set_color(GREY)
    for axis in axes.flat[len(posterior.parameters) :]:
        axis.set_axis_off()
    legend(figure, axes[0, 0], "height: share of the sets; named readings have their numbers in the table")
    return figure


_NOISE_UNITS = {"placement_error": "mm", "placement_heading_error": "degrees", "position_jitter": "pixels"}


OUTCOMES = tuple((arena, measure) for arena in ARENAS for measure in ("score", "food"))
RESAMPLES = 100
"""Number of bootstrap samples of the sets."""


def outcome(statistics: NDArray[np.float32], arena: str, measure: str) -> Floats:
    """Mean score (percent) or share of food in an arena, over its cells and all experiments; one a set."""
    columns = [k for k, name in enumerate(NAMES) if name.startswith(arena) and name.endswith(f" {measure}")]
    return np.asarray(statistics[:, :, columns].mean(axis=(1, 2)), dtype=np.float64)


def first_order(
    parameters: Sequence[Parameter], values: Floats, seed: int, resamples: int = RESAMPLES
) -> list[Estimate]:
    """Sobol' indices of the first order from the sets as they are, with bootstrapped 95 % intervals.

    Args:
        parameters: What was drawn.
        values: The outcome, one a set.
        seed: Of the bootstrap.
        resamples: Number of bootstrap samples of the sets.

    Raises:
        ImportError: SALib is not installed.
    """
    try:
        from SALib.analyze import delta
    except ImportError:
        raise ImportError(
            "sensitivity needs SALib, which is not installed: pip install 'khepera-forage[inference]'"
        ) from None
    problem: dict[str, Any] = {
        "num_vars": len(parameters),
        "names": [parameter.name for parameter in parameters],
        "bounds": [[parameter.values.min(), parameter.values.max()] for parameter in parameters],
    }
    inputs = np.stack([parameter.values for parameter in parameters], axis=1)
    state = np.random.get_state()  # noqa: NPY002 (SALib seeds numpy's global generator)
    try:
        with warnings.catch_warnings():  # SALib changes the filters of the whole process
            found = delta.analyze(
                problem, inputs, values, num_resamples=resamples, seed=seed + 1, method="sobol"
            )
    finally:
        np.random.set_state(state)  # noqa: NPY002
    return [
        Estimate(float(value), float(value - half), float(value + half))
        for value, half in zip(found["S1"], found["S1_conf"], strict=True)
    ]


def _influence(drawn: Drawn, seed: int, resamples: int) -> Table:
    chance = np.random.default_rng(seed).random(len(drawn.admissible))
    parameters = [*drawn.parameters, Parameter("(a random number)", (), chance)]
    indices = [
        first_order(parameters, outcome(drawn.statistics, arena, measure), seed, resamples)
        for arena, measure in OUTCOMES
    ]
    lines: list[tuple[str, Sequence[Estimate]]] = [
        (parameter.name, [Estimate(*(100 * value for value in index[k])) for index in indices])
        for k, parameter in enumerate(parameters)
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
            *(Column(f"{arena} {measure}", 1, estimate=True) for arena, measure in OUTCOMES),
        ),
        [(name, *estimates) for name, estimates in lines],
    )


def _fit(predictions: Sequence[Predictions]) -> Table:
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
    for arena in ARENAS:
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
    return Table(
        "fit",
        "How near to the thesis",
        "Means over experiments of the thesis's size.",
        (Column("measure"), *(Column(one.name, 2) for one in predictions)),
        rows,
    )


def shown_statistics() -> list[int]:
    """Places of the statistics that the thesis has."""
    return np.flatnonzero(np.isfinite(thesis_statistics())).tolist()


def _cells(predictions: Sequence[Predictions]) -> Table:
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


def _test_set(
    inferred: Predictions, statistics: NDArray[np.float32], weights: Floats, single: Sequence[Predictions]
) -> list[Table]:
    """What is predicted of the rectangle's tables, which were never fitted."""
    columns = tested_columns()
    hits = predicted(statistics.astype(np.float64))[:, columns]
    counts = hits.sum(axis=1).astype(np.float64)
    own = {one.name: int(predicted(one.experiments[None])[0, columns].sum()) for one in single}
    return [_tested(inferred, hits, weights), _counts(counts, weights, own, len(columns))]


def _tested(predictions: Predictions, hits: NDArray[np.bool_], weights: Floats) -> Table:
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


class Explained(NamedTuple):
    """Of one decision.

    Attributes:
        name: Of the field.
        share: Of the posterior variance of the fourteen means that knowing it would remove on average.
        chance: The largest share of 95 % of decisions without any influence.
    """

    name: str
    share: float
    chance: float


def outcomes(statistics: NDArray[np.float32]) -> Floats:
    """Mean score and share of food of each cell under each set, shape (sets, 14)."""
    columns = [k for k, name in enumerate(NAMES) if name.endswith((" score", " food"))]
    return np.asarray(statistics[:, :, columns].mean(axis=1), dtype=np.float64)


def explained(parameter: Parameter, weights: Floats, means: Floats, rng: Generator) -> Explained:
    """How much of the variance of the means a decision explains.

    Args:
        parameter: In all sets.
        weights: One a set.
        means: Shape (sets, outcomes).
        rng: Draws the permutations that show what chance explains.
    """
    used = weights > 0
    weights, means = weights[used] / weights.sum(), means[used]
    centre = weights @ means
    variance = weights @ (means - centre) ** 2
    varies = variance > 1e-12 * (centre**2 + variance)
    if not varies.any():
        return Explained(parameter.name, 0.0, 0.0)
    means = (means - centre)[:, varies] / np.sqrt(variance[varies])
    classes = _classes(parameter, used, weights)
    # Weights and means stay together, so that chance includes what a few heavy sets can do.
    by_chance = [_between(rng.permutation(classes), weights, means) for _ in range(PERMUTATIONS)]
    return Explained(parameter.name, _between(classes, weights, means), float(np.quantile(by_chance, 0.95)))


def _between(classes: Floats, weights: Floats, means: Floats) -> float:
    """Variance between classes of outcomes that have mean 0 and variance 1, on average over outcomes."""
    within = classes.T @ weights
    sums = (classes * weights[:, None]).T @ means
    return float((sums[within > 0] ** 2 / within[within > 0, None]).sum(axis=0).mean())


def _classes(parameter: Parameter, used: NDArray[np.bool_], weights: Floats) -> Floats:
    """Whether a set belongs to a class, 0 or 1; shape (sets, classes)."""
    if parameter.readings:
        return parameter.indicators[used]
    values = parameter.values[used]
    ends = quantiles(values, weights, [k / PARTS for k in range(1, PARTS)])
    return np.asarray(np.searchsorted(ends, values)[:, None] == np.arange(PARTS), dtype=np.float64)


def _question(name: str) -> str:
    if name in FIELDS:
        return f"`{name}` (section {FIELDS[name].section}). {FIELDS[name].reason}"
    return f"`{name}`: how exactly were robots and food placed by hand, and seen by the camera?"


def _questions(found: Sequence[Explained]) -> Table:
    return Table(
        "questions",
        "What knowing a decision would explain",
        "Share of the posterior variance of the fourteen means that the decision explains (correlation ratio; a number "
        f"is divided into {PARTS} classes of equal weight), and what 95 % of decisions without any influence stay "
        "below, which is the upper end of chance.",
        (Column("decision or noise"), Column("explained (%)"), Column("by chance (%)")),
        [(one.name, 100 * one.share, 100 * one.chance) for one in found],
    )
