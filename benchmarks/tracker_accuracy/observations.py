"""What a camera reported of one thing in one frame, compared with the truth."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from khepera_forage.robots.khepera import FOOD_RADIUS, MARKER_LENGTH, MARKER_WIDTH
from khepera_forage.vision.association import Detection
from khepera_forage.vision.scene import MM_PER_PIXEL, Region, Truth
from khepera_forage.vision.shapes import MARKER_FRAME, Plate, distance_to_segment, under_plate

TRACKER, MODEL, THRESHOLD = "tracker", "model", "threshold"
"""The tracker on rendered frames; the simulated camera; a plain threshold on rendered frames, without headings."""
CAMERAS = (TRACKER, MODEL, THRESHOLD)
TRAINING = "training"
"""The source of observations of trainings; for single frames it is the name of their appearance."""
KINDS = ("food", "1 hole", "2 holes")
"""By number of holes."""
MAX_DISTANCE = 6.0
"""Pixels from a thing within which a region belongs to it: as far as a track may jump."""
_CLEARANCE = 2.0
"""mm of floor between food and a marker's frame, from which food counts as clear of the marker."""


@dataclass(frozen=True, slots=True)
class Observation:
    """One thing in one frame.

    Attributes:
        source: `TRAINING`, or the appearance of a single frame.
        camera: One of `CAMERAS`.
        training: Number of the training; 0 for single frames.
        frame: Number of the frame. Frames of different attempts at a training are at least 100,000 apart.
        kind: One of `KINDS`.
        thing: Number of the thing in the world, markers and foods counted separately.
        clear: Whether nothing hides the thing: no marker lies over food or touches it.
        cable: Whether another robot's cable lies over the thing.
        found: Whether the camera reports it as found.
        label: Of its track; -1 if not found.
        dx: Reported minus true centre in pixels; None if not found.
        dy: The same.
        turn: Reported minus true heading in degrees, -180 to 180; None if not found, not read, or food.
    """

    source: str
    camera: str
    training: int
    frame: int
    kind: str
    thing: int
    clear: bool
    cable: bool
    found: bool
    label: int
    dx: float | None
    dy: float | None
    turn: float | None


@dataclass(frozen=True, slots=True)
class Phantoms:
    """Reported regions that belong to nothing.

    Attributes:
        source: As in `Observation`.
        camera: One of `CAMERAS`.
        training: Number of the training; 0 for single frames.
        count: Regions.
    """

    source: str
    camera: str
    training: int
    count: int


Frame = tuple[str, str, int, int]
"""Source, camera, training and number of a frame."""


def observe(
    frame: Frame,
    truth: Truth,
    regions: Sequence[Region | Detection],
    cables: Sequence[NDArray[np.float64]],
) -> tuple[list[Observation], int]:
    """An observation of every thing, and the number of regions that belong to nothing.

    Args:
        frame: Which frame of which camera.
        truth: What was there.
        regions: What was reported.
        cables: For each robot, points of its cable in pixels; empty without cables.
    """
    found = {id(r): r for r in regions if not isinstance(r, Region) or r.found}
    plates = [Plate(x, y, math.cos(h), math.sin(h)) for x, y, h, _ in truth.markers]
    things = []
    for number, (x, y, heading, holes) in enumerate(truth.markers):
        others = [cable for i, cable in enumerate(cables) if i != number]
        covered = any(_over_marker(cable, plates[number]) for cable in others)
        things.append((number, x, y, heading, holes, True, covered))
    for number, (x, y) in enumerate(truth.foods):
        clear = not under_plate(x, y, FOOD_RADIUS + MARKER_FRAME + _CLEARANCE, plates)
        covered = any(_over_food(cable, x, y) for cable in cables)
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
            if holes and frame[1] != THRESHOLD:
                turn = (region.orientation - math.degrees(heading) + 180) % 360 - 180
        seen = region is not None
        rows.append(Observation(*frame, KINDS[holes], number, clear, covered, seen, label, dx, dy, turn))
    return rows, len(found)


def straight_cables(truth: Truth, anchor: tuple[float, float]) -> list[NDArray[np.float64]]:
    """The cables of the simulated camera: straight from the anchor to each robot."""
    return [np.array((anchor, marker[:2])) / MM_PER_PIXEL for marker in truth.markers]


def _over_food(cable: NDArray[np.float64], x: float, y: float) -> bool:
    points = (cable * MM_PER_PIXEL).tolist()
    return any(distance_to_segment(x, y, *a, *b) <= FOOD_RADIUS for a, b in pairwise(points))


def _over_marker(cable: NDArray[np.float64], plate: Plate) -> bool:
    """Whether a cable crosses a marker; checked every few mm, in the marker's coordinates."""
    shares = np.linspace(0, len(cable) - 1, 400)
    at = np.arange(len(cable))
    dx = np.interp(shares, at, cable[:, 0]) * MM_PER_PIXEL - plate.x
    dy = np.interp(shares, at, cable[:, 1]) * MM_PER_PIXEL - plate.y
    along, across = dx * plate.cos + dy * plate.sin, dy * plate.cos - dx * plate.sin
    return bool(np.any((np.abs(along) <= MARKER_LENGTH / 2) & (np.abs(across) <= MARKER_WIDTH / 2)))
