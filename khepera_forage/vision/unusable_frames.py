"""Frames that show no scene: black, overexposed, or without a signal."""

import numpy as np

from khepera_forage.vision.detection.segmentation import Frame
from khepera_forage.vision.image_quality import FLOOR_LIMITS, measure_quality
from khepera_forage.vision.tracker import Tracker

_REDUCTION = 4
"""Pixels are averaged in squares of this side: less noise, and markers and food remain."""
_LEAST_RANGE = 20
"""Grey levels between the darkest and the brightest square of a scene with a marker or food, which is white."""


def is_well_exposed(frame: Frame) -> bool:
    """Whether the grey level of the floor is within its limits."""
    low, high = FLOOR_LIMITS
    return bool(low <= np.median(frame[::_REDUCTION, ::_REDUCTION]) <= high)


def why_unusable(frame: Frame, tracker: Tracker, strict: bool) -> str:
    """Why a frame shows no scene, and what to change; empty for a usable frame.

    Args:
        frame: 480 x 640 grey levels.
        tracker: Finds markers.
        strict: Whether a frame beyond the limits of exposure is unusable, as it is after a sudden change: food may be
            invisible. Otherwise it is usable if the tracker finds a marker in it.
    """
    import cv2

    rows, columns = frame.shape
    squares = cv2.resize(frame, (columns // _REDUCTION, rows // _REDUCTION), interpolation=cv2.INTER_AREA)
    darkest, brightest = int(squares.min()), int(squares.max())
    if brightest - darkest < _LEAST_RANGE:
        return f"shows nothing: all grey levels are {darkest} to {brightest}"
    if is_well_exposed(frame) or not (strict or not any(found.holes for found in tracker.detect(frame))):
        return ""
    warning = measure_quality(tracker.reduced(frame)).warnings(tracker.settings).get("exposure", "")
    return warning and f"is {warning}"
