"""What a camera made of one thing in one frame, beside the truth."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from khepera_forage.robots.khepera import FOOD_RADIUS, MARKER_LENGTH, MARKER_WIDTH
from khepera_forage.vision.association import Detection
from khepera_forage.vision.scene import MM_PER_PIXEL, Region
from khepera_forage.vision.shapes import MARKER_FRAME, Plate, distance_to_segment, under_plate
from khepera_forage.vision.simulated_camera import Truth

TRACKER, MODEL, BARE = "tracker", "model", "bare threshold"
KINDS = ("food", "1 hole", "2 holes")
"""By number of holes."""
NEAR = 6.0
"""Pixels from a thing within which a region is of it: as far as a track may jump."""
_CLEAR = 2.0
"""mm of floor between food and a marker's frame, at which food counts as clear of it."""


@dataclass(frozen=True, slots=True)
class Sight:
    """One thing in one frame.

    Attributes:
        camera: `TRACKER` on rendered frames, `MODEL`: the simulated camera, or `BARE`: a plain threshold on rendered
            frames, which reads no headings.
        drive: Number of the drive.
        frame: Number of the frame in it.
        kind: One of `KINDS`.
        thing: Number of the thing in the world, markers and foods counted apart.
        clear: Whether nothing hides it: no marker over food or touching it.
        cable: Whether another robot's cable lies over it.
        found: Whether the camera reports it as found.
        label: Of its track; -1 if not found.
        dx: Reported minus true centre in pixels; nan if not found.
        dy: The same.
        turn: Reported minus true heading in degrees, -180 to 180; nan if not found or not read, or food.
    """

    camera: str
    drive: int
    frame: int
    kind: str
    thing: int
    clear: bool
    cable: bool
    found: bool
    label: int
    dx: float
    dy: float
    turn: float


def sights(
    camera: str,
    drive: int,
    frame: int,
    truth: Truth,
    regions: Sequence[Region | Detection],
    cables: Sequence[NDArray[np.float64]],
) -> tuple[list[Sight], int]:
    """A sight of everything there is, and how many regions are of nothing that is clear to see.

    Args:
        camera: Who looked.
        drive: Number of the drive.
        frame: Number of the frame.
        truth: What was there.
        regions: What was reported.
        cables: For each robot points of its cable in pixels; empty without cables.
    """
    rows = []
    found = {id(r): r for r in regions if not isinstance(r, Region) or r.found}
    plates = [Plate(x, y, math.cos(h), math.sin(h)) for x, y, h, _ in truth.markers]
    for number, (x, y, heading, holes) in enumerate(truth.markers):
        others = [cable for i, cable in enumerate(cables) if i != number]
        half = (MARKER_LENGTH / 2, MARKER_WIDTH / 2)
        cable = any(_over_marker(c, plates[number], *half) for c in others)
        rows.append((number, x, y, heading, holes, True, cable))
    for number, (x, y) in enumerate(truth.foods):
        clear = not under_plate(x, y, FOOD_RADIUS + MARKER_FRAME + _CLEAR, plates)
        rows.append((number, x, y, 0.0, 0, clear, any(_over_food(c, x, y) for c in cables)))
    result = []
    for number, x, y, heading, holes, clear, cable in rows:
        x, y = x / MM_PER_PIXEL, y / MM_PER_PIXEL
        own = [r for r in found.values() if r.holes == holes and math.hypot(r.x - x, r.y - y) <= NEAR]
        region = min(own, key=lambda r: math.hypot(r.x - x, r.y - y), default=None)
        label, dx, dy, turn = -1, math.nan, math.nan, math.nan
        if region is not None:
            del found[id(region)]
            label = region.label if isinstance(region, Region) else -1
            dx, dy = region.x - x, region.y - y
            if holes and camera != BARE:
                turn = (region.orientation - math.degrees(heading) + 180) % 360 - 180
        result.append(
            Sight(
                camera,
                drive,
                frame,
                KINDS[holes],
                number,
                clear,
                cable,
                region is not None,
                label,
                dx,
                dy,
                turn,
            )
        )
    return result, len(found)


def straight(truth: Truth, anchor: tuple[float, float]) -> list[NDArray[np.float64]]:
    """The cables of the simulated camera: straight from the anchor to each robot."""
    return [np.array((anchor, marker[:2])) / MM_PER_PIXEL for marker in truth.markers]


def _over_food(cable: NDArray[np.float64], x: float, y: float) -> bool:
    points = (cable * MM_PER_PIXEL).tolist()
    return any(distance_to_segment(x, y, *a, *b) <= FOOD_RADIUS for a, b in pairwise(points))


def _over_marker(cable: NDArray[np.float64], plate: Plate, ahead: float, aside: float) -> bool:
    """Whether a cable crosses a sheet: looked at every few mm, in the sheet's own frame."""
    shares = np.linspace(0, len(cable) - 1, 400)
    at = np.arange(len(cable))
    dx = np.interp(shares, at, cable[:, 0]) * MM_PER_PIXEL - plate.x
    dy = np.interp(shares, at, cable[:, 1]) * MM_PER_PIXEL - plate.y
    along, across = dx * plate.cos + dy * plate.sin, dy * plate.cos - dx * plate.sin
    return bool(np.any((np.abs(along) <= ahead) & (np.abs(across) <= aside)))
