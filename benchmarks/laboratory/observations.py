"""What the tracker reported of every thing in a frame, compared with the truth; its errors and losses."""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from khepera_forage.estimates import Estimate, wilson
from khepera_forage.robots.khepera import FOOD_RADIUS
from khepera_forage.vision.association import Detection
from khepera_forage.vision.scene import MM_PER_PIXEL, Region, Truth
from khepera_forage.vision.shapes import MARKER_FRAME, Plate, under_plate

KINDS = ("food", "1 hole", "2 holes")
"""By number of holes."""
ATTEMPT = 100_000
"""Frames of different attempts at a training are at least so far apart that nothing is counted across them."""
MAX_DISTANCE = 6.0
"""Pixels from a thing within which a region belongs to it: as far as a track may jump."""
_CLEARANCE = 2.0
"""mm of floor between food and a marker's frame, from which food counts as clear of the marker."""


@dataclass(frozen=True, slots=True)
class Observation:
    """One thing in one frame of a training, or a region that belongs to nothing, whose kind is empty.

    Attributes:
        thing: Number of the thing in the world, markers and foods counted separately.
        clear: Whether nothing hides the thing: no marker lies over food or touches it.
        dx: Reported minus true centre in pixels, as `dy`; None if not found.
        turn: Reported minus true heading in degrees, -180 to 180; None if not found, or food.
    """

    training: int
    frame: int
    kind: str = ""
    thing: int = 0
    clear: bool = False
    found: bool = False
    dx: float | None = None
    dy: float | None = None
    turn: float | None = None


def observe(frame: tuple[int, int], truth: Truth, regions: Sequence[Region | Detection]) -> list[Observation]:
    """An observation of every thing, then one of every region that belongs to nothing.

    Args:
        frame: Training and number.
        truth: What was there.
        regions: What was reported.
    """
    found = {id(r): r for r in regions if not isinstance(r, Region) or r.found}
    plates = [Plate(x, y, math.cos(h), math.sin(h)) for x, y, h, _ in truth.markers]
    reach = FOOD_RADIUS + MARKER_FRAME + _CLEARANCE
    markers = [(number, *marker, True) for number, marker in enumerate(truth.markers)]
    foods = [(number, x, y, 0.0, 0, not under_plate(x, y, reach, plates)) for number, (x, y) in enumerate(truth.foods)]
    rows = []
    for number, x, y, heading, holes, clear in (*markers, *foods):
        x, y = x / MM_PER_PIXEL, y / MM_PER_PIXEL
        own = [r for r in found.values() if r.holes == holes and math.hypot(r.x - x, r.y - y) <= MAX_DISTANCE]
        thing = Observation(*frame, KINDS[holes], number, clear)
        if own:
            region = min(own, key=lambda r: math.hypot(r.x - x, r.y - y))
            del found[id(region)]
            turn = (region.orientation - math.degrees(heading) + 180) % 360 - 180 if holes else None
            thing = replace(thing, found=True, dx=region.x - x, dy=region.y - y, turn=turn)
        rows.append(thing)
    return rows + [Observation(*frame) for _ in found]


def offsets(rows: Iterable[Observation]) -> NDArray[np.float64]:
    """Errors of the centres of found regions that nothing hides in pixels, shape (regions, 2)."""
    return np.array([(row.dx, row.dy) for row in rows if row.found and row.clear], np.float64).reshape(-1, 2)


def turns(rows: Iterable[Observation]) -> NDArray[np.float64]:
    """Errors of the headings of found markers in degrees, but for those that are reversed."""
    return np.array([row.turn for row in rows if row.turn is not None and abs(row.turn) <= 90], np.float64)


def reversals(rows: Iterable[Observation]) -> int:
    """Number of headings that are off by more than 90 degrees."""
    return sum(row.turn is not None and abs(row.turn) > 90 for row in rows)


def loss_rate(rows: Iterable[Observation]) -> Estimate:
    """How likely it is that a thing that nothing hides, found in one round, is lost in the next.

    The interval treats losses as independent.
    """

    def place(row: Observation) -> tuple[int, str, int, int]:
        return row.training, row.kind, row.thing, row.frame

    exposed = lost = 0
    for before, now in pairwise(sorted(rows, key=place)):
        follows = (*place(before)[:3], before.frame + 1) == place(now)
        if follows and before.clear and now.clear and before.found:
            exposed += 1
            lost += not now.found
    return wilson(lost, exposed)
