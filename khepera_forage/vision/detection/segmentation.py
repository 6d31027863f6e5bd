"""From a grey frame to bright outlines: the threshold, and the contours with their hierarchy (3.5).

Quek's tracker takes a pixel for part of a region when it is brighter than an absolute threshold, or when it
contrasts with the background (3.5). Here it is the contrast alone: the threshold of each pixel is the brightness of the
floor around it times a factor. Lamps, windows and the lens' vignette multiply floor and paper alike, so one factor
holds in every corner and all day, where an absolute threshold would need to be set anew. The floor's brightness is the
median over 56 x 56 pixels of a picture shrunk eightfold: markers and food are less than half of any such square. That
costs a fifth of a millisecond; OpenCV's adaptive threshold averages what is white into its background.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.vision.shapes import PICTURE_HEIGHT, PICTURE_WIDTH

Frame = NDArray[np.uint8]
Contour = NDArray[np.int32]
"""Points of a contour as OpenCV has them: n x 1 x 2, column and row."""

SHAPE = (int(PICTURE_HEIGHT), int(PICTURE_WIDTH))
"""Rows and columns of a frame (3.4)."""
_SHRINK = 8
_MEDIAN = 7
_LEVELS = np.arange(256)


class Bright(NamedTuple):
    """What is bright in a frame.

    Attributes:
        frame: The frame itself, 480 x 640.
        floor: Brightness of the floor, one value for 8 x 8 pixels of the frame.
        mask: 255 where the frame is clearly brighter than the floor, otherwise 0.
    """

    frame: Frame
    floor: Frame
    mask: Frame

    def floor_at(self, column: int, row: int) -> int:
        """Brightness of the floor around a pixel."""
        return int(self.floor[row // _SHRINK, column // _SHRINK])


class Segmenter:
    """Finds what is bright, with one table of thresholds for all frames.

    Args:
        contrast: How many times brighter than the floor.
    """

    def __init__(self, contrast: float) -> None:
        # Where the floor itself is so bright that white saturates, the threshold goes no higher than halfway to 255.
        levels = np.minimum(_LEVELS * contrast, (_LEVELS + 255) / 2)
        self._thresholds = np.round(levels).astype(np.uint8)

    def segment(self, frame: Frame) -> Bright:
        """What is bright in a frame.

        Raises:
            ValueError: A frame that is not 480 x 640 grey levels.
        """
        import cv2

        if frame.shape != SHAPE or frame.dtype != np.uint8:
            raise ValueError(
                f"frame is {frame.shape} of {frame.dtype}; allowed: {SHAPE} of uint8 grey levels"
            )
        rows, columns = SHAPE
        small = cv2.resize(frame, (columns // _SHRINK, rows // _SHRINK), interpolation=cv2.INTER_AREA)
        floor = cv2.medianBlur(small, _MEDIAN)
        threshold = cv2.resize(self._thresholds[floor], (columns, rows), interpolation=cv2.INTER_LINEAR)
        mask = cv2.compare(frame, threshold, cv2.CMP_GT)
        return Bright(frame, floor, mask)  # type: ignore[arg-type] # all uint8


def outer_contours(mask: Frame) -> list[Contour]:
    """The outer contours of everything white in a mask, each a list of all its border pixels.

    The hierarchy has two levels, outer borders and the holes in them, so that things inside a bright ring (a walled
    arena with white walls) are found like any others.
    """
    import cv2

    contours, hierarchy = cv2.findContours(mask, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    if not contours:
        return []
    parents = hierarchy[0, :, 3].tolist()
    return [c for c, parent in zip(contours, parents, strict=True) if parent < 0]  # type: ignore[misc] # int32
