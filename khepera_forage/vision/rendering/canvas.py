"""Drawing in millimetres on a picture, with smooth edges that are true to a fiftieth of a pixel."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.shapes import PICTURE_HEIGHT, PICTURE_WIDTH

_FINER = 16
"""A patch of the picture is drawn so many times finer, then shrunk by averaging."""
_BITS = 8
"""Fractional bits in the coordinates of OpenCV's drawing functions."""
_GROWTH = 0.5 / _FINER
"""Pixels by which those functions draw everything too large: they fill every pixel that an edge passes through."""


class Place(NamedTuple):
    """Where a thing lies in the picture: its origin in pixels (x right, y up), its direction, and its size.

    Attributes:
        x: Pixels.
        y: Pixels.
        cos: Of its heading.
        sin: Of its heading.
        scale: Pixels a millimetre.
    """

    x: float
    y: float
    cos: float
    sin: float
    scale: float


class Box(NamedTuple):
    """An upright rectangle in a thing's own frame, mm, and its grey level."""

    x1: float
    y1: float
    x2: float
    y2: float
    grey: float


class Disc(NamedTuple):
    """A disc about a thing's origin: radius in mm, and its grey level."""

    radius: float
    grey: float


def draw(picture: NDArray[np.uint8], place: Place, parts: Sequence[Box | Disc]) -> None:
    """Draw a thing on a picture, its parts one over the other; what lies outside the picture is left out.

    Args:
        picture: 480 x 640 grey levels, changed in place.
        place: Where the thing lies.
        parts: Lowest first.
    """
    reach = place.scale * max(_reach(part) for part in parts) + 1.0
    row = PICTURE_HEIGHT - place.y
    left, right = max(0, math.floor(place.x - reach)), min(int(PICTURE_WIDTH), math.ceil(place.x + reach))
    top, bottom = max(0, math.floor(row - reach)), min(int(PICTURE_HEIGHT), math.ceil(row + reach))
    if left >= right or top >= bottom:
        return
    patch = picture[top:bottom, left:right]
    size = ((right - left) * _FINER, (bottom - top) * _FINER)
    fine = cv2.resize(patch, size, interpolation=cv2.INTER_NEAREST)
    # OpenCV's integer coordinates are the middles of pixels, ours their lower left corners.
    origin = np.array([place.x - left, row - top]) * _FINER - 0.5
    for part in parts:
        if isinstance(part, Disc):
            spot = np.round(origin * 2**_BITS).astype(int).tolist()
            radius = round((part.radius * place.scale - _GROWTH) * _FINER * 2**_BITS)
            cv2.circle(fine, spot, radius, part.grey, cv2.FILLED, cv2.LINE_8, _BITS)
        else:
            corners = origin + _FINER * _corners(part, place)
            fixed = np.round(corners * 2**_BITS).astype(np.int32)
            cv2.fillConvexPoly(fine, fixed, part.grey, cv2.LINE_8, _BITS)
    cv2.resize(fine, (right - left, bottom - top), dst=patch, interpolation=cv2.INTER_AREA)
    picture[top:bottom, left:right] = patch


def corners_of(box: Box, place: Place) -> NDArray[np.float64]:
    """The corners of a box in the picture: 4 x 2, column and row as continuous coordinates of OpenCV's pixels."""
    x = np.array([box.x1, box.x2, box.x2, box.x1]) * place.scale
    y = np.array([box.y1, box.y1, box.y2, box.y2]) * place.scale
    return np.column_stack(
        (
            place.x + x * place.cos - y * place.sin - 0.5,
            PICTURE_HEIGHT - place.y - x * place.sin - y * place.cos - 0.5,
        )
    )


def _corners(box: Box, place: Place) -> NDArray[np.float64]:
    """Corners about the origin in pixels, y down, drawn in by what OpenCV draws too large."""
    x1, x2 = box.x1 * place.scale + _GROWTH, box.x2 * place.scale - _GROWTH
    y1, y2 = box.y1 * place.scale + _GROWTH, box.y2 * place.scale - _GROWTH
    c, s = place.cos, place.sin
    corners = ((x1, y1), (x2, y1), (x2, y2), (x1, y2))
    return np.array([(x * c - y * s, -x * s - y * c) for x, y in corners])


def _reach(part: Box | Disc) -> float:
    if isinstance(part, Disc):
        return part.radius
    return max(math.hypot(x, y) for x in (part.x1, part.x2) for y in (part.y1, part.y2))


def pixels(x: float, y: float) -> tuple[float, float]:
    """A place in mm as pixels, x right and y up."""
    return x / MM_PER_PIXEL, y / MM_PER_PIXEL
