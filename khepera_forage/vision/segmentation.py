"""Bright shapes of a frame: their segmentation (3.5), and centre and axes of a shape to a fraction of a pixel.

Quek's tracker takes a pixel for part of a region when it is brighter than an absolute threshold, or when it contrasts
with the background (3.5). Here only the contrast counts: the threshold of each pixel is the brightness of the floor
around it times a factor. Lamps, windows and vignetting multiply floor and paper alike, so one factor holds in every
corner and all day. The floor's brightness is the median over 56 x 56 pixels: markers and food cover less than half of
any such square. OpenCV's adaptive threshold does not fit, because it averages white objects into its background.
"""

import math
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.video import Frame

Contour = NDArray[np.int32]
"""Points of a contour in OpenCV's form: n x 1 x 2, column and row."""

_REDUCTION, _MEDIAN_SIZE = 8, 7
"""The floor is the median over 7 x 7 of these, in a frame reduced eightfold."""
_LEVELS = np.arange(256)
_BRIGHTEST_FLOOR = 215
"""Grey level of the floor above which nothing is a region: the noise would be, by the thousand."""
_MARGIN = 4
"""Pixels of floor that a patch includes on each side of its contour."""
_CROSS = np.array([[0, 1, 0], [1, 1, 1], [0, 1, 0]], np.uint8)
_SQUARE = np.ones((3, 3), np.uint8)
_PIXEL_VARIANCE = 1 / 12
"""Variance that the extent of the pixels themselves adds to the variance of a sampled shape (Sheppard's correction)."""


class Segmentation(NamedTuple):
    """The bright pixels of a frame: 255 in the mask; the floor's brightness has one value for 8 x 8 pixels."""

    frame: Frame
    floor: Frame
    mask: Frame

    def floor_at(self, column: int, row: int) -> int:
        """Brightness of the floor around a pixel."""
        rows, columns = self.floor.shape
        return int(self.floor[min(row // _REDUCTION, rows - 1), min(column // _REDUCTION, columns - 1)])


class ImagePatch(NamedTuple):
    """The part of a frame around one contour; its first pixel is in that column and row of the frame.

    `white` is the mask of bright pixels, `filled` is 255 within the contour, holes included, `floor` is the brightness
    of the floor around the shape, and `edge` tells whether the contour touches the edge of the picture.
    """

    column: int
    row: int
    grey: Frame
    white: Frame
    filled: Frame
    floor: int
    edge: bool


class ShapeMoments(NamedTuple):
    """Image moments of a shape up to the second order, on the floor (region coordinates).

    (u, v) is the centre in the picture. `major` and `minor` are the standard deviations along and across the long axis,
    whose direction is `axis` (radians, -pi/2..pi/2). Border pixels count by their share in the area, and `level` is the
    mean grey level of the bright pixels inside.
    """

    u: float
    v: float
    major: float
    minor: float
    axis: float
    area: float
    level: float


def segment(frame: Frame, contrast: float) -> Segmentation:
    """The pixels of a frame of grey levels that are `contrast` times brighter than the floor."""
    # On a floor so bright that white saturates, the threshold is at most halfway to 255.
    thresholds = np.round(np.minimum(_LEVELS * contrast, (_LEVELS + 255) / 2)).astype(np.uint8)
    thresholds[_BRIGHTEST_FLOOR:] = 255
    rows, columns = frame.shape
    small = cv2.resize(frame, (columns // _REDUCTION, rows // _REDUCTION), interpolation=cv2.INTER_AREA)
    edge = _MEDIAN_SIZE // 2
    # Reflected, so that a bright strip along the border of the picture is less than half there, too.
    padded = cv2.copyMakeBorder(small, edge, edge, edge, edge, cv2.BORDER_REFLECT_101)
    floor = np.ascontiguousarray(cv2.medianBlur(padded, _MEDIAN_SIZE)[edge:-edge, edge:-edge])
    threshold = cv2.resize(thresholds[floor], (columns, rows), interpolation=cv2.INTER_LINEAR)
    return Segmentation(frame, floor, cv2.compare(frame, threshold, cv2.CMP_GT))  # type: ignore[arg-type] # uint8


def outer_contours(mask: Frame, offset: tuple[int, int] = (0, 0)) -> list[Contour]:
    """The outer contours of all white shapes in a mask, those inside of bright rings too, with all border pixels.

    `offset` is the mask's first column and row in the picture.
    """
    contours, hierarchy = cv2.findContours(mask, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE, offset=offset)
    if not contours:
        return []
    parents = hierarchy[0, :, 3].tolist()
    return [c for c, parent in zip(contours, parents, strict=True) if parent < 0]  # type: ignore[misc] # int32


def filled_area(contour: Contour) -> float:
    """Number of pixels within a contour, border pixels included (Pick's theorem)."""
    return cv2.contourArea(contour) + len(contour) / 2 + 1


def cut_patch(segmentation: Segmentation, contour: Contour) -> ImagePatch:
    """The part of a frame around a contour, with a margin where the picture has one."""
    left, top, width, height = cv2.boundingRect(contour)
    rows, columns = segmentation.frame.shape
    column, row = max(0, left - _MARGIN), max(0, top - _MARGIN)
    part = slice(row, min(rows, top + height + _MARGIN)), slice(column, min(columns, left + width + _MARGIN))
    grey = segmentation.frame[part]
    filled = np.zeros_like(grey)
    cv2.drawContours(filled, [contour], 0, 255, cv2.FILLED, offset=(-column, -row))
    floor = segmentation.floor_at(left + width // 2, top + height // 2)
    edge = left == 0 or top == 0 or left + width == columns or top + height == rows
    return ImagePatch(column, row, grey, segmentation.mask[part], filled, floor, edge)


def shape_moments(patch: ImagePatch, mask: Frame, calibration: Calibration, height: float) -> ShapeMoments | None:
    """Moments of a shape whose mask (255 within it) is known to a pixel, at a height in mm above the floor.

    Border pixels are weighted by their brightness between floor and inside, which locates the border to a small
    fraction of a pixel. Inner pixels count in full whatever their grey level, so that holes, print and uneven light do
    not shift the centre. None for a shape without inner pixels, or no brighter than the floor.
    """
    inside, around = cv2.erode(mask, _SQUARE), cv2.dilate(mask, _CROSS)
    level = cv2.mean(patch.grey, cv2.bitwise_and(inside, patch.white))[0]
    if level <= patch.floor:
        return None
    share = cv2.convertScaleAbs(cv2.subtract(patch.grey, patch.floor), alpha=255 / (level - patch.floor))  # type: ignore[call-overload]
    moments = cv2.moments(cv2.bitwise_and(cv2.bitwise_or(share, inside), around))
    mass = moments["m00"]
    u = patch.column + moments["m10"] / mass + 0.5
    v = patch.row + moments["m01"] / mass + 0.5
    uu = moments["mu20"] / mass - _PIXEL_VARIANCE
    vv = moments["mu02"] / mass - _PIXEL_VARIANCE
    uv = moments["mu11"] / mass
    jacobian = calibration.jacobian(u, v, height)
    (xx, xy), (_, yy) = (jacobian @ np.array(((uu, uv), (uv, vv))) @ jacobian.T).tolist()  # the covariance
    mean, spread = (xx + yy) / 2, math.hypot((xx - yy) / 2, xy)
    if mean <= spread:
        return None
    axis, area = 0.5 * math.atan2(2 * xy, xx - yy), mass / 255 * calibration.scale(u, v, height) ** 2
    return ShapeMoments(u, v, math.sqrt(mean + spread), math.sqrt(mean - spread), axis, area, level)
