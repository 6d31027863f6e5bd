"""Anti-aliased rectangles and discs, given in mm, on a grey picture; edges are exact to a fiftieth of a pixel."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.shapes import PICTURE_HEIGHT, PICTURE_WIDTH

_SUPERSAMPLING = 16
"""Shapes are drawn enlarged by this factor, then reduced by averaging."""
_FRACTIONAL_BITS = 8
"""Fractional bits in the coordinates of OpenCV's drawing functions."""
_GROWTH = 0.5 / _SUPERSAMPLING
"""Pixels by which OpenCV draws shapes too large: it fills every pixel that an edge passes through."""


class ImagePose(NamedTuple):
    """Position, heading and scale of an object in the picture.

    Attributes:
        x: Origin of the object in pixels, to the right.
        y: Origin of the object in pixels, up.
        cos: Of the heading.
        sin: Of the heading.
        scale: Pixels per mm.
    """

    x: float
    y: float
    cos: float
    sin: float
    scale: float


class Box(NamedTuple):
    """A rectangle in the object's own frame (mm, x forward), and its grey level."""

    x1: float
    y1: float
    x2: float
    y2: float
    grey: float


class Disc(NamedTuple):
    """A disc around the object's origin: radius in mm, and its grey level."""

    radius: float
    grey: float


def draw_shapes(picture: NDArray[np.uint8], pose: ImagePose, shapes: Sequence[Box | Disc]) -> None:
    """Draw the shapes of one object, each over the one before it; parts outside the picture are left out.

    Args:
        picture: 480 x 640 grey levels, changed in place.
        pose: Of the object.
        shapes: Lowest first.
    """
    reach = pose.scale * max(_reach(shape) for shape in shapes) + 1.0
    row = PICTURE_HEIGHT - pose.y
    left, right = max(0, math.floor(pose.x - reach)), min(int(PICTURE_WIDTH), math.ceil(pose.x + reach))
    top, bottom = max(0, math.floor(row - reach)), min(int(PICTURE_HEIGHT), math.ceil(row + reach))
    if left >= right or top >= bottom:
        return
    patch = picture[top:bottom, left:right]
    size = ((right - left) * _SUPERSAMPLING, (bottom - top) * _SUPERSAMPLING)
    fine = cv2.resize(patch, size, interpolation=cv2.INTER_NEAREST)
    # OpenCV's integer coordinates are the middles of pixels, ours their lower left corners.
    origin = np.array([pose.x - left, row - top]) * _SUPERSAMPLING - 0.5
    for shape in shapes:
        if isinstance(shape, Disc):
            centre = np.round(origin * 2**_FRACTIONAL_BITS).astype(int).tolist()
            radius = round((shape.radius * pose.scale - _GROWTH) * _SUPERSAMPLING * 2**_FRACTIONAL_BITS)
            cv2.circle(fine, centre, radius, shape.grey, cv2.FILLED, cv2.LINE_8, _FRACTIONAL_BITS)
        else:
            corners = origin + _SUPERSAMPLING * _shrunk_corners(shape, pose)
            fixed_point = np.round(corners * 2**_FRACTIONAL_BITS).astype(np.int32)
            cv2.fillConvexPoly(fine, fixed_point, shape.grey, cv2.LINE_8, _FRACTIONAL_BITS)
    cv2.resize(fine, (right - left, bottom - top), dst=patch, interpolation=cv2.INTER_AREA)
    picture[top:bottom, left:right] = patch


def box_corners(box: Box, pose: ImagePose) -> NDArray[np.float64]:
    """The corners of a box in the picture: 4 x 2, column and row in OpenCV's pixel coordinates."""
    x = np.array([box.x1, box.x2, box.x2, box.x1]) * pose.scale
    y = np.array([box.y1, box.y1, box.y2, box.y2]) * pose.scale
    return np.column_stack(
        (
            pose.x + x * pose.cos - y * pose.sin - 0.5,
            PICTURE_HEIGHT - pose.y - x * pose.sin - y * pose.cos - 0.5,
        )
    )


def to_pixels(x: float, y: float) -> tuple[float, float]:
    """A position in mm as pixels, x right and y up."""
    return x / MM_PER_PIXEL, y / MM_PER_PIXEL


def _shrunk_corners(box: Box, pose: ImagePose) -> NDArray[np.float64]:
    """Corners around the origin in pixels, y down, moved inwards by what OpenCV draws too large."""
    x1, x2 = box.x1 * pose.scale + _GROWTH, box.x2 * pose.scale - _GROWTH
    y1, y2 = box.y1 * pose.scale + _GROWTH, box.y2 * pose.scale - _GROWTH
    c, s = pose.cos, pose.sin
    corners = ((x1, y1), (x2, y1), (x2, y2), (x1, y2))
    return np.array([(x * c - y * s, -x * s - y * c) for x, y in corners])


def _reach(shape: Box | Disc) -> float:
    """Largest distance in mm of a point of the shape from the origin."""
    if isinstance(shape, Disc):
        return shape.radius
    return max(math.hypot(x, y) for x in (shape.x1, shape.x2) for y in (shape.y1, shape.y2))
