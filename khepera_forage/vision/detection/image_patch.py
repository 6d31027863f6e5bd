"""The part of a frame around one contour, and centre and axes of the shape in it to a fraction of a pixel."""

import math
from typing import NamedTuple

import numpy as np

from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.detection.segmentation import Contour, Frame, Segmentation

_MARGIN = 4
"""Pixels of floor that a patch includes on each side of its contour."""
_CROSS = np.array([[0, 1, 0], [1, 1, 1], [0, 1, 0]], np.uint8)
_SQUARE = np.ones((3, 3), np.uint8)
_PIXEL_VARIANCE = 1 / 12
"""Variance that the extent of the pixels themselves adds to the variance of a sampled shape (Sheppard's correction)."""


class ImagePatch(NamedTuple):
    """The part of a frame around one contour.

    Attributes:
        column: Column of the frame at the patch's left side.
        row: Row of the frame at the patch's top.
        grey: Grey levels within the patch; read only.
        frame: Grey levels of the whole frame, for what lies beyond the patch; read only.
        white: Mask of bright pixels from the segmentation, before gaps were closed.
        filled: 255 within the contour, holes included.
        floor: Brightness of the floor around the shape.
        edge: Whether the contour touches the edge of the picture.
    """

    column: int
    row: int
    grey: Frame
    frame: Frame
    white: Frame
    filled: Frame
    floor: int
    edge: bool


class ShapeMoments(NamedTuple):
    """Position, size and orientation of a shape: image moments up to the second order, in region coordinates.

    Attributes:
        u: Centre in the picture.
        v: Centre in the picture.
        x: Centre on the floor.
        y: Centre on the floor.
        major: Standard deviation of the shape along its long axis, in region pixels.
        minor: Standard deviation across the long axis, in region pixels.
        axis: Direction of the long axis in radians, -pi/2..pi/2.
        area: In square region pixels; border pixels count by their share.
        level: Mean grey level of the bright pixels inside the shape.
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


def cut_patch(segmentation: Segmentation, contour: Contour) -> ImagePatch:
    """The part of a frame around a contour, with a margin where the picture has one."""
    import cv2

    left, top, width, height = cv2.boundingRect(contour)
    rows, columns = segmentation.frame.shape
    column, row = max(0, left - _MARGIN), max(0, top - _MARGIN)
    right, bottom = min(columns, left + width + _MARGIN), min(rows, top + height + _MARGIN)
    filled = np.zeros((bottom - row, right - column), np.uint8)
    cv2.drawContours(filled, [contour], 0, 255, cv2.FILLED, offset=(-column, -row))
    return ImagePatch(
        column,
        row,
        segmentation.frame[row:bottom, column:right],
        segmentation.frame,
        segmentation.mask[row:bottom, column:right],
        filled,
        segmentation.floor_at(left + width // 2, top + height // 2),
        left == 0 or top == 0 or left + width == columns or top + height == rows,
    )


def shape_moments(
    patch: ImagePatch, mask: Frame, calibration: Calibration, height: float
) -> ShapeMoments | None:
    """Moments of a shape whose mask is known to a pixel.

    Args:
        patch: Contains the shape.
        mask: 255 within the shape, of the patch's size.
        calibration: From the picture to the floor.
        height: Of the shape above the floor in mm.

    Returns:
        None for a shape without inner pixels, or no brighter than the floor.
    """
    import cv2

    return weighted_moments(
        patch,
        cv2.erode(mask, _SQUARE),  # type: ignore[arg-type] # uint8
        cv2.dilate(mask, _CROSS),  # type: ignore[arg-type] # uint8
        calibration,
        height,
    )


def weighted_moments(
    patch: ImagePatch, inside: Frame, around: Frame, calibration: Calibration, height: float
) -> ShapeMoments | None:
    """Moments of a shape whose border runs between two masks.

    Border pixels are weighted by their brightness between floor and inside, which locates the border to a small
    fraction of a pixel. Inner pixels count in full whatever their grey level, so that holes, print and uneven light do
    not shift the centre.

    Args:
        patch: Contains the shape.
        inside: 255 where the shape certainly is.
        around: 255 where the shape may be.
        calibration: From the picture to the floor.
        height: Of the shape above the floor in mm.

    Returns:
        None for a shape without inner pixels, or no brighter than the floor.
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
    # The covariance in region coordinates is J C J^T.
    xu, xv, yu, yv = calibration.jacobian(u, v, height)
    xx = xu * xu * uu + 2 * xu * xv * uv + xv * xv * vv
    yy = yu * yu * uu + 2 * yu * yv * uv + yv * yv * vv
    xy = xu * yu * uu + (xu * yv + xv * yu) * uv + xv * yv * vv
    mean, spread = (xx + yy) / 2, math.hypot((xx - yy) / 2, xy)
    if mean <= spread:
        return None
    x, y = calibration.to_region(u, v, height)
    axis = 0.5 * math.atan2(2 * xy, xx - yy)
    area = mass / 255 * abs(xu * yv - xv * yu)
    return ShapeMoments(u, v, x, y, math.sqrt(mean + spread), math.sqrt(mean - spread), axis, area, level)
