"""Geometry of markers and food, on the floor (mm) and in the picture (pixels).

Coordinates are those of `scene`: x to the right, y up, origin in the lower left corner of the picture.
"""

import math
from collections.abc import Iterable
from typing import NamedTuple

from khepera_forage.robots.khepera import FOOD_RADIUS, MARKER_LENGTH, MARKER_WIDTH
from khepera_forage.vision.scene import MM_PER_PIXEL

PICTURE_WIDTH = 640.0
"""Width of the camera's picture in pixels (3.4)."""
PICTURE_HEIGHT = 480.0
"""Height of the camera's picture in pixels (3.4)."""
HOLE_SIDE = 20.0
"""Side in mm of a black square within a marker (figure 3.9)."""
MARKER_HOLES: dict[int, tuple[tuple[float, float], ...]] = {1: ((25.0, 0.0),), 2: ((30.0, 0.0), (-10.0, 0.0))}
"""Centres of a marker's holes in mm, x forward and y left of its middle, by number of holes.

Decision (figure 3.9 did not survive as a picture): the holes lie ahead of the middle, so that they tell front from
back, which the thesis's own markers evidently did not (4.2.2). At least 4 pixels of white separate a hole from the next
black shape, so that blur and a low threshold do not join them.
"""
GRID_SIDE = 16.0
"""Side in mm of a hole of the markers for many robots."""
GRID_PLACES = tuple((x, y) for x in (33.0, 0.0, -33.0) for y in (15.0, -15.0))
"""Places in mm of the 16 mm holes of the markers for many robots: columns from the front, each from left to right."""


def _grid_holes() -> dict[int, tuple[tuple[float, float], ...]]:
    """The arrangements with an even number of holes that a half turn changes, one of each two that it exchanges.

    One hole that is hidden, or one dark spot too many, makes the number odd: it never makes another marker.
    """
    codes: list[int] = []
    for code in range(64):
        turned = int(f"{code:06b}"[::-1], 2)
        if code.bit_count() % 2 == 0 and turned != code and turned not in codes:
            codes.append(code)
    return {
        number: tuple(place for i, place in enumerate(GRID_PLACES) if code >> i & 1)
        for number, code in enumerate(codes, start=1)
    }


GRID_HOLES = _grid_holes()
"""Centres in mm of the holes of twelve markers, by their number."""
ARRANGEMENTS = {"holes": (MARKER_HOLES, HOLE_SIDE), "grid": (GRID_HOLES, GRID_SIDE)}
"""Centres of the holes of all markers of a kind, by their number, and the side of a hole."""
MARKER_FRAME = 8.0
"""Width in mm of the black frame around a marker's white sheet (figure 3.8 shows one)."""

FOOD_RADIUS_PX = FOOD_RADIUS / MM_PER_PIXEL
_HALF_LENGTH, _HALF_WIDTH = MARKER_LENGTH / 2, MARKER_WIDTH / 2
_HALF_LENGTH_PX, _HALF_WIDTH_PX = _HALF_LENGTH / MM_PER_PIXEL, _HALF_WIDTH / MM_PER_PIXEL


MARKER_FEATURES = {
    holes: (
        (MARKER_LENGTH * MARKER_WIDTH - holes * HOLE_SIDE**2) / MM_PER_PIXEL**2,
        2 * (MARKER_LENGTH + MARKER_WIDTH) / MM_PER_PIXEL,
    )
    for holes in (1, 2)
}
"""Area and perimeter of a marker's `Region` by its number of holes; Quek's tracker stores them, and tracks by neither
(3.5)."""
FOOD_FEATURES = math.pi * FOOD_RADIUS_PX**2, 2 * math.pi * FOOD_RADIUS_PX


class Plate(NamedTuple):
    """Pose of a marker over the floor: centre in mm, cosine and sine of its heading, along its long side."""

    x: float
    y: float
    cos: float
    sin: float


def under_plate(x: float, y: float, radius: float, plates: Iterable[Plate]) -> bool:
    """Whether a disc (centre and radius in mm) touches any of the markers, and is therefore hidden."""
    return any(touches_plate(x, y, radius, plate) for plate in plates)


def touches_plate(x: float, y: float, radius: float, plate: Plate) -> bool:
    """Whether a disc touches a marker; arguments as for `under_plate`."""
    plate_x, plate_y, cos, sin = plate
    dx, dy = x - plate_x, y - plate_y
    # In the marker's own frame: distance of the centre beyond its sides, zero between them.
    ahead, aside = abs(dx * cos + dy * sin) - _HALF_LENGTH, abs(dy * cos - dx * sin) - _HALF_WIDTH
    squared = (ahead * ahead if ahead > 0.0 else 0.0) + (aside * aside if aside > 0.0 else 0.0)
    return squared <= radius * radius


def marker_outline(cos: float, sin: float) -> tuple[float, float, float]:
    """The bounding box of a marker with this heading, and its first pixel.

    Returns:
        Half the width of the box, half its height, and the distance of the topmost corner (the left one of two) to
        the right of the centre, all in pixels.
    """
    if sin < 0 or (sin == 0 and cos > 0):
        cos, sin = -cos, -sin  # the same rectangle, turned by 180 degrees so that the heading is up, or left
    # The topmost corner is now front left or front right.
    side = _HALF_WIDTH_PX if cos >= 0 else -_HALF_WIDTH_PX
    return (
        _HALF_LENGTH_PX * abs(cos) + _HALF_WIDTH_PX * sin,
        _HALF_LENGTH_PX * sin + side * cos,
        _HALF_LENGTH_PX * cos - side * sin,
    )


def in_picture(x: float, y: float, half_width: float, half_height: float) -> bool:
    """Whether an axis-aligned box lies inside the picture and clear of its border (pixels)."""
    return half_width < x < PICTURE_WIDTH - half_width and half_height < y < PICTURE_HEIGHT - half_height
