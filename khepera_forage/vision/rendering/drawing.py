"""Anti-aliased rectangles, discs and cables on a grey picture."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.shapes import PICTURE_HEIGHT, PICTURE_WIDTH

_SUPERSAMPLING = 16
"""Shapes are drawn enlarged by this factor, then reduced by averaging: edges are exact to a fiftieth of a pixel."""
_SHAPE_BITS, _CABLE_BITS = 8, 4
"""Fractional bits in the coordinates of OpenCV's drawing functions."""
_GROWTH = 0.5 / _SUPERSAMPLING
"""Pixels by which OpenCV draws shapes too large: it fills every pixel that an edge passes through."""


class ImagePose(NamedTuple):
    """Origin in pixels, x to the right and y up, heading, and scale (pixels per mm) of an object in the picture."""

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
            centre = np.round(origin * 2**_SHAPE_BITS).astype(int).tolist()
            radius = round((shape.radius * pose.scale - _GROWTH) * _SUPERSAMPLING * 2**_SHAPE_BITS)
            cv2.circle(fine, centre, radius, shape.grey, cv2.FILLED, cv2.LINE_8, _SHAPE_BITS)
        else:
            corners = origin + _SUPERSAMPLING * _corners(shape, pose, _GROWTH)
            fixed_point = np.round(corners * 2**_SHAPE_BITS).astype(np.int32)
            cv2.fillConvexPoly(fine, fixed_point, shape.grey, cv2.LINE_8, _SHAPE_BITS)
    cv2.resize(fine, (right - left, bottom - top), dst=patch, interpolation=cv2.INTER_AREA)
    picture[top:bottom, left:right] = patch


def draw_cable(
    picture: NDArray[np.uint8],
    curve: NDArray[np.float64],
    width: float,
    grey: float,
    above: tuple[Box, ImagePose] | None = None,
) -> None:
    """Draw one cable.

    Args:
        picture: 480 x 640 grey levels, changed in place.
        curve: Points of the cable: n x 2 pixels, x to the right and y up.
        width: In pixels.
        grey: Grey level of the cable.
        above: The marker above the cable, which hides it.
    """
    height, across = picture.shape
    points = np.column_stack((curve[:, 0], height - curve[:, 1])) - 0.5
    reach = math.ceil(width) + 2
    left, top = np.clip(np.floor(points.min(axis=0)) - reach, 0, (across, height)).astype(int).tolist()
    right, bottom = np.clip(np.ceil(points.max(axis=0)) + reach, 0, (across, height)).astype(int).tolist()
    if left >= right or top >= bottom:
        return
    near = np.zeros((bottom - top, right - left), np.uint8)
    line = np.round((points - (left, top)) * 2**_CABLE_BITS).astype(np.int32)
    cv2.polylines(near, [line], False, 255, reach, cv2.LINE_8, _CABLE_BITS)
    if above is not None:
        box, pose = above
        corners = _corners(box, pose) + np.array((pose.x - left, height - pose.y - top)) - 0.5
        cv2.fillConvexPoly(
            near, np.round(corners * 2**_CABLE_BITS).astype(np.int32), 0, cv2.LINE_8, _CABLE_BITS
        )
    rows, columns = near.nonzero()
    rows, columns = rows + top, columns + left
    share = _coverage(columns, rows, points, width)
    below = picture[rows, columns]
    picture[rows, columns] = np.rint(below + share * (grey - below)).astype(np.uint8)


def to_pixels(x: float, y: float) -> tuple[float, float]:
    """A position in mm as pixels, x right and y up."""
    return x / MM_PER_PIXEL, y / MM_PER_PIXEL


def _corners(box: Box, pose: ImagePose, shrink: float = 0.0) -> NDArray[np.float64]:
    """The corners of a box in the picture, from its origin: 4 x 2, columns and rows; it may shrink by some pixels."""
    x = np.array([box.x1, box.x2, box.x2, box.x1]) * pose.scale + shrink * np.array([1, -1, -1, 1])
    y = np.array([box.y1, box.y1, box.y2, box.y2]) * pose.scale + shrink * np.array([1, 1, -1, -1])
    return np.column_stack((x * pose.cos - y * pose.sin, -x * pose.sin - y * pose.cos))


def _reach(shape: Box | Disc) -> float:
    """Largest distance in mm of a point of the shape from the origin."""
    if isinstance(shape, Disc):
        return shape.radius
    return math.hypot(max(-shape.x1, shape.x2), max(-shape.y1, shape.y2))


def _coverage(
    columns: NDArray[np.int64], rows: NDArray[np.int64], line: NDArray[np.float64], width: float
) -> NDArray[np.float64]:
    """The share of each pixel that a line of some width in pixels covers; the line is m x 2 columns and rows."""
    starts, steps = line[:-1], np.diff(line, axis=0)
    squares = np.maximum((steps * steps).sum(axis=1), 1e-12)
    offset_x, offset_y = columns[:, None] - starts[:, 0], rows[:, None] - starts[:, 1]
    along = ((offset_x * steps[:, 0] + offset_y * steps[:, 1]) / squares).clip(0, 1)
    distances = (offset_x - along * steps[:, 0]) ** 2 + (offset_y - along * steps[:, 1]) ** 2
    # A pixel as a strip as wide as itself: exact for lines along rows and columns, and within 5 % for all others.
    edge = (width + 1) / 2 - np.sqrt(distances.min(axis=1))
    return edge.clip(0, min(1.0, width))  # type: ignore[no-any-return]
