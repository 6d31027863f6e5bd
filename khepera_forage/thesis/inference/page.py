"""The page of the inference: what could have been, what the tables say about it, and what follows from that."""

import math
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy import stats

from khepera_forage.estimates import Estimate, Floats, Table, Value, table_of
from khepera_forage.figures import GREY, OURS, SMALL, WIDTH, grid, legend, new_figure
from khepera_forage.noise import Noise
from khepera_forage.study import Arguments, Page, Picture
from khepera_forage.task.decisions import FIELDS, Decisions
from khepera_forage.thesis.inference.claims import claim_table, measured
from khepera_forage.thesis.inference.posterior import (
    CLASSES,
    Posterior,
    PriorCheck,
    Told,
    central,
    effective_number,
    infer,
    quantiles,
    rank,
    shortest,
)
from khepera_forage.thesis.inference.prior import PRIOR, LabModel, PriorRange
from khepera_forage.thesis.inference.simulate import Drawn, Sets, replicate
from khepera_forage.thesis.inference.summary import ALL, FITTED, NAMES, fitted_columns, thesis_statistics

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

EXPERIMENTS, QUICK_EXPERIMENTS = 500, 4
"""Replications under the decisions of version 0.1, and under the defaults."""

PARTS, PERMUTATIONS, QUESTIONS = 5, 200, 3
"""Classes of a number, of equal weight; for the upper end of chance; questions that are asked."""
ENOUGH = 10 * PARTS
"""Fewest sets of equal weight from which the share that a decision explains can be told."""
MEANS = [k for k, name in enumerate(NAMES) if name.endswith((" score", " food"))]
"""Places of the fourteen means of the design."""
_NOISE_UNITS = {"placement_error": "mm", "placement_heading_error": "degrees", "position_jitter": "pixels"}


Predictions = Mapping[str, tuple[Floats, Floats]]
"""What one or many laboratories predict for experiments of the thesis's size, by name: their statistics, shape
(experiments, statistics), which may be missing; and the weight of each."""


def page(given: Arguments, drawn: Drawn) -> Page:
    """All tables of a full run, and pictures of the posterior and of its validation."""
    sets = drawn.sets
    posterior = infer(sets.parameters, sets.statistics, thesis_statistics()[fitted_columns()], given.seed)
    under = {"version 0.1": Decisions.v0_1()}
    if Decisions() != Decisions.v0_1():
        under["default"] = Decisions()
    each = QUICK_EXPERIMENTS if given.quick else EXPERIMENTS
    predictions = {
        name: (replicate(LabModel(own, Noise.laboratory()), given.seed, each), np.ones(each))
        for name, own in under.items()
    }
    _, experiments, width = drawn.statistics.shape
    weights = np.repeat(posterior.weights / experiments, experiments)
    predictions["posterior"] = drawn.statistics.reshape(-1, width).astype(np.float64), weights
    found = explained(posterior, drawn.statistics, np.random.default_rng(given.seed))
    asked = [_question(one.name) for one in found[:QUESTIONS] if np.isfinite(one.share)]
    questions = "".join(f"\n{k}. {question}" for k, question in enumerate(asked, 1))
    parts: list[str | Table | Picture] = [
        f"Questions to the author whose answers would tell most:\n{questions}"
        if asked
        else f"There are too few sets to say which questions to the author would tell most (needed: {ENOUGH} of equal "
        "weight).",
        _prior(),
        _reasons([reason or "admissible" for reason in drawn.reasons]),
        *posterior_parts(posterior, sets, given.quick),
        _cells(predictions, drawn.statistics, posterior.weights),
        claim_table(*measured(given, drawn.laboratories, posterior.weights)),
        _questions(found),
    ]
    return Page("Which decisions do the tables of the thesis support?", parts)


def tables_page(given: Arguments, sets: Sets, observed: Floats, name: str) -> Page:
    """What the fitted statistics of any experiment's tables say, from simulated sets that were kept."""
    posterior = infer(sets.parameters, sets.statistics, observed, given.seed)
    return Page(f"Which decisions do {name} support?", posterior_parts(posterior, sets))


def posterior_parts(posterior: Posterior, sets: Sets, quick: bool = False) -> list[str | Table | Picture]:
    """Prior predictive check, calibration and posterior; a warning also goes to standard error, unless `quick`."""
    names = {kind: [f"`{c.name}`" for c in posterior.calibrations if c.told is kind] for kind in Told}
    told = "; ".join(f"{kind}: {', '.join(own) or 'none'}" for kind, own in names.items())
    warning = posterior.check.warning
    if warning and not quick:
        print(f"khepera-forage: {warning}", file=sys.stderr)
    return [
        "Sets of decisions are weighted by their likeness to the corridor's tables. What do tables of this size say "
        f"about a decision? {told}.",
        *([f"**Warning:** {warning}"] if warning else []),
        _sizes(posterior, sets),
        _prior_check(posterior.check),
        _calibrations(posterior),
        Picture("ranks", "ranks of the true values in their posteriors", _ranks(posterior)),
        _numbers(posterior),
        _alternatives(posterior),
        Picture("posterior", "admissible sets and posterior, decision by decision", _marginals(posterior)),
    ]


def _prior() -> Table:
    rows: list[dict[str, Value]] = []
    for name, part in PRIOR.parts.items():
        if isinstance(part, PriorRange):
            values = f"{part.least:g} to {part.most:g}"
        else:
            values = "; ".join(f"{alternative} ({share:.0%})" for alternative, share in part.of.items())
        rows.append({"decision or noise": name, "values": values, "source": part.source})
    return table_of(
        "prior",
        "The prior",
        "Numbers are uniform in their range; alternatives have the probability in brackets. Everything else has the "
        "value of version 0.1, or the laboratory's noise. The ranges were written before anything was fitted, but for "
        "three whose end was a default, which were widened afterwards: `round_duration`, `jaw_travel_time` and "
        "`back_off_distance`; and `lowering_speed` was added when it proved to matter.",
        rows,
    )


def _reasons(reasons: Sequence[str]) -> Table:
    return table_of(
        "admissible",
        "Which sets are admissible",
        "A set is admissible if the teacher brings home at least 98 % of the food in both arenas, its fastest forage "
        "leaves room for the fastest recalls of the thesis (65 and 205 steps), it delivers in at most 1 % of forages "
        "with SEARCH in the place of ORIENT, and at least half of the attempts at a training episode are complete. "
        "The first reason counts. No learner is looked at.",
        [
            {"outcome": name, "sets": count, "share (%)": 100.0 * count / len(reasons)}
            for name, count in Counter(reasons).most_common()
        ],
    )


def _sizes(posterior: Posterior, sets: Sets) -> Table:
    count, experiments, _ = sets.statistics.shape
    check = posterior.check
    values: dict[str, Value] = {
        "sets drawn": sets.draws,
        "admissible sets": count,
        "experiments under each": experiments,
        "sets of equal weight that the posterior is worth": round(effective_number(posterior.weights)),
        "sets held out to validate it": posterior.held_out,
        "statistics of the tables": int(np.isfinite(check.ranks).sum()),
        "of these outside the central 95 % of simulated experiments": check.outside,
        "joint p": check.tail,
    }
    return table_of(
        "sizes",
        "How many sets, and do they resemble the tables?",
        "Joint p: the share of simulated experiments that are as far as the tables from their "
        f"{check.neighbours} nearest ones of other sets (mean distance in standard deviations).",
        [{"quantity": name, "value": value} for name, value in values.items()],
        {"value": 3},
    )


def _prior_check(check: PriorCheck) -> Table:
    return table_of(
        "prior_check",
        "Do the simulated experiments resemble the tables, statistic by statistic?",
        "Median and central 95 % of all simulated experiments, and the percentile of the tables among them.",
        [
            {
                "statistic": ALL[k],
                "simulated": interval,
                "percentile": place,
                "within 95 %": "" if np.isnan(place) else "yes" if 2.5 <= place <= 97.5 else "no",
            }
            for k, interval, place in zip(fitted_columns(), check.intervals, check.ranks.tolist(), strict=True)
        ],
        {"simulated": 2},
    )


def _calibrations(posterior: Posterior) -> Table:
    ordered = sorted(posterior.calibrations, key=lambda found: found.error.value)
    return table_of(
        "calibration",
        "Calibration and error of each decision",
        f"One experiment of each of {posterior.held_out} held-out sets stands in for the thesis. The posterior's "
        "error, divided by the error of guessing from the admissible sets: 1 or more means that the tables say "
        "nothing. The error is the continuous ranked probability score of a number, and Brier's score of an "
        "alternative. 50 % and 90 % intervals of a right posterior contain the true value in 50 % and 90 % of the "
        f"sets. The last column tests whether all ranks are equally frequent (chi-squared, {CLASSES} classes). "
        "The tables say `something` if the upper end of the error's interval is below 1, but are `not calibrated` if "
        f"that test fails after correction for {len(ordered)} tests (Holm, 5 %), or there are too few sets for it.",
        [
            {
                "decision or noise": c.name,
                "tables say": str(c.told),
                "error / guess": c.error,
                "within 50 % (%)": c.half,
                "within 90 % (%)": c.most,
                "p of equal ranks": c.equal_ranks,
            }
            for c in ordered
        ],
        {"error / guess": 2, "within 50 % (%)": 0, "within 90 % (%)": 0, "p of equal ranks": 3},
    )


def _panels(count: int, height: float, share: bool) -> tuple["Figure", list["Axes"]]:
    """A figure with five small panels a line."""
    lines = math.ceil(count / 5)
    figure = new_figure(WIDTH, 0.8 + height * lines)
    axes = figure.subplots(lines, 5, sharex=share, sharey=share, squeeze=False).ravel().tolist()
    for axis in axes[count:]:
        axis.set_axis_off()
    return figure, axes[:count]


def _ranks(posterior: Posterior) -> "Figure":
    figure, axes = _panels(len(posterior.calibrations), 1.2, share=True)
    expected = posterior.held_out / CLASSES
    low, high = stats.binom.ppf([0.025, 0.975], posterior.held_out, 1 / CLASSES)
    for axis, found in zip(axes, posterior.calibrations, strict=True):
        axis.hist(found.ranks, CLASSES, range=(0.0, 1.0), color=OURS, alpha=0.8, label="sets in a class of ranks")
        axis.axhspan(low, high, color="0.85", zorder=0, lw=0, label="central 95 % if ranks are equally frequent")
        axis.axhline(expected, color=GREY, linewidth=0.8, label="mean number of sets in a class")
        axis.set_title(found.name, fontsize=SMALL)
        axis.tick_params(labelsize=SMALL)
        axis.set_xticks((0, 0.5, 1), ("0", "0.5", "1"))
        grid(axis)
    figure.supylabel("sets", fontsize=9)
    legend(figure, axes[0], "across: rank of the true value in its posterior, from 0 to 1")
    return figure


def _numbers(posterior: Posterior) -> Table:
    even = np.ones_like(posterior.weights)
    rows: list[dict[str, Value]] = []
    for parameter, calibration in zip(posterior.parameters, posterior.calibrations, strict=True):
        if not parameter.alternatives:
            values = parameter.values
            before, after = (
                Estimate(quantiles(values, weights, (0.5,))[0], *shortest(values, weights, 0.9, parameter.ends))
                for weights in (even, posterior.weights)
            )
            own = float(getattr(Decisions() if parameter.name in FIELDS else Noise(), parameter.name))
            rows.append(
                {
                    "decision or noise": parameter.name,
                    "admissible": before,
                    "posterior": after,
                    "default": own,
                    "inside": "yes" if after.low <= own <= after.high else "no",
                    "tables say": str(calibration.told),
                }
            )
    return table_of(
        "posterior_numbers",
        "Numbers",
        "Median and, in brackets, the shortest interval with 90 % of the weight, of the admissible sets and of the "
        "posterior; it ends where the prior does if less than the weight of one set of equal weight lies beyond. The "
        "default, and whether it is in the posterior's interval.",
        rows,
        {"admissible": 2, "posterior": 2, "default": 2},
    )


def _alternatives(posterior: Posterior) -> Table:
    return table_of(
        "posterior_alternatives",
        "Alternatives",
        "Probability of each alternative, percent.",
        [
            {
                "decision": parameter.name,
                "alternative": str(alternative),
                "admissible (%)": 100 * float(before),
                "posterior (%)": 100 * float(after),
                "tables say": str(calibration.told),
            }
            for parameter, calibration in zip(posterior.parameters, posterior.calibrations, strict=True)
            for alternative, before, after in zip(
                parameter.alternatives,
                parameter.indicators.mean(axis=0),
                posterior.weights @ parameter.indicators,
                strict=True,
            )
        ],
        {"admissible (%)": 0, "posterior (%)": 0},
    )


def _marginals(posterior: Posterior) -> "Figure":
    """Histograms of each decision; of alternatives, their numbers in the order of the table."""
    figure, axes = _panels(len(posterior.parameters), 1.35, share=False)
    even = np.full(len(posterior.weights), 1 / len(posterior.weights))
    for axis, parameter in zip(axes, posterior.parameters, strict=True):
        values, count = parameter.values, len(parameter.alternatives)
        low, high = float(values.min()), float(values.max())
        ends = (low, high) if low < high else (low - 0.5, low + 0.5)
        bins = (np.arange(count + 1) - 0.5 if count else np.linspace(*ends, 9)).tolist()
        axis.hist(values, bins, weights=even, color="0.8", label="admissible sets")
        axis.hist(values, bins, weights=posterior.weights, histtype="step", color=OURS, lw=1.5, label="posterior")
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
    legend(figure, axes[0], "height: share of the sets; named alternatives have their numbers in the table")
    return figure


def predicted(statistics: Floats) -> NDArray[np.bool_]:
    """Whether the thesis's value lies within the central 95 % of a set's own experiments, shape (sets, statistics).

    One more experiment lies there with 95 %, if they are normally distributed (Student's t): the statistics of the
    experiments, shape (sets, experiments, statistics), are few. They may be missing.
    """
    count = statistics.shape[1]
    known = np.isfinite(statistics)
    number = np.maximum(known.sum(axis=1), 1)
    mean = np.where(known, statistics, 0.0).sum(axis=1) / number
    squares = np.where(known, (statistics - mean[:, None]) ** 2, 0.0).sum(axis=1)
    deviation = np.sqrt(squares / np.maximum(number - 1, 1) * (1 + 1 / number))
    enough = 2 * known.sum(axis=1) >= count
    reach = stats.t.ppf(0.975, np.maximum(number - 1, 1))
    return np.asarray(enough & (np.abs(mean - thesis_statistics()) <= reach * deviation))


def _cells(predictions: Predictions, statistics: NDArray[np.float32], weights: Floats) -> Table:
    thesis = thesis_statistics()
    hits = predicted(statistics.astype(np.float64))
    rows: list[dict[str, Value]] = []
    for k in np.flatnonzero(np.isfinite(thesis)).tolist():
        use = "fitted" if ALL[k] in FITTED else "test"
        row: dict[str, Value] = {"statistic": ALL[k], "use": use, "thesis": float(thesis[k])}
        for name, (experiments, own) in predictions.items():
            row[name] = central(experiments[:, k], own)
            row[f"percentile ({name})"] = rank(experiments[:, k], own, float(thesis[k]))
        row["posterior sets (%)"] = 100 * float(weights @ hits[:, k])
        row["admissible sets (%)"] = 100 * float(hits[:, k].mean())
        rows.append(row)
    shares = ("posterior sets (%)", "admissible sets (%)", *(f"percentile ({name})" for name in predictions))
    return table_of(
        "cells",
        "All statistics",
        "Median and, in brackets, the central 95 % of experiments of the thesis's size, and the percentile of the "
        "thesis among them. Scores and shares of correct steps (`right`) are in percent, food is a share, `spread` is "
        "the standard deviation between training files, `slope` the change from the fewest training episodes to the "
        "most. Medians of steps are those of recalls that left no food. `test`: never fitted. The last columns take "
        "sets one by one: the share whose own experiments include the thesis's value in their central 95 %.",
        rows,
        {"thesis": 2} | dict.fromkeys(predictions, 2) | dict.fromkeys(shares, 0),
    )


class Explained(NamedTuple):
    """Of one decision.

    Attributes:
        share: Of the posterior variance of the fourteen means that knowing it would remove on average; not a number
            with too few sets.
        chance: The largest share of 95 % of decisions without any influence.
    """

    name: str
    share: float
    chance: float


def explained(posterior: Posterior, statistics: NDArray[np.float32], rng: Generator) -> list[Explained]:
    """How much of the variance of the fourteen means each decision explains, most first; `rng` permutes classes."""
    if effective_number(posterior.weights) < ENOUGH:
        return [Explained(one.name, np.nan, np.nan) for one in posterior.parameters]
    used = posterior.weights > 0
    weights = posterior.weights[used] / posterior.weights.sum()
    means = np.asarray(statistics[used][:, :, MEANS].mean(axis=1), dtype=np.float64)
    centre = weights @ means
    variance = weights @ (means - centre) ** 2
    varies = variance > 1e-12 * (centre**2 + variance)
    means = (means - centre)[:, varies] / np.sqrt(variance[varies])
    found = []
    for one in posterior.parameters:
        if one.alternatives:
            classes = one.indicators[used]
        else:
            ends = quantiles(one.values[used], weights, [k / PARTS for k in range(1, PARTS)])
            places = np.searchsorted(ends, one.values[used])
            classes = np.asarray(places[:, None] == np.arange(PARTS), dtype=np.float64)
        # Weights and means stay together, so that chance includes what a few heavy sets can do.
        by_chance = [_between(rng.permutation(classes), weights, means) for _ in range(PERMUTATIONS)]
        share = _between(classes, weights, means)
        found.append(Explained(one.name, share, float(np.quantile(by_chance, 0.95))))
    return sorted(found, key=lambda one: one.chance - one.share)


def _between(classes: Floats, weights: Floats, means: Floats) -> float:
    """Variance between classes of outcomes that have mean 0 and variance 1, on average over outcomes; 0 without any."""
    if not means.size:
        return 0.0
    within = classes.T @ weights
    sums = (classes * weights[:, None]).T @ means
    return float((sums[within > 0] ** 2 / within[within > 0, None]).sum(axis=0).mean())


def _question(name: str) -> str:
    if name in FIELDS:
        return f"`{name}` (section {FIELDS[name].section}). {FIELDS[name].reason}"
    return f"`{name}`: how exactly were robots and food placed by hand, and seen by the camera?"


def _questions(found: Sequence[Explained]) -> Table:
    return table_of(
        "questions",
        "What knowing a decision would explain",
        "Share of the posterior variance of the fourteen means that the decision explains (correlation ratio; a number "
        f"is divided into {PARTS} classes of equal weight), and what 95 % of decisions without any influence stay "
        f"below, which is the upper end of chance. Needs {ENOUGH} sets of equal weight.",
        [
            {"decision or noise": one.name, "explained (%)": 100 * one.share, "by chance (%)": 100 * one.chance}
            for one in found
        ],
    )
