"""The pictures of the page."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from khepera_forage.estimates import pick
from khepera_forage.figures import (
    GREY,
    OURS,
    SMALL,
    THESIS,
    WIDTH,
    grid,
    legend,
    levels,
    new_figure,
)
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
    figure = new_figure(WIDTH, 3.2)
    panels = figure.subplots(1, len(RECALL_MEASURES), sharey=True)
    for axes, measure in zip(panels, RECALL_MEASURES, strict=True):
        own = pick(results, measure=measure.name)
        estimates = {f"{r.policy}, {r.arena}": (r.pymunk, r.virtual) for r in own}
        levels(axes, estimates, measure.name, ("pymunk alone", "virtual laboratory"), (THESIS, OURS))
        values = [v for pair in estimates.values() for estimate in pair for v in estimate if np.isfinite(v)]
        lowest, highest = min(0.0, *values), max(values)
        axes.set_xlim(lowest - 0.04 * (highest - lowest), highest + 0.06 * (highest - lowest))
        axes.tick_params(axis="y", length=0)
    legend(figure, panels[0], "bars: 95 % interval")
    return figure


def round_picture(rows: Sequence[TimedRound]) -> "Figure":
    """Mean times of the parts of a round, one after the other."""
    figure = new_figure(WIDTH, 3.0)
    panels = figure.subplots(2, 1)
    names = {LOCK_STEP: "lock-step", PACED: "wall clock,\n38400 baud"}
    for axes, (pace, name) in zip(panels, names.items(), strict=True):
        own = pick(rows, pace=pace)
        begin = 0.0
        for part, label in PARTS.items():
            mean = float(np.mean([getattr(row, part) for row in own]))
            axes.barh(0, mean, 0.5, begin, color=_COLOURS[part], ec="0.4", lw=0.4, label=label)
            begin += mean
        axes.set_yticks([0], [name])
        axes.tick_params(axis="y", length=0)
        axes.set_xlim(0, begin * 1.01)
    panels[1].set_xlabel("time of the parts of a round of two robots (ms, mean)")
    place = {"loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "columnspacing": 1.2}
    panels[0].legend(ncols=4, fontsize=SMALL, frameon=False, **place)
    return figure


def fault_picture(results: Sequence[FaultSums]) -> "Figure":
    """Shares of disturbed, lost and halted rounds, and their time."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    figure = new_figure(WIDTH, 3.4)
    first, second, third = figure.subplots(1, 3)
    for shade, rate in zip(_SHADES, RATES, strict=True):
        own = [result for fault in FAULTS for result in pick(results, fault=fault, rate=rate)]
        places = np.arange(len(own)) + (RATES.index(rate) - 1) * 0.27
        rounds = np.array([result.sum("rounds") for result in own])
        disturbed, halted = (
            100 * np.array([r.sum(name) for r in own]) / rounds for name in ("disturbed", "halted")
        )
        lost = 100 * np.array([len(result.lost) for result in own]) / rounds
        first.bar(places, disturbed, 0.25, color=shade)
        first.bar(places, lost, 0.25, color="none", edgecolor=THESIS, lw=1.5, hatch="////")
        second.bar(places, [result.ms_a_round for result in own], 0.25, color=shade)
        third.bar(places, halted, 0.25, color=shade)
    (undisturbed,) = pick(results, fault=NO_FAULT)
    second.axhline(undisturbed.ms_a_round, color=GREY, lw=1, ls="--")
    first.set_ylabel("rounds disturbed (%)", fontsize=9)
    second.set_ylabel("time of a round without pace (ms)", fontsize=9)
    third.set_ylabel("rounds in which a robot\nwas held or restarting (%)", fontsize=9)
    for axes in (first, second, third):
        axes.set_xticks(range(len(FAULTS)), FAULTS, rotation=90)
        axes.tick_params(labelsize=SMALL)
        grid(axes)
    handles: list[Patch | Line2D] = [
        Patch(color=shade, label=f"faults in {100 * rate:g} % of replies")
        for shade, rate in zip(_SHADES, RATES, strict=True)
    ]
    handles.append(Patch(fc="none", ec=THESIS, lw=1.5, hatch="////", label="rounds with a robot lost"))
    handles.append(Line2D([], [], color=GREY, lw=1, ls="--", label="without faults"))
    figure.legend(handles=handles, loc="outside upper center", ncols=3, frameon=False, fontsize=SMALL)
    return figure
