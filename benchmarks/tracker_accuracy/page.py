"""The tables of the page."""

import math
from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.estimates import UNKNOWN, Column, Estimate, Table, Value, extremes, percent, pick, plain
from khepera_forage.noise import Noise
from tracker_accuracy.measures import errors, losses, swapped_labels
from tracker_accuracy.observations import (
    KINDS,
    MODEL,
    THRESHOLD,
    TRACKER,
    TRAINING,
    Observation,
    Phantoms,
)
from tracker_accuracy.scenes import APPEARANCES
from tracker_accuracy.speed import CROSSED, PARTS, Rate

_ACCURACY_NOTE = (
    "Random scenes anywhere in the image: two markers and two foods each, nothing hidden by a marker, cables from "
    "anywhere. Every frame is read without tracks, and the scenes are the same for every appearance. Errors are those "
    "of found regions: regions within 6 pixels of a thing of their kind. Headings are reported in whole degrees. "
    "Shares with Wilson's 95 % interval."
)
_MODEL_NOTE = (
    "Trainings in simulation, observed by all cameras with the same anchor of the cables, one frame a round. The first "
    "column is the model's parameter, the second the same quantity measured on the model. The threshold reads contours "
    "and holes without any repair. Jitter: standard deviation of the error along an axis, of things that nothing "
    "hides; that of headings includes the rounding to whole degrees (0.29), which the model applies after its jitter. "
    "Loss rate: a round; things hidden by a marker do not count. Shares and rates with Wilson's 95 % interval, "
    "loss_rounds with 5th and 95th percentile."
)


class Observed(NamedTuple):
    """All rows of the benchmark but for the hole layouts."""

    observations: Sequence[Observation]
    phantoms: Sequence[Phantoms]
    rates: Sequence[Rate]


def speed_table(found: Observed, frames: int) -> Table:
    """Frames a second."""
    goals = {PARTS[0]: "at least 300", CROSSED: "at least 300"}
    rows = [
        (part, *extremes([row.rate for row in pick(found.rates, part=part)]), goals.get(part, ""))
        for part in PARTS
    ]
    columns = (
        Column("part"),
        Column("frames/s", 0),
        Column("lowest", 0),
        Column("highest", 0),
        Column("goal"),
    )
    repeats = len(found.rates) // len(PARTS)
    note = (
        f"One thread, by its processor time, {frames} frames of a training; median, lowest and highest of {repeats} "
        "repeats."
    )
    return Table("speed", "Speed", note, columns, rows)


def accuracy_table(found: Observed) -> Table:
    """The accuracy of single frames, by appearance and kind of region."""
    rows: list[tuple[Value, ...]] = []
    for appearance in APPEARANCES:
        (phantoms,) = pick(found.phantoms, source=appearance)
        for kind in KINDS:
            own = pick(found.observations, source=appearance, kind=kind)
            crossed = pick(own, cable=True)
            error, marker = errors(own), kind != KINDS[0]
            distances, turns = error.distances, np.abs(error.turns)
            within_3 = percent(int((turns <= 3).sum()), len(turns) + error.reversals)
            rows.append(
                (
                    appearance,
                    kind,
                    len(own),
                    percent(sum(row.found for row in own), len(own)),
                    len(crossed),
                    percent(sum(row.found for row in crossed), len(crossed)),
                    *_median_and_99(distances),
                    percent(int((distances <= 1).sum()), len(distances)),
                    *_median_and_99(turns),
                    within_3 if marker else UNKNOWN,
                    error.reversals,
                    "" if marker else phantoms.count,
                )
            )
    columns = (
        Column("appearance"),
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
    return Table("accuracy", "Single frames", _ACCURACY_NOTE, columns, rows)


def model_table(found: Observed) -> Table:
    """The simulated camera beside the tracker, in the quantities of `Noise`."""
    noise = Noise.laboratory()
    own = pick(found.observations, source=TRAINING)
    by = {camera: pick(own, camera=camera) for camera in (MODEL, TRACKER, THRESHOLD)}
    of = {kind: [pick(rows, kind=kind) for rows in by.values()] for kind in KINDS}
    markers = [[row for row in rows if row.kind != KINDS[0]] for rows in by.values()]
    rounds = [len({(row.training, row.frame) for row in rows}) for rows in by.values()]
    stray = [sum(row.count for row in pick(found.phantoms, source=TRAINING, camera=c)) for c in by]
    hidden = [pick(rows, clear=False) for rows in by.values()]
    rates = (noise.loss_rate_food, noise.loss_rate_one_hole, noise.loss_rate_two_holes)
    rows: list[tuple[Value, ...]] = []

    def add(quantity: str, parameter: float | str, values: Iterable[Estimate | float]) -> None:
        estimates = (value if isinstance(value, Estimate) else plain(value) for value in values)
        rows.append((quantity, parameter, *estimates))

    for kind in KINDS:
        add(f"position_jitter (px), {kind}", noise.position_jitter, (errors(r).jitter[0] for r in of[kind]))
    for kind in KINDS[1:]:
        add(f"heading_jitter (deg), {kind}", noise.heading_jitter, (errors(r).jitter[1] for r in of[kind]))
    add("reversal_rate", noise.reversal_rate, map(_reversals, markers))
    for kind, rate in zip(KINDS, rates, strict=True):
        add(f"loss rate, {kind}", rate, (losses(r, cable=False).rate for r in of[kind]))
    for kind in KINDS:
        add(f"loss rate under a cable, {kind}", "", (losses(r, cable=True).rate for r in of[kind]))
    add("cable_loss_factor", noise.cable_loss_factor, map(_cable_factor, by.values()))
    add("loss_rounds", noise.loss_rounds, map(_loss_rounds, by.values()))
    add("food near a marker found (%)", "", (percent(sum(x.found for x in r), len(r)) for r in hidden))
    swaps = (math.nan if camera == THRESHOLD else swapped_labels(r) for camera, r in by.items())
    add("labels that changed things", "", swaps)
    add("regions of nothing, a round", "", (s / max(1, n) for s, n in zip(stray, rounds, strict=True)))
    add("rounds", "", rounds)
    columns = (
        Column("quantity"),
        Column("Noise.laboratory()", 4),
        Column("model, measured", 4, estimate=True),
        Column("tracker on rendered frames", 4, estimate=True),
        Column("threshold on rendered frames", 4, estimate=True),
    )
    return Table("model", "The simulated camera and the tracker", _MODEL_NOTE, columns, rows)


def _median_and_99(values: NDArray[np.float64]) -> list[float]:
    return np.percentile(values, (50, 99)).tolist() if len(values) else [math.nan, math.nan]


def _reversals(rows: Sequence[Observation]) -> Estimate:
    error = errors(rows)
    share = percent(error.reversals, error.reversals + len(error.turns))
    return Estimate(*(value / 100 for value in share))


def _cable_factor(rows: Sequence[Observation]) -> float:
    """The loss rate under a cable divided by that without, over all kinds."""
    clear, covered = losses(rows, cable=False).rate.value, losses(rows, cable=True).rate.value
    return covered / clear if clear else math.nan


def _loss_rounds(rows: Sequence[Observation]) -> Estimate:
    lengths = [n for cable in (False, True) for n in losses(rows, cable).lengths]
    if not lengths:
        return UNKNOWN
    low, high = np.percentile(lengths, (5, 95)).tolist()
    return Estimate(float(np.mean(lengths)), low, high)
