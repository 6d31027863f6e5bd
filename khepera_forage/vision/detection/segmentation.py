"""Segmentation: from a grey frame to a mask of bright pixels, and the contours of that mask (3.5).

Quek's tracker takes a pixel for part of a region when it is brighter than an absolute threshold, or when it contrasts
with the background (3.5). Here only the contrast counts: the threshold of each pixel is the brightness of the floor
around it times a factor. Lamps, windows and vignetting multiply floor and paper alike, so one factor holds in every
corner and all day, whereas an absolute threshold would have to be adjusted. The floor's brightness is the median over
56 x 56 pixels of a frame reduced eightfold: markers and food cover less than half of any such square. OpenCV's adaptive
threshold does not fit, because it averages white objects into its background.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Frame = NDArray[np.uint8]
Contour = NDArray[np.int32]
"""Points of a contour in OpenCV's form: n x 1 x 2, column and row."""

_REDUCTION = 8
_MEDIAN_SIZE = 7
_LEVELS = np.arange(256)
_BRIGHTEST_FLOOR = 215
"""Grey level of the floor above which nothing is a region: the noise would be, by the thousand."""


class Segmentation(NamedTuple):
    """The bright pixels of a frame.

    Attributes:
        frame: The frame, grey levels.
        floor: Brightness of the floor, one value for 8 x 8 pixels of the frame.
        mask: 255 where the frame is clearly brighter than the floor, otherwise 0.
    """

    frame: Frame
    floor: Frame
    mask: Frame

    def floor_at(self, column: int, row: int) -> int:
        """Brightness of the floor around a pixel."""
        rows, columns = self.floor.shape
        return int(self.floor[min(row // _REDUCTION, rows - 1), min(column // _REDUCTION, columns - 1)])


class Segmenter:
    """Segments frames with one table of thresholds, indexed by the floor's brightness.

    Args:
        contrast: How many times brighter than the floor a bright pixel is.
    """

    def __init__(self, contrast: float) -> None:
        # On a floor so bright that white saturates, the threshold is at most halfway to 255.
        levels = np.minimum(_LEVELS * contrast, (_LEVELS + 255) / 2)
        self._thresholds = np.round(levels).astype(np.uint8)
        self._thresholds[_BRIGHTEST_FLOOR:] = 255

    def segment(self, frame: Frame) -> Segmentation:
        """The bright pixels of a frame of grey levels."""
        import cv2

        rows, columns = frame.shape
        small = cv2.resize(frame, (columns // _REDUCTION, rows // _REDUCTION), interpolation=cv2.INTER_AREA)
        floor = cv2.medianBlur(small, _MEDIAN_SIZE)
        threshold = cv2.resize(self._thresholds[floor], (columns, rows), interpolation=cv2.INTER_LINEAR)
        mask = cv2.compare(frame, threshold, cv2.CMP_GT)
        return Segmentation(frame, floor, mask)  # type: ignore[arg-type] # all uint8


def as_grey(frame: Frame) -> Frame:
    """A frame as grey levels: itself, or the brightness of its colours (blue, green, red, as OpenCV has them).

    Raises:
        ValueError: Anything else.
    """
    import cv2

    if frame.dtype != np.uint8 or frame.ndim not in (2, 3) or frame.shape[2:] not in ((), (1,), (3,)):
        raise ValueError(
            f"frame is {frame.shape} of {frame.dtype}; allowed: rows x columns of uint8 grey levels, or x 3 colours"
        )
    if frame.ndim == 2:
        return frame
    return frame[:, :, 0] if frame.shape[2] == 1 else cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)  # type: ignore[return-value]


def outer_contours(mask: Frame) -> list[Contour]:
    """The outer contours of all white shapes in a mask, each with all its border pixels.

    The contour hierarchy has two levels, outer borders and the holes in them. Shapes inside a bright ring (an arena
    with white walls) therefore have outer contours too.
    """
    import cv2

    contours, hierarchy = cv2.findContours(mask, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    if not contours:
        return []
    parents = hierarchy[0, :, 3].tolist()
    return [c for c, parent in zip(contours, parents, strict=True) if parent < 0]  # type: ignore[misc] # int32
