"""The outcome as tables and as a picture."""

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from _tracker.measures import errors, jitter, losses, relabelled, share
from _tracker.sights import BARE, KINDS, MODEL, TRACKER, Sight
from khepera_forage.noise import Noise
from khepera_forage.thesis.figures import GREY, OURS, THESIS, mark, new_figure
from khepera_forage.thesis.statistics import Estimate
from khepera_forage.thesis.tables import Column, Table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Looks = Mapping[str, tuple[Sequence[Sight], int]]
"""Sights of random scenes, and regions of nothing, by condition."""

COLOURS = {TRACKER: OURS, MODEL: THESIS, BARE: GREY}
_NAN = math.nan


def speed_table(tracked: Sequence[float], rendered: Sequence[float], frames: int) -> Table:
    """Frames a second."""
    rows = [
        (name, float(np.median(rates)), min(rates), max(rates), goal)
        for name, rates, goal in (("tracker", tracked, "at least 500"), ("renderer", rendered, ""))
    ]
    columns = (
        Column("part"),
        Column("frames/s", 0),
        Column("lowest", 0),
        Column("highest", 0),
        Column("goal"),
    )
    note = (
        f"One thread, by its processor time, {frames} frames of a training; median, lowest and highest of "
        f"{len(tracked)} repeats."
    )
    return Table("tracker_speed", "Speed", note, columns, rows)


def accuracy_table(looks: Looks) -> Table:
    """How well single frames are read, by look and kind."""
    rows = []
    for name, (sights, phantoms) in looks.items():
        for kind in KINDS:
            own = [row for row in sights if row.kind == kind]
            seen = errors(own)
            crossed = [row for row in own if row.cable]
            centre = np.percentile(seen.centre, (50, 99)).tolist() if len(seen.centre) else (_NAN, _NAN)
            heading = np.percentile(seen.heading, (50, 99)).tolist() if len(seen.heading) else (_NAN, _NAN)
            markers = kind != KINDS[0]
            rows.append(
                (
                    name,
                    kind,
                    len(own),
                    share(sum(row.found for row in own), len(own)),
                    len(crossed),
                    share(sum(row.found for row in crossed), len(crossed)),
                    *centre,
                    share(int((seen.centre <= 1).sum()), len(seen.centre)),
                    *heading,
                    share(int((seen.heading <= 3).sum()), len(seen.heading) + seen.reversals)
                    if markers
                    else Estimate(_NAN, _NAN, _NAN),
                    seen.reversals,
                    phantoms if kind == KINDS[0] else "",
                )
            )
    columns = (
        Column("look"),
        Column("region"),
        Column("frames"),
        Column("found (%)", estimate=True),
        Column("under a cable"),
        Column("found there (%)", estimate=True),
        Column("centre: median (px)", 2),
        Column("99 % (px)", 2),
        Column("within 1 px (%)", estimate=True),
        Column("heading: median (deg)", 2),
        Column("99 % (deg)", 2),
        Column("within 3 deg (%)", estimate=True),
        Column("reversed"),
        Column("regions of nothing"),
    )
    note = (
        "Random scenes all over the picture, two markers and two foods each, nothing hidden by a marker, cables from "
        "anywhere; every frame is read on its own, without tracks. The same scenes for every look. Errors are those of "
        "the regions found, which are those within 6 pixels of a thing of their kind; headings are reported in whole "
        "degrees. Shares with Wilson's 95 % interval."
    )
    return Table("tracker_accuracy", "Single frames", note, columns, rows)


def model_table(drives: Sequence[Sight], phantoms: Mapping[str, int]) -> Table:
    """The simulated camera beside the tracker, in the figures of `Noise`."""
    noise = Noise.laboratory()
    by = {camera: [row for row in drives if row.camera == camera] for camera in (MODEL, TRACKER, BARE)}
    rows: list[tuple[str | float | Estimate, ...]] = []

    def add(name: str, figure: str | float, *values: str | float | Estimate) -> None:
        rows.append((name, figure, *values))

    for place, (name, figure) in enumerate(
        (("position_jitter (px)", noise.position_jitter), ("heading_jitter (deg)", noise.heading_jitter))
    ):
        for kind in KINDS if place == 0 else KINDS[1:]:
            add(f"{name}, {kind}", figure, *(_plain(jitter(_of(by[c], kind))[place]) for c in by))
    add("reversal_rate", noise.reversal_rate, *(_reversals(by[c]) for c in by))
    for kind, figure in zip(
        KINDS, (noise.loss_rate_food, noise.loss_rate_one_hole, noise.loss_rate_two_holes), strict=True
    ):
        add(f"loss rate, {kind}", figure, *(losses(_of(by[c], kind), cable=False).rate for c in by))
    for kind in KINDS:
        add(f"loss rate under a cable, {kind}", "", *(losses(_of(by[c], kind), cable=True).rate for c in by))
    add("cable_loss_factor", noise.cable_loss_factor, *(_plain(_factor(by[c])) for c in by))
    add("loss_rounds", noise.loss_rounds, *(_length(by[c]) for c in by))
    hidden = [[row for row in by[c] if not row.clear] for c in by]
    add(
        "food near a marker found (%)", "", *(share(sum(r.found for r in rows), len(rows)) for rows in hidden)
    )
    add("labels that changed things", "", *(_plain(_NAN if c == BARE else relabelled(by[c])) for c in by))
    add("regions of nothing, a round", "", *(_plain(phantoms[c] / max(1, _rounds(by[c]))) for c in by))
    add("rounds", "", *(_plain(_rounds(by[c])) for c in by))
    columns = (
        Column("quantity"),
        Column("Noise.laboratory()", 4),
        Column("model, measured", 4, estimate=True),
        Column("tracker on rendered frames", 4, estimate=True),
        Column("bare threshold on them", 4, estimate=True),
    )
    note = (
        "Trainings in simulation, watched by all cameras under the same cables' anchor, a frame a round; the first "
        "two columns are what the model was told and what the same measurement makes of it; the bare threshold reads "
        "contours and holes as they come, and mends nothing. Jitter: standard deviation "
        "of the error along an axis, of things nothing hides; that of headings has in it the rounding to whole degrees "
        "(0.29), which comes after the model's figure. Loss rate: a round; things hidden by a marker do not count. "
        "Shares and rates with Wilson's 95 % interval, loss_rounds with the 5th and 95th percentile."
    )
    return Table("tracker_model", "The simulated camera and the tracker", note, columns, rows)


def picture(looks: Looks, laboratory: str, drives: Sequence[Sight]) -> "Figure":
    """Errors of both cameras as curves, and loss rates with and without a cable."""
    figure = new_figure(10.5, 4.0)
    left, middle, right = figure.subplots(1, 3)
    styles = dict(zip(KINDS, (":", "-", "--"), strict=True))
    for camera, colour in COLOURS.items():
        for kind, style in styles.items():
            seen = errors(row for row in drives if row.camera == camera and row.kind == kind)
            for axes, values in ((left, seen.centre), (middle, seen.heading)):
                if len(values):
                    tail = 1 - np.arange(len(values)) / len(values)
                    axes.step(
                        np.sort(values), tail, color=colour, ls=style, lw=1.4, label=f"{camera}, {kind}"
                    )
    for axes, limit, name in (
        (left, 1.0, "centre off by more than (pixels)"),
        (middle, 3.0, "heading off by more than (deg)"),
    ):
        axes.set_yscale("log")
        axes.set_ylim(1e-4, 1.2)
        axes.axvline(limit, color=GREY, lw=1, ls=(0, (1, 2)))
        axes.axhline(0.01, color=GREY, lw=1, ls=(0, (1, 2)))
        axes.set_xlabel(name)
        axes.set_xlim(0, 2.5 * limit)
    left.set_ylabel("share of found regions")
    left.legend(fontsize=7, frameon=False)
    names = []
    for place, (kind, cable) in enumerate((kind, cable) for kind in KINDS for cable in (False, True)):
        names.append(f"{kind}{', cable' if cable else ''}")
        for shift, camera in ((0.22, TRACKER), (0.0, MODEL), (-0.22, BARE)):
            own = [row for row in drives if row.camera == camera and row.kind == kind]
            rate = losses(own, cable).rate
            mark(
                right,
                1000 * rate.value,
                place + shift,
                Estimate(*(1000 * v for v in rate)),
                COLOURS[camera],
                level=True,
            )
    right.set_yticks(range(len(names)), names, fontsize=8)
    right.set_xscale("symlog", linthresh=1)
    right.set_xlim(left=0)
    right.set_xlabel("losses in 1000 rounds")
    for axes in (left, middle, right):
        axes.grid(color="0.92")
    figure.suptitle(
        "The tracker on rendered frames (blue), the simulated camera (vermilion), a bare threshold (grey)",
        fontsize=11,
    )
    scenes = len({row.frame for row in looks[laboratory][0]})
    figure.supxlabel(
        f"trainings in simulation; single frames: {scenes} random scenes a look", fontsize=8, color=GREY
    )
    return figure


def _of(rows: Sequence[Sight], kind: str) -> list[Sight]:
    return [row for row in rows if row.kind == kind]


def _plain(value: float) -> Estimate:
    """A value without an interval."""
    return Estimate(value, _NAN, _NAN)


def _reversals(rows: Sequence[Sight]) -> Estimate:
    seen = errors(row for row in rows if row.kind != KINDS[0])
    read = seen.reversals + len(seen.heading)
    if read == 0:
        return _plain(_NAN)
    whole = share(seen.reversals, read)
    return Estimate(*(max(0.0, value / 100) for value in whole))


def _factor(rows: Sequence[Sight]) -> float:
    """How many times likelier a loss is under a cable, over all kinds."""
    clear, under = losses(rows, cable=False).rate.value, losses(rows, cable=True).rate.value
    return under / clear if clear else _NAN


def _length(rows: Sequence[Sight]) -> Estimate:
    lengths = [n for cable in (False, True) for n in losses(rows, cable).lengths]
    if not lengths:
        return Estimate(_NAN, _NAN, _NAN)
    low, high = np.percentile(lengths, (5, 95)).tolist()
    return Estimate(float(np.mean(lengths)), low, high)


def _rounds(rows: Sequence[Sight]) -> int:
    return len({(row.drive, row.frame) for row in rows})
