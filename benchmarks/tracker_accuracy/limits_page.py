"""The tables and the picture of the curves up to failure."""

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from khepera_forage.estimates import Column, Table, Value, percent, pick
from khepera_forage.figures import COLOURS, GREY, SMALL, WIDTH, grid, new_figure
from tracker_accuracy.lenses import DISTORTIONS, LAYOUTS, Trial
from tracker_accuracy.limits import SWEEPS, Point

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_FOUND = 98.0
"""Percent: the goal."""
_NOTE = (
    "Frames with 20 markers and 20 foods each. A cable crosses every marker anywhere, at any angle, slightly curved; "
    "no cable crosses the food. Every frame is read without tracks. Curves are in the picture. Stray: markers with a "
    "wrong number of holes or where there is none, and food where there is none, per 1000 markers. Warning: share of "
    "the frames for which `camera preview` names a setting to change. Shares with Wilson's 95 % interval."
)


def limits_table(points: Sequence[Point]) -> Table:
    """All points of all curves."""
    rows: list[tuple[Value, ...]] = [
        (
            p.sweep,
            p.curve,
            f"{p.value:g}",
            percent(p.markers, p.things),
            percent(p.foods, p.things),
            1000 * p.stray_markers / p.things,
            1000 * p.stray_foods / p.things,
            p.reversals,
            _known(p.position),
            _known(p.heading),
            100 * p.warned / p.frames,
        )
        for p in points
    ]
    columns = (
        Column("disturbance"),
        Column("curve"),
        Column("value"),
        Column("markers found (%)", estimate=True),
        Column("food found (%)", estimate=True),
        Column("stray markers (per 1000)"),
        Column("stray food (per 1000)"),
        Column("reversed", 0),
        Column("centre: 95 % (px)", 2),
        Column("heading: 95 % (deg)", 2),
        Column("warning (%)", 0),
    )
    return Table("limits", "Up to the point of failure", _NOTE, columns, rows)


def limits_picture(points: Sequence[Point], trials: Sequence[Trial]) -> "Figure":
    """Shares found as curves, one panel for each disturbance, and the errors of calibrations."""
    figure = new_figure(WIDTH, 13.0)
    panels = list(figure.subplots(5, 2).flat)
    for panel, (name, sweep) in zip(panels, SWEEPS.items(), strict=False):
        for colour, curve in zip(COLOURS, sweep.curves, strict=False):
            own = pick(points, sweep=name, curve=curve)
            values = [p.value for p in own]
            panel.plot(
                values, [100 * p.markers / p.things for p in own], "o-", ms=3, color=colour, label=curve
            )
            panel.plot(values, [100 * p.foods / p.things for p in own], ":", color=colour)
            warned = [(p.value, -4.0) for p in own if p.warned > p.frames / 2]
            if warned:
                panel.plot(*zip(*warned, strict=True), "^", ms=4, color=colour, clip_on=False)
        panel.axhline(_FOUND, color=GREY, lw=1, ls=(0, (1, 2)))
        panel.set_ylim(-7, 104)
        panel.set_xlabel(sweep.label)
        panel.set_ylabel("found (%)")
        panel.legend(fontsize=SMALL, frameon=False, loc="center left")
    _errors(panels[7], points)
    _lenses(panels[8], trials)
    for panel in panels[:9]:
        grid(panel, "both")
    panels[9].axis("off")
    lines = panels[8].get_legend_handles_labels()
    panels[9].legend(
        *lines, title="points of the calibration", loc="center left", fontsize=SMALL, frameon=False
    )
    figure.suptitle("Markers (lines) and food (dotted) found, as the picture becomes worse", fontsize=11)
    note = "triangles: a warning names the setting to change; grey line: the goal of 98 %"
    figure.supxlabel(note, fontsize=SMALL, color=GREY)
    return figure


def _errors(panel: "Axes", points: Sequence[Point]) -> None:
    """Errors of centres under cables of all widths."""
    for colour, curve in zip(COLOURS, SWEEPS["width"].curves, strict=False):
        own = pick(points, sweep="width", curve=curve)
        panel.plot(
            [p.value for p in own],
            [_known(p.position) for p in own],
            "o-",
            ms=3,
            color=colour,
            label=curve,
        )
    panel.set_ylim(0, 0.5)
    panel.set_xlabel(SWEEPS["width"].label)
    panel.set_ylabel("centre: 95 % within (pixels)")
    panel.legend(fontsize=SMALL, frameon=False)


def _lenses(panel: "Axes", trials: Sequence[Trial]) -> None:
    """Errors of calibrations by the lens's distortion."""
    lenses = [k1 for k1 in DISTORTIONS if pick(trials, k1=k1)]
    for colour, layout in zip(COLOURS, LAYOUTS, strict=False):
        errors = [np.median([t.error for t in pick(trials, layout=layout, k1=k1)]) for k1 in lenses]
        panel.plot([-k1 for k1 in lenses], errors, "o-", ms=3, color=colour, label=layout)
    panel.set_yscale("log")
    panel.set_ylim(1, 100)
    panel.set_xlabel("barrel distortion of the lens, -k1")
    panel.set_ylabel("error (mm)")


def _known(value: float | None) -> float:
    return math.nan if value is None else value
