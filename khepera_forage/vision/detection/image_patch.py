"""A bright shape cut out of a frame, and its centre and axes to a fraction of a pixel."""

import math
from typing import NamedTuple

import numpy as np

from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.detection.segmentation import SHAPE, Bright, Contour, Frame

_MARGIN = 4
"""Pixels of floor that a patch shows on each side of its shape."""
_CROSS = np.array([[0, 1, 0], [1, 1, 1], [0, 1, 0]], np.uint8)
_SQUARE = np.ones((3, 3), np.uint8)
_PIXEL_VARIANCE = 1 / 12
"""What the pixels' own extent adds to the variance of a shape that they sample (Sheppard's correction)."""


class Patch(NamedTuple):
    """Part of a frame around one outline.

    Attributes:
        column: Of the frame, at the patch's left side.
        row: Of the frame, at the patch's top.
        grey: Part of the frame; not to be written to.
        white: The same part of what is bright, before gaps were closed.
        filled: 255 within the outline, holes included.
        floor: Brightness of the floor around the shape.
        edge: Whether the outline touches the edge of the picture.
    """

    column: int
    row: int
    grey: Frame
    white: Frame
    filled: Frame
    floor: int
    edge: bool


class Form(NamedTuple):
    """Where a shape is, how large and which way it lies: moments up to the second, in region coordinates.

    Attributes:
        u: Centre in the picture.
        v: Centre in the picture.
        x: Centre on the floor.
        y: Centre on the floor.
        major: Standard deviation of the shape along its long axis, in region pixels.
        minor: Across.
        axis: Direction of the long axis in radians, -pi/2..pi/2.
        area: In square region pixels, border pixels by their share.
        level: Mean grey level of the inside, where it is bright.
    """

    u: float
    v: float
    x: float
    y: float
    major: float
    minor: float
    axis: float
    area: float
    level: float


def cut(bright: Bright, outline: Contour) -> Patch:
    """The part of a frame around an outline, with a margin where the picture has one."""
    import cv2

    left, top, width, height = cv2.boundingRect(outline)
    rows, columns = SHAPE
    column, row = max(0, left - _MARGIN), max(0, top - _MARGIN)
    right, bottom = min(columns, left + width + _MARGIN), min(rows, top + height + _MARGIN)
    filled = np.zeros((bottom - row, right - column), np.uint8)
    cv2.drawContours(filled, [outline], 0, 255, cv2.FILLED, offset=(-column, -row))
    return Patch(
        column,
        row,
        bright.frame[row:bottom, column:right],
        bright.mask[row:bottom, column:right],
        filled,
        bright.floor_at(left + width // 2, top + height // 2),
        left == 0 or top == 0 or left + width == columns or top + height == rows,
    )


def form(patch: Patch, shape: Frame, calibration: Calibration, height: float) -> Form | None:
    """Centre and axes of a shape in a patch, given to a pixel.

    Args:
        patch: Where it is.
        shape: 255 within the shape, of the patch's size.
        calibration: From the picture to the floor.
        height: Of the shape above the floor in mm.

    Returns:
        None for a shape so thin that it has no inside, or no brighter than the floor.
    """
    import cv2

    return weighed(patch, cv2.erode(shape, _SQUARE), cv2.dilate(shape, _CROSS), calibration, height)  # type: ignore[arg-type] # uint8


def weighed(
    patch: Patch, inside: Frame, around: Frame, calibration: Calibration, height: float
) -> Form | None:
    """Centre and axes of a shape whose border runs between two masks.

    Pixels on its border count by how bright they are between floor and inside, which tells to a small part of a
    pixel where the border runs; pixels inside count in full whatever their grey level, so that holes, print and uneven
    light do not move the centre.

    Args:
        patch: Where it is.
        inside: 255 where the shape is for certain.
        around: 255 where it may be.
        calibration: From the picture to the floor.
        height: Of the shape above the floor in mm.

    Returns:
        None for a shape that has no inside, or no brighter than the floor.
    """
    import cv2

    level = cv2.mean(patch.grey, cv2.bitwise_and(inside, patch.white))[0]
    if level <= patch.floor:
        return None
    share = cv2.convertScaleAbs(cv2.subtract(patch.grey, patch.floor), alpha=255 / (level - patch.floor))  # type: ignore[call-overload]
    weights = cv2.bitwise_and(cv2.bitwise_or(share, inside), around)
    moments = cv2.moments(weights)
    mass = moments["m00"]
    u = patch.column + moments["m10"] / mass + 0.5
    v = patch.row + moments["m01"] / mass + 0.5
    uu = moments["mu20"] / mass - _PIXEL_VARIANCE
    vv = moments["mu02"] / mass - _PIXEL_VARIANCE
    uv = moments["mu11"] / mass
    xu, xv, yu, yv = calibration.stretch(u, v, height)
    xx = xu * xu * uu + 2 * xu * xv * uv + xv * xv * vv
    yy = yu * yu * uu + 2 * yu * yv * uv + yv * yv * vv
    xy = xu * yu * uu + (xu * yv + xv * yu) * uv + xv * yv * vv
    mean, spread = (xx + yy) / 2, math.hypot((xx - yy) / 2, xy)
    if mean <= spread:
        return None
    x, y = calibration.to_region(u, v, height)
    axis = 0.5 * math.atan2(2 * xy, xx - yy)
    area = mass / 255 * abs(xu * yv - xv * yu)
    return Form(u, v, x, y, math.sqrt(mean + spread), math.sqrt(mean - spread), axis, area, level)
