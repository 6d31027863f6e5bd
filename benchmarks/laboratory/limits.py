"""Markers and food in frames that become worse step by step, up to the point where the tracker fails."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from khepera_forage.estimates import Table, Value, percent, pick, table_of
from khepera_forage.figures import COLOURS, GREY, SMALL, grid, panels
from khepera_forage.robots.khepera import MARKER_LENGTH, MARKER_WIDTH
from khepera_forage.vision.image_quality import measure_quality
from khepera_forage.vision.rendering import CameraAppearance, FrameRenderer, Light, draw_cable
from khepera_forage.vision.scene import MM_PER_PIXEL, Truth
from khepera_forage.vision.shapes import PICTURE_HEIGHT, PICTURE_WIDTH
from khepera_forage.vision.tracker import Tracker
from khepera_forage.vision.tracker_settings import TrackerSettings
from laboratory.observations import KINDS, observe, reversals

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_LAB = CameraAppearance.laboratory()
_WHITE = 215.0
"""Grey level of white where the floor's brightness is changed."""
_FOUND = 98.0
"""Percent: the goal."""
COLUMNS, ROWS = 5, 4
"""Tiles of a frame, 128 x 120 pixels each, with a marker and a food object."""
_TILE = (PICTURE_WIDTH * MM_PER_PIXEL / COLUMNS, PICTURE_HEIGHT * MM_PER_PIXEL / ROWS)
_MARKER_MARGIN, _FOOD_MARGIN, _DISTANCE = 190.0, 60.0, 150.0
"""mm from the border of its tile to the centre of a marker and of food, and between the two."""
_HALF_CABLE = 170.0
"""mm from the middle of a cable to each of its ends: it stays within its tile."""
_CURVE = 8.0
"""Greatest distance in mm of the middle of a cable from the straight line between its ends."""


_GREY, _CABLE = 60.0, 8.0
"""Grey level of cables, and their width in mm where it does not vary."""
CURVES = ("no cable", "cable")
WIDTH_SWEEP = "width of the cable (mm)"
SWEEPS = {
    WIDTH_SWEEP: (0.0, 2.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 14.0, 17.0, 20.0, 25.0),
    "blur (pixels)": (0.3, 0.7, 1.0, 1.2, 1.4, 1.5, 1.6, 1.7, 1.8, 2.0, 2.3),
    "exposure (factor)": (0.1, 0.2, 0.35, 0.5, 0.75, 1.0, 1.2, 1.4, 1.6, 1.8, 2.0, 2.2, 2.5),
    f"floor (white: {_WHITE:.0f})": (40.0, 70.0, 100.0, 120.0, 130.0, 140.0, 145.0, 150.0, 155.0, 160.0, 170.0),
    "noise (grey levels)": (0.0, 2.5, 5.0, 8.0, 12.0, 16.0, 20.0, 25.0, 30.0),
}
"""The disturbances, from harmless to failure."""


class Conditions(NamedTuple):
    """What disturbs a frame: width in mm of its cables, appearance, and a factor of all grey levels."""

    cable: float
    appearance: CameraAppearance = _LAB
    exposure: float = 1.0


def conditions(sweep: str, curve: str, value: float) -> Conditions:
    """The conditions of one point of a curve."""
    cable = _CABLE if curve == "cable" else 0.0
    match sweep.split()[0]:
        case "width":
            return Conditions(value)
        case "blur":
            return Conditions(cable, replace(_LAB, blur=value))
        case "exposure":
            return Conditions(cable, exposure=value)
        case "floor":
            return Conditions(cable, replace(_LAB, white=_WHITE, floor=value, wall=0.8 * value))
        case _:
            return Conditions(cable, replace(_LAB, grain=value))


@dataclass(frozen=True, slots=True)
class SweepPoint:
    """All markers and food in the frames of one point of a curve.

    `things` is the number of markers, and of food; `markers` and `foods` are found, `stray` are detected but are none,
    or have a wrong number of holes; `reversals` have a heading of more than 90 degrees off. `warned` is the percentage
    of frames with a warning.
    """

    sweep: str
    curve: str
    value: float
    things: int
    markers: int
    foods: int
    stray: int
    reversals: int
    warned: float


def limit_points(sweep: str, curve: str, seed: int, images: int, quick: bool) -> list[SweepPoint]:
    """All points of a curve, in the same scenes; the first and the last one with `quick`."""
    cv2.setNumThreads(1)
    values, tracker, settings = SWEEPS[sweep], Tracker(), TrackerSettings()
    points = []
    for value in (values[0], values[-1]) if quick else values:
        rows, warned = [], 0
        for truth, frame in _frames(conditions(sweep, curve, value), images, np.random.default_rng(seed)):
            rows += observe((0, 0), truth, tracker.detect(frame))
            warned += bool(measure_quality(frame).warnings(settings))
        things = images * COLUMNS * ROWS
        foods = sum(row.found for row in pick(rows, kind=KINDS[0]))
        markers, stray = sum(row.found for row in rows) - foods, len(pick(rows, kind=""))
        share = 100 * warned / images
        points.append(SweepPoint(sweep, curve, value, things, markers, foods, stray, reversals(rows), share))
    return points


def _frames(given: Conditions, count: int, rng: np.random.Generator) -> Iterator[tuple[Truth, NDArray[np.uint8]]]:
    """Frames with a marker and food in each tile, and what is in them."""
    places, light_rng, floor_rng, noise = rng.spawn(4)
    # An exposure below 1 weakens the light, but not the sensor's noise.
    grain = given.appearance.grain * math.sqrt(max(0.0, 1 - given.exposure**2))
    light = Light(given.appearance, light_rng)
    truth = Truth((), ())
    renderer = FrameRenderer(lambda: truth, given.appearance)
    renderer.reset(floor_rng)
    for number in range(count):
        truth = _truth(places)
        picture = renderer.picture()
        for marker in truth.markers:
            # Drawn even without cables, so that the poses are the same for every width.
            curve = _cable(marker, places)
            if given.cable > 0:
                draw_cable(picture, curve, given.cable / MM_PER_PIXEL, _GREY)
        frame = light.expose(picture, float(number))
        exposed = frame * given.exposure + noise.normal(0, grain, frame.shape)
        yield truth, exposed.round().clip(0, 255).astype(np.uint8)


def _truth(rng: np.random.Generator) -> Truth:
    """A marker and a food object at random places of every tile."""
    markers, foods = [], []
    for number in range(COLUMNS * ROWS):
        left, below = number % COLUMNS * _TILE[0], number // COLUMNS * _TILE[1]
        x, y = (float(rng.uniform(_MARKER_MARGIN, size - _MARKER_MARGIN)) for size in _TILE)
        while True:
            food_x, food_y = (float(rng.uniform(_FOOD_MARGIN, size - _FOOD_MARGIN)) for size in _TILE)
            if math.hypot(food_x - x, food_y - y) > _DISTANCE:
                break
        markers.append((left + x, below + y, float(rng.uniform(-math.pi, math.pi)), 1 + number % 2))
        foods.append((left + food_x, below + food_y))
    return Truth(tuple(markers), tuple(foods))


def _cable(marker: tuple[float, float, float, int], rng: np.random.Generator) -> NDArray[np.float64]:
    """A slightly curved cable anywhere across a marker, at any angle: points in pixels."""
    x, y, heading, _ = marker
    turn = float(rng.uniform(0, math.pi))
    along = np.array((math.cos(heading + turn), math.sin(heading + turn)))
    normal = np.array((-along[1], along[0]))
    reach = (MARKER_LENGTH * abs(math.sin(turn)) + MARKER_WIDTH * abs(math.cos(turn))) / 2
    offset, bend = rng.uniform(-reach, reach), rng.uniform(-_CURVE, _CURVE)
    shares = np.linspace(-1, 1, 13)[:, None]
    points = (x, y) + shares * _HALF_CABLE * along + (offset + bend * (1 - shares**2)) * normal
    return points / MM_PER_PIXEL  # type: ignore[no-any-return]


def limits_table(points: Sequence[SweepPoint]) -> Table:
    """All points of all curves."""
    note = (
        "Frames with 20 markers and 20 foods each. A cable crosses every marker anywhere, at any angle, slightly "
        "curved; no cable crosses the food. Every frame is read without tracks. Stray: markers with a wrong number of "
        "holes or where there is none, and food where there is none, per 1000 markers. Warning: share of the frames "
        "for which `camera preview` names a setting to change. Shares with Wilson's 95 % interval."
    )
    rows: list[dict[str, Value]] = [
        {
            "disturbance": p.sweep,
            "curve": p.curve,
            "value": f"{p.value:g}",
            "markers found (%)": percent(p.markers, p.things),
            "food found (%)": percent(p.foods, p.things),
            "stray (per 1000)": 1000 * p.stray / p.things,
            "reversed": p.reversals,
            "warning (%)": p.warned,
        }
        for p in points
    ]
    return table_of("limits", "Up to the point of failure", note, rows, {"warning (%)": 0})


def limits_picture(points: Sequence[SweepPoint]) -> "Figure":
    """Shares found as curves, one panel for each disturbance."""
    title = "Markers (lines) and food (dotted) found, as the picture becomes worse"
    figure, (*shown, last) = panels(1 + len(SWEEPS), title)
    for panel, sweep in zip(shown, SWEEPS, strict=True):
        for colour, curve in zip(COLOURS, CURVES, strict=False):
            own = pick(points, sweep=sweep, curve=curve)
            values = [p.value for p in own]
            panel.plot(values, [100 * p.markers / p.things for p in own], "o-", ms=3, color=colour, label=curve)
            panel.plot(values, [100 * p.foods / p.things for p in own], ":", color=colour)
            warned = [p.value for p in own if p.warned > 50]
            if warned:
                panel.plot(warned, [-4.0] * len(warned), "^", ms=4, color=colour, clip_on=False)
        panel.axhline(_FOUND, color=GREY, lw=1, ls=(0, (1, 2)))
        panel.set(ylim=(-7, 104), xlabel=sweep, ylabel="found (%)")
        grid(panel, "both")
    note = "triangles: a warning names the setting to change\ngrey line: the goal of 98 %"
    last.axis("off")
    last.legend(*shown[1].get_legend_handles_labels(), title=note, loc="center", fontsize=SMALL, title_fontsize=SMALL)
    return figure
