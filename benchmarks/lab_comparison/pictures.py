"""The pictures of the page."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from khepera_forage.experiments.figures import GREY, OURS, THESIS, grid, legend, levels, new_figure
from khepera_forage.experiments.measures import pick
from khepera_forage.robots.virtual.faults import FAULTS
from lab_comparison.comparison import RECALL_MEASURES, Comparison
from lab_comparison.fault_sums import FaultSums
from lab_comparison.faults import NO_FAULT, RATES
from lab_comparison.rounds import LOCK_STEP, PACED, PARTS, TimedRound

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLOURS = dict(
    zip(PARTS, ("#0072B2", "0.92", "#009E73", "#56B4E9", "#E69F00", "#D55E00", "#CC79A7"), strict=True)
)
"""Okabe and Ito's; the wait is pale."""
_SHADES = ("#9ecae1", "#4292c6", "#08519c")
"""Of the rates, from low to high."""


def recall_picture(results: Sequence[Comparison]) -> "Figure":
    """Score, food and steps in both worlds."""
    figure = new_figure(9.2, 3.2)
    panels = figure.subplots(1, len(RECALL_MEASURES), sharey=True)
    for axes, measure in zip(panels, RECALL_MEASURES, strict=True):
        own = pick(results, measure=measure.name)
        estimates = {f"{r.policy}, {r.arena}": (r.pymunk, r.virtual) for r in own}
        levels(axes, estimates, measure.name, ("pymunk alone", "virtual laboratory"), (THESIS, OURS))
        values = [v for pair in estimates.values() for estimate in pair for v in estimate if np.isfinite(v)]
        lowest, highest = min(0.0, *values), max(values)
        axes.set_xlim(lowest - 0.04 * (highest - lowest), highest + 0.06 * (highest - lowest))
        axes.tick_params(axis="y", length=0)
    legend(figure, panels[0])
    return figure


def round_picture(rows: Sequence[TimedRound]) -> "Figure":
    """Mean times of the parts of a round, one after the other."""
    figure = new_figure(9.2, 2.6)
    panels = figure.subplots(2, 1)
    names = {LOCK_STEP: "lock-step", PACED: "wall clock,\n38400 baud"}
    for axes, (pace, name) in zip(panels, names.items(), strict=True):
        own = pick(rows, pace=pace)
        begin = 0.0
        for part, label in PARTS.items():
            mean = float(np.mean([getattr(row, part) for row in own]))
            axes.barh(0, mean, 0.5, begin, color=_COLOURS[part], label=label)
            begin += mean
        axes.set_yticks([0], [name])
        axes.tick_params(axis="y", length=0)
        axes.set_xlim(0, begin * 1.01)
    panels[1].set_xlabel("ms of a round of two robots (mean)")
    place = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "columnspacing": 1.2}
    panels[0].legend(ncols=4, fontsize=8, frameon=False, **place)
    return figure


def fault_picture(results: Sequence[FaultSums]) -> "Figure":
    """Shares of disturbed, lost and halted rounds, and their time."""
    figure = new_figure(9.2, 3.2)
    first, second, third = figure.subplots(1, 3)
    for shade, rate in zip(_SHADES, RATES, strict=True):
        own = [result for fault in FAULTS for result in pick(results, fault=fault, rate=rate)]
        places = np.arange(len(own)) + (RATES.index(rate) - 1) * 0.27
        rounds = np.array([result.sum("rounds") for result in own])
        disturbed, halted = (
            100 * np.array([r.sum(name) for r in own]) / rounds for name in ("disturbed", "halted")
        )
        lost = 100 * np.array([len(result.lost) for result in own]) / rounds
        first.bar(places, disturbed, 0.25, color=shade, label=f"{100 * rate:g} % of replies")
        first.bar(places, lost, 0.25, color="none", edgecolor=THESIS, lw=1.5, hatch="////")
        second.bar(places, [result.ms_a_round for result in own], 0.25, color=shade)
        third.bar(places, halted, 0.25, color=shade)
    (undisturbed,) = pick(results, fault=NO_FAULT)
    second.axhline(undisturbed.ms_a_round, color=GREY, lw=1, ls="--")
    first.set_ylabel("% of rounds disturbed\n(hatched: with a robot lost)")
    second.set_ylabel("ms a round, without pace\n(dashed: undisturbed)")
    third.set_ylabel("% of rounds in which\na robot was held or restarting")
    for axes in (first, second, third):
        axes.set_xticks(range(len(FAULTS)), FAULTS, rotation=45, ha="right")
        grid(axes)
    figure.legend(loc="outside upper center", ncols=len(RATES), frameon=False, fontsize=9)
    return figure
