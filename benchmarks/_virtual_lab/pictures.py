"""The outcome as pictures."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from _virtual_lab.compared import RECALL_MEASURES, Compared
from _virtual_lab.disturbances import Disturbance
from _virtual_lab.faults import NOTHING, RATES
from _virtual_lab.rounds import LOCK_STEP, PACED, PARTS, TimedRound
from khepera_forage.robots.virtual.faults import FAULTS
from khepera_forage.thesis.figures import GREY, OURS, THESIS, mark, new_figure

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLOURS = dict(
    zip(PARTS, ("#0072B2", "0.92", "#009E73", "#56B4E9", "#E69F00", "#D55E00", "#CC79A7"), strict=True)
)
"""Okabe and Ito; the wait is pale."""
_SHADES = ("#9ecae1", "#4292c6", "#08519c")
"""Of the rates, the more the darker."""


def recall_picture(results: Sequence[Compared]) -> "Figure":
    """Score, food and steps in both worlds."""
    figure = new_figure(9.2, 2.9)
    panels = figure.subplots(1, len(RECALL_MEASURES), sharey=True)
    names: list[str] = []
    for axes, measure in zip(panels, RECALL_MEASURES, strict=True):
        own = [result for result in results if result.measure == measure.name]
        names = [f"{result.who}, {result.arena}" for result in own]
        for place, result in enumerate(reversed(own)):
            mark(axes, result.pymunk.value, place - 0.15, result.pymunk, THESIS, level=True)
            mark(axes, result.virtual.value, place + 0.15, result.virtual, OURS, level=True)
        axes.set_xlabel(measure.name)
        lowest = min([0.0, *(v for r in own for v in (*r.pymunk, *r.virtual) if np.isfinite(v))])
        highest = max(v for r in own for v in (*r.pymunk, *r.virtual) if np.isfinite(v))
        axes.set_xlim(lowest - 0.04 * (highest - lowest), highest + 0.06 * (highest - lowest))
        axes.grid(axis="x", color="0.9")
        axes.tick_params(axis="y", length=0)
    panels[0].set_yticks(range(len(names)), names[::-1])
    panels[0].set_ylim(-0.6, len(names) - 0.4)
    _worlds(figure)
    return figure


def round_picture(rows: Sequence[TimedRound]) -> "Figure":
    """Mean times of the parts of a round, one after the other."""
    figure = new_figure(9.2, 2.6)
    panels = figure.subplots(2, 1)
    names = {LOCK_STEP: "lock-step", PACED: "wall clock,\n38400 baud"}
    for axes, (pace, name) in zip(panels, names.items(), strict=True):
        own = [row for row in rows if row.pace == pace]
        begin = 0.0
        for part, label in PARTS.items():
            mean = float(np.mean([getattr(row, part) for row in own]))
            axes.barh(0, mean, 0.5, begin, color=_COLOURS[part], label=label)
            begin += mean
        axes.set_yticks([0], [name])
        axes.tick_params(axis="y", length=0)
        axes.set_xlim(0, begin * 1.01)
    panels[1].set_xlabel("ms of a round of two robots (mean)")
    panels[0].legend(
        ncols=4, fontsize=8, frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1.0), columnspacing=1.2
    )
    return figure


def fault_picture(results: Sequence[Disturbance]) -> "Figure":
    """Rounds disturbed and lost, the time they took, and rounds in which wheels stood."""
    figure = new_figure(9.2, 3.2)
    first, second, third = figure.subplots(1, 3)
    by = {(result.fault, result.rate): result for result in results}
    for shade, rate in zip(_SHADES, RATES, strict=True):
        shift = (RATES.index(rate) - 1) * 0.27
        own = [by[fault, rate] for fault in FAULTS]
        places = np.arange(len(own)) + shift
        disturbed = [100 * r.disturbed / r.rounds for r in own]
        lost = [100 * r.losses / r.rounds for r in own]
        first.bar(places, disturbed, 0.25, color=shade, label=f"{100 * rate:g} % of replies")
        first.bar(places, lost, 0.25, color="none", edgecolor=THESIS, lw=1.5, hatch="////")
        second.bar(places, [1000 * r.seconds / r.rounds for r in own], 0.25, color=shade)
        third.bar(places, [100 * r.halted / r.rounds for r in own], 0.25, color=shade)
    plain = by[NOTHING, 0.0]
    second.axhline(1000 * plain.seconds / plain.rounds, color=GREY, lw=1, ls="--")
    first.set_ylabel("% of rounds disturbed\n(hatched: with a robot lost)")
    second.set_ylabel("ms a round, unpaced\n(dashed: undisturbed)")
    third.set_ylabel("% of rounds in which\na robot was held or restarting")
    for axes in (first, second, third):
        axes.set_xticks(range(len(FAULTS)), FAULTS, rotation=45, ha="right")
        axes.grid(axis="y", color="0.9")
        axes.set_axisbelow(True)
    figure.legend(loc="outside upper center", ncols=len(RATES), frameon=False, fontsize=9)
    return figure


def _worlds(figure: "Figure") -> None:
    from matplotlib.lines import Line2D

    figure.legend(
        handles=[
            Line2D([], [], marker="o", color=OURS, mec="white", ms=7, label="virtual laboratory"),
            Line2D([], [], marker="o", color=THESIS, mec="white", ms=7, label="pymunk alone"),
        ],
        loc="outside upper center",
        ncols=2,
        frameon=False,
        fontsize=9,
    )
