"""What a camera reported of every thing in a frame, compared with the truth; its errors and losses."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import groupby, pairwise
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray
from shapely import LineString, Point, Polygon

from khepera_forage.estimates import Estimate, wilson
from khepera_forage.robots.khepera import FOOD_RADIUS, MARKER_LENGTH, MARKER_WIDTH
from khepera_forage.vision.association import Detection
from khepera_forage.vision.rendering import CameraAppearance
from khepera_forage.vision.scene import MM_PER_PIXEL, Region, Truth
from khepera_forage.vision.shapes import (
    FOOD_FEATURES,
    MARKER_FEATURES,
    MARKER_FRAME,
    PICTURE_HEIGHT,
    Plate,
    under_plate,
)

TRACKER, MODEL, THRESHOLD = "tracker", "model", "threshold"
"""The tracker on rendered frames; the simulated camera; a plain threshold on rendered frames, without headings."""
CAMERAS = (TRACKER, MODEL, THRESHOLD)
KINDS = ("food", "1 hole", "2 holes")
"""By number of holes."""
ATTEMPT = 100_000
"""Frames of different attempts at a training are at least so far apart that nothing is counted across them."""
MAX_DISTANCE = 6.0
"""Pixels from a thing within which a region belongs to it: as far as a track may jump."""
_CLEARANCE = 2.0
"""mm of floor between food and a marker's frame, from which food counts as clear of the marker."""
_LAB = CameraAppearance.laboratory()
_MARKER, _FOOD = 0.5 * MARKER_FEATURES[2][0], (0.6 * FOOD_FEATURES[0], 1.6 * FOOD_FEATURES[0])
"""Smallest marker, smallest and largest food of the plain threshold in square pixels."""
_HOLE = 2.0
"""Square pixels below which a dark spot is noise."""


@dataclass(frozen=True, slots=True)
class Observation:
    """One thing in one frame of a training, or a region that belongs to nothing, whose kind is empty.

    Attributes:
        thing: Number of the thing in the world, markers and foods counted separately.
        clear: Whether nothing hides the thing: no marker lies over food or touches it.
        cable: Whether another robot's cable lies over the thing.
        label: Of its track; -1 if not found.
        dx: Reported minus true centre in pixels, as `dy`; None if not found.
        turn: Reported minus true heading in degrees, -180 to 180; None if not found, not read, or food.
    """

    camera: str
    training: int
    frame: int
    kind: str = ""
    thing: int = 0
    clear: bool = False
    cable: bool = False
    found: bool = False
    label: int = -1
    dx: float | None = None
    dy: float | None = None
    turn: float | None = None


def observe(
    frame: tuple[str, int, int],
    truth: Truth,
    regions: Sequence[Region | Detection],
    cables: Sequence[NDArray[np.float64]],
) -> list[Observation]:
    """An observation of every thing, then one of every region that belongs to nothing.

    Args:
        frame: Camera, training and number.
        truth: What was there.
        regions: What was reported.
        cables: For each robot, points of its cable in pixels; empty without cables.
    """
    found = {id(r): r for r in regions if not isinstance(r, Region) or r.found}
    plates = [Plate(x, y, math.cos(h), math.sin(h)) for x, y, h, _ in truth.markers]
    lines = [LineString(MM_PER_PIXEL * cable) for cable in cables]
    things = []
    for number, (x, y, heading, holes) in enumerate(truth.markers):
        outline = _outline(plates[number])
        covered = any(line.intersects(outline) for i, line in enumerate(lines) if i != number)
        things.append((number, x, y, heading, holes, True, covered))
    for number, (x, y) in enumerate(truth.foods):
        clear = not under_plate(x, y, FOOD_RADIUS + MARKER_FRAME + _CLEARANCE, plates)
        covered = any(line.distance(Point(x, y)) <= FOOD_RADIUS for line in lines)
        things.append((number, x, y, 0.0, 0, clear, covered))
    rows = []
    for number, x, y, heading, holes, clear, covered in things:
        x, y = x / MM_PER_PIXEL, y / MM_PER_PIXEL
        own = [r for r in found.values() if r.holes == holes and math.hypot(r.x - x, r.y - y) <= MAX_DISTANCE]
        region = min(own, key=lambda r: math.hypot(r.x - x, r.y - y), default=None)
        label, dx, dy, turn = -1, None, None, None
        if region is not None:
            del found[id(region)]
            label = region.label if isinstance(region, Region) else -1
            dx, dy = region.x - x, region.y - y
            if holes and frame[0] != THRESHOLD:
                turn = (region.orientation - math.degrees(heading) + 180) % 360 - 180
        seen = region is not None
        rows.append(Observation(*frame, KINDS[holes], number, clear, covered, seen, label, dx, dy, turn))
    return rows + [Observation(*frame) for _ in found]


def _outline(plate: Plate) -> Polygon:
    """A marker on the floor, in mm."""
    along = MARKER_LENGTH / 2 * np.array((plate.cos, plate.sin))
    across = MARKER_WIDTH / 2 * np.array((-plate.sin, plate.cos))
    corners = (along + across, along - across, -along - across, across - along)
    return Polygon(np.array((plate.x, plate.y)) + corners)


def threshold_regions(frame: NDArray[np.uint8]) -> list[Detection]:
    """The regions of a frame as the thesis describes it (3.5): one threshold, contours, and the number of holes."""
    bright = (frame > (_LAB.floor + _LAB.white) / 2).astype(np.uint8)
    contours, hierarchy = cv2.findContours(bright, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    if hierarchy is None:
        return []
    parents = hierarchy[0, :, 3].tolist()
    areas = [cv2.contourArea(contour) for contour in contours]
    found = []
    for i, contour in enumerate(contours):
        if parents[i] >= 0:
            continue
        # A contour runs through the middles of its pixels, so half a pixel lies outside it all along.
        length = cv2.arcLength(contour, True)
        area = areas[i] + length / 2 + 1
        holes = sum(parent == i and areas[j] >= _HOLE for j, parent in enumerate(parents))
        marker = holes in (1, 2) and area >= _MARKER
        if marker or (holes == 0 and _FOOD[0] <= area <= _FOOD[1]):
            moments = cv2.moments(contour)
            x = moments["m10"] / moments["m00"] + 0.5
            y = PICTURE_HEIGHT - moments["m01"] / moments["m00"] - 0.5
            found.append(Detection(x, y, holes, 0, False, x, y, area, length))
    return found


class Errors(NamedTuple):
    """Errors of found regions that nothing hides: centres in pixels, shape (regions, 2), and headings in degrees.

    Headings that are off by more than 90 degrees are reversed: they are counted, and left out of `turns`.
    """

    offsets: NDArray[np.float64]
    turns: NDArray[np.float64]
    reversals: int

    @property
    def distances(self) -> NDArray[np.float64]:
        """Of centres, in pixels."""
        return np.hypot(self.offsets[:, 0], self.offsets[:, 1])


def errors(rows: Iterable[Observation]) -> Errors:
    """Errors of all regions that were found and that nothing hides."""
    found = [row for row in rows if row.found and row.clear]
    offsets = np.array([(row.dx, row.dy) for row in found], np.float64).reshape(-1, 2)
    turns = np.array([row.turn for row in found if row.turn is not None], np.float64)
    is_reversed = np.abs(turns) > 90
    return Errors(offsets, turns[~is_reversed], int(is_reversed.sum()))


class Losses(NamedTuple):
    """Losses of things that nothing hides.

    `rate` is that of a round in which a thing that was found one round before could be lost; its interval treats losses
    as independent. `lengths` are the rounds of each loss that ended while nothing hid the thing.
    """

    rate: Estimate
    lengths: list[int]


def losses(rows: Iterable[Observation], cable: bool) -> Losses:
    """Losses that began with, or without, a cable over the thing."""

    def thing(row: Observation) -> tuple[str, int, str, int]:
        return row.camera, row.training, row.kind, row.thing

    exposed = lost = 0
    lengths: list[int] = []
    for _, track in groupby(sorted(rows, key=lambda row: (thing(row), row.frame)), thing):
        begun: int | None = None
        for before, now in pairwise(track):
            if now.frame != before.frame + 1 or not (before.clear and now.clear):
                begun = None
                continue
            if before.found and now.cable == cable:
                exposed += 1
                if not now.found:
                    lost += 1
                    begun = now.frame
            elif not before.found and now.found and begun is not None:
                lengths.append(now.frame - begun)
            if now.found:
                begun = None
    return Losses(wilson(lost, exposed), lengths)


def swapped_labels(rows: Iterable[Observation]) -> int:
    """How often a label of one camera went from one thing to another within an attempt."""
    swaps = 0
    things: dict[tuple[int, int, int], tuple[str, int]] = {}
    for row in sorted(rows, key=lambda row: (row.training, row.frame)):
        if row.found:
            thing, label = (row.kind, row.thing), (row.training, row.frame // ATTEMPT, row.label)
            swaps += things.get(label, thing) != thing
            things[label] = thing
    return swaps
