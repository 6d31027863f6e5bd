"""Markers and food in frames that become worse step by step, up to the point where the tracker fails."""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import cv2
import numpy as np

from khepera_forage.vision.image_quality import measure_quality
from khepera_forage.vision.rendering.appearance import CameraAppearance
from khepera_forage.vision.tracker import Tracker
from khepera_forage.vision.tracker_settings import TrackerSettings
from tracker_accuracy.observations import TRACKER, observe
from tracker_accuracy.tiles import Conditions, frames

_LAB = CameraAppearance.laboratory()
_DARK, _GREY, _LIGHT = 30.0, 60.0, 130.0
"""Grey levels of cables: black, ours, and light grey."""
_WHITE = 215.0
"""Grey level of white where the floor's brightness is changed."""
_CABLE = 8.0
"""Width in mm of the cables that are combined with another disturbance."""


def _cables(width: float, grey: float, angle: float | None = None) -> Conditions:
    return Conditions(_LAB, cable_width=width, cable=grey, angle=angle)


def _blur(blur: float, cable: float = 0.0) -> Conditions:
    return Conditions(replace(_LAB, blur=blur), cable_width=cable)


def _exposure(factor: float, cable: float = 0.0) -> Conditions:
    return Conditions(_LAB, exposure=factor, cable_width=cable)


def _floor(floor: float, cable: float = 0.0) -> Conditions:
    return Conditions(replace(_LAB, white=_WHITE, floor=floor, wall=0.8 * floor), cable_width=cable)


def _noise(noise: float, cable: float = 0.0) -> Conditions:
    return Conditions(replace(_LAB, grain=noise), cable_width=cable)


class Sweep(NamedTuple):
    """One disturbance, from harmless to failure.

    Attributes:
        label: Of the axis, with the unit.
        values: Of the disturbance.
        curves: By name, the conditions for each value.
    """

    label: str
    values: tuple[float, ...]
    curves: dict[str, Callable[[float], Conditions]]


_WIDTHS = (0.0, 2.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 14.0, 17.0, 20.0, 25.0)
SWEEPS = {
    "width": Sweep(
        "width of the cable (mm)",
        _WIDTHS,
        {
            "black cable": lambda v: _cables(v, _DARK),
            "dark grey cable": lambda v: _cables(v, _GREY),
            "light grey cable": lambda v: _cables(v, _LIGHT),
        },
    ),
    "angle": Sweep(
        "angle between cable and marker (deg)",
        (0.0, 2.0, 5.0, *map(float, range(10, 81, 10)), 85.0, 88.0, 90.0),
        {
            "4 mm": lambda v: _cables(4.0, _GREY, v),
            "6 mm": lambda v: _cables(6.0, _GREY, v),
            "12 mm": lambda v: _cables(12.0, _GREY, v),
            "17 mm": lambda v: _cables(17.0, _GREY, v),
        },
    ),
    "blur": Sweep(
        "blur (pixels)",
        (0.3, 0.7, 1.0, 1.2, 1.4, 1.5, 1.6, 1.7, 1.8, 2.0, 2.3),
        {"no cable": _blur, "cable": lambda v: _blur(v, _CABLE)},
    ),
    "exposure": Sweep(
        "exposure (factor)",
        (0.1, 0.2, 0.35, 0.5, 0.75, 1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.2, 2.5),
        {"no cable": _exposure, "cable": lambda v: _exposure(v, _CABLE)},
    ),
    "floor": Sweep(
        f"grey level of the floor under white at {_WHITE:.0f}",
        (40.0, 70.0, 100.0, 120.0, 130.0, 140.0, 145.0, 150.0, 155.0, 160.0, 170.0),
        {"no cable": _floor, "cable": lambda v: _floor(v, _CABLE)},
    ),
    "noise": Sweep(
        "noise (grey levels)",
        (0.0, 2.5, 5.0, 8.0, 12.0, 16.0, 20.0, 25.0, 30.0),
        {"no cable": _noise, "cable": lambda v: _noise(v, _CABLE)},
    ),
    "blur and exposure": Sweep(
        "blur (pixels), 8 mm cable",
        (0.7, 1.0, 1.2, 1.4, 1.6, 1.8),
        {
            f"exposure {e:g}": lambda v, e=e: replace(_blur(v, _CABLE), exposure=e)  # type: ignore[misc]
            for e in (0.35, 1.0, 1.6)
        },
    ),
}


@dataclass(frozen=True, slots=True)
class Point:
    """All markers and food in the frames of one point of a curve.

    Attributes:
        sweep: One of `SWEEPS`.
        curve: One of its curves.
        value: Of the disturbance.
        things: Number of markers, and of food.
        markers: Markers found.
        reversals: Markers found with a reversed heading.
        foods: Food found.
        stray_markers: Detected markers that are none, or have a wrong number of holes.
        stray_foods: Detected food that is none.
        position: 95 % of the found markers' centres are within this many pixels; None without any.
        heading: The same for headings that are not reversed, in degrees.
        warned: Frames for which a warning is given.
        frames: Number of frames.
    """

    sweep: str
    curve: str
    value: float
    things: int
    markers: int
    reversals: int
    foods: int
    stray_markers: int
    stray_foods: int
    position: float | None
    heading: float | None
    warned: int
    frames: int


class Limit(NamedTuple):
    """One curve.

    Attributes:
        sweep: One of `SWEEPS`.
        curve: One of its curves.
        seed: The same for all, so that all points have the same scenes.
        images: Frames of each point.
        thinned: Whether only every fourth value is measured.
    """

    sweep: str
    curve: str
    seed: int
    images: int
    thinned: bool

    @property
    def key(self) -> str:
        """Sweep and curve."""
        return f"limit {self.sweep}, {self.curve}"

    def run(self) -> list[Point]:
        """All points of the curve."""
        cv2.setNumThreads(1)
        sweep = SWEEPS[self.sweep]
        values = sweep.values[:: 4 if self.thinned else 1]
        return [self._point(value, sweep.curves[self.curve](value)) for value in values]

    def _point(self, value: float, conditions: Conditions) -> Point:
        tracker, settings = Tracker(), TrackerSettings()
        rows, warned, stray_markers, stray_foods = [], 0, 0, 0
        for truth, frame in frames(conditions, self.images, np.random.default_rng(self.seed)):
            found = tracker.detect(frame)
            warned += bool(measure_quality(frame).warnings(settings))
            new, _ = observe((self.sweep, TRACKER, 0, 0), truth, found, [])
            rows += new
            foods = sum(row.found for row in new if row.kind == "food")
            stray_foods += sum(not region.holes for region in found) - foods
            stray_markers += sum(region.holes > 0 for region in found) - (
                sum(row.found for row in new) - foods
            )
        markers = [row for row in rows if row.kind != "food"]
        foods = sum(row.found for row in rows if row.kind == "food")
        seen = [row for row in markers if row.dx is not None and row.dy is not None and row.turn is not None]
        turns = [abs(row.turn) for row in seen if row.turn is not None]
        forward = [turn for turn in turns if turn <= 90]
        distances = [math.hypot(row.dx or 0.0, row.dy or 0.0) for row in seen]
        return Point(
            self.sweep,
            self.curve,
            value,
            len(markers),
            len(seen),
            len(turns) - len(forward),
            foods,
            stray_markers,
            stray_foods,
            float(np.percentile(distances, 95)) if distances else None,
            float(np.percentile(forward, 95)) if forward else None,
            warned,
            self.images,
        )
