"""Robots' markers: from a bright shape to pose and number of holes (figures 3.8, 3.9)."""

import math
from typing import NamedTuple

import numpy as np

from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.detection.hole_detector import SAMPLE, HoleDetector
from khepera_forage.vision.detection.image_patch import (
    ImagePatch,
    ShapeMoments,
    shape_moments,
    weighted_moments,
)
from khepera_forage.vision.detection.segmentation import Frame
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.shapes import PICTURE_HEIGHT, PICTURE_WIDTH
from khepera_forage.vision.tracker_settings import TrackerSettings

_MIN_HOLE_OFFSET = 5.0
"""mm by which the holes must be off the middle to tell front from back."""
_SQUARE = np.ones((3, 3), np.uint8)
_BORDER_MARGIN = 6.0
"""mm on either side of its expected position within which the marker's border is searched."""
_MAX_REFINEMENTS = 4
"""Greatest number of times the border is searched around the last estimate."""
_CONVERGED = 0.02
"""Radians, or shares of the marker's size, below which another refinement changes nothing."""
_MIN_AREA = 0.8
"""Share of a marker's area that must be seen in one piece; with one side cut off, its centre is not known."""
_MAX_OUTSIDE = 1.0
"""Pixels by which a corner may lie outside the picture."""
_MIN_FILL = 0.7
"""Least share of the rectangle with the same moments that a marker fills."""
_OPENING = 1.3
"""In diameters of food: shapes that stick out from a marker and are narrower than this are not part of it."""


class DetectedMarker(NamedTuple):
    """A marker in a frame.

    Attributes:
        moments: Centre and axes.
        heading: Radians.
        front_known: Whether the holes tell front from back; if not, `heading` may be off by 180 degrees.
        holes: Number of holes.
        holes_area: In square region pixels.
        mask: 255 within the marker, of the patch's size.
    """

    moments: ShapeMoments
    heading: float
    front_known: bool
    holes: int
    holes_area: float
    mask: Frame


class MarkerDetector:
    """Distinguishes markers from other bright shapes, and measures their pose and holes.

    Args:
        settings: Sizes and tolerances.
        calibration: From the picture to the floor.
        scale: Approximate number of picture pixels per mm.
    """

    def __init__(self, settings: TrackerSettings, calibration: Calibration, scale: float) -> None:
        import cv2

        self._settings, self._calibration = settings, calibration
        diameter = max(3, round(_OPENING * 2 * settings.food_radius * scale))
        self._opening_kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (diameter, diameter))
        # Standard deviations of a rectangle are its sides over the root of 12.
        self._major = settings.marker_length / MM_PER_PIXEL / math.sqrt(12)
        self._minor = settings.marker_width / MM_PER_PIXEL / math.sqrt(12)
        self._area = settings.marker_length * settings.marker_width / MM_PER_PIXEL**2
        self._holes = HoleDetector(settings)

    def detect(self, patch: ImagePatch) -> DetectedMarker | None:
        """The marker in a patch.

        Returns:
            None for anything else, or for a marker whose pose or number of holes is uncertain.
        """
        import cv2

        # Closing fills notches; opening removes whatever is narrower than the kernel (food at the rim, a cable).
        closed = cv2.morphologyEx(patch.filled, cv2.MORPH_CLOSE, _SQUARE)
        mask: Frame = cv2.morphologyEx(closed, cv2.MORPH_OPEN, self._opening_kernel)  # type: ignore[assignment]
        estimate = shape_moments(patch, mask, self._calibration, self._settings.marker_height)
        if estimate is None or not self._has_marker_size(estimate):
            return None
        moments = self._refined(patch, estimate)
        if moments is None or (patch.edge and self._is_cut_off(moments)):
            return None
        holes = self._holes.detect(self._rectified(patch, moments), moments.level)
        if holes is None:
            return None
        heading = moments.axis if holes.offset >= 0 else moments.axis + math.pi
        front_known = abs(holes.offset) >= _MIN_HOLE_OFFSET
        return DetectedMarker(moments, heading, front_known, holes.number, holes.area, mask)

    def _has_marker_size(self, moments: ShapeMoments) -> bool:
        tolerance = self._settings.tolerance
        return (
            moments.area >= _MIN_AREA * self._area
            and moments.area >= _MIN_FILL * 12 * moments.major * moments.minor
            and abs(moments.major / self._major - 1) <= tolerance
            and abs(moments.minor / self._minor - 1) <= tolerance
        )

    def _refined(self, patch: ImagePatch, moments: ShapeMoments) -> ShapeMoments | None:
        """Moments that use only pixels near the border of a marker at the estimated pose, corners included.

        The first estimate may be off by ten degrees when food touches the marker; it then takes a few iterations.
        """
        for _ in range(_MAX_REFINEMENTS):
            inside, around = (
                self._marker_mask(patch, moments, margin) for margin in (-_BORDER_MARGIN, _BORDER_MARGIN)
            )
            better = weighted_moments(patch, inside, around, self._calibration, self._settings.marker_height)
            if better is None:
                return None
            turned = abs(math.remainder(better.axis - moments.axis, math.pi))
            shifted = math.hypot(better.x - moments.x, better.y - moments.y)
            moments = better
            if turned < _CONVERGED and shifted < _CONVERGED * self._major:
                break
        return moments

    def _corners(self, moments: ShapeMoments, margin: float) -> list[tuple[float, float]]:
        """Corners in the picture of a marker at that pose, enlarged on all sides by a margin in mm."""
        along, across = self._steps(moments, 1.0)
        length, width = self._settings.marker_length / 2 + margin, self._settings.marker_width / 2 + margin
        return [
            (
                moments.u + a * length * along[0] + b * width * across[0],
                moments.v + a * length * along[1] + b * width * across[1],
            )
            for a, b in ((1, 1), (-1, 1), (-1, -1), (1, -1))
        ]

    def _is_cut_off(self, moments: ShapeMoments) -> bool:
        """Whether the picture's edge cuts off so much of a marker that it would be measured shifted and turned."""
        return not all(
            -_MAX_OUTSIDE <= u <= PICTURE_WIDTH + _MAX_OUTSIDE
            and -_MAX_OUTSIDE <= v <= PICTURE_HEIGHT + _MAX_OUTSIDE
            for u, v in self._corners(moments, 0.0)
        )

    def _marker_mask(self, patch: ImagePatch, moments: ShapeMoments, margin: float) -> Frame:
        """255 within a marker at that pose, enlarged on all sides by a margin in mm."""
        import cv2

        corners = [(u - 0.5 - patch.column, v - 0.5 - patch.row) for u, v in self._corners(moments, margin)]
        mask = np.zeros_like(patch.filled)
        cv2.fillConvexPoly(mask, np.rint(np.multiply(corners, 16)).astype(np.int32), 255, cv2.LINE_8, 4)
        return mask

    def _steps(self, moments: ShapeMoments, length: float) -> tuple[tuple[float, float], tuple[float, float]]:
        """A step of this length (mm) along the marker and one to its left, in pixels of the picture."""
        xu, xv, yu, yv = self._calibration.jacobian(moments.u, moments.v, self._settings.marker_height)
        length /= MM_PER_PIXEL * (xu * yv - xv * yu)  # through the inverse of the Jacobian
        cos, sin = math.cos(moments.axis) * length, math.sin(moments.axis) * length
        return (yv * cos - xv * sin, xu * sin - yu * cos), (-yv * sin - xv * cos, xu * cos + yu * sin)

    def _rectified(self, patch: ImagePatch, moments: ShapeMoments) -> Frame:
        """The marker rotated upright, one sample per 2.5 mm: column 0 at one end, row 0 at its right side."""
        import cv2

        along, across = self._steps(moments, SAMPLE)
        middle = ((self._holes.columns - 1) / 2, (self._holes.rows - 1) / 2)
        start_u = moments.u - 0.5 - patch.column - along[0] * middle[0] - across[0] * middle[1]
        start_v = moments.v - 0.5 - patch.row - along[1] * middle[0] - across[1] * middle[1]
        affine = np.array([[along[0], across[0], start_u], [along[1], across[1], start_v]])
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        return cv2.warpAffine(patch.grey, affine, (self._holes.columns, self._holes.rows), flags=flags)  # type: ignore[return-value]
