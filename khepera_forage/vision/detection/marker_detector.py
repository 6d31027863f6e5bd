"""Robots' markers: from a bright shape to pose and number of holes (figures 3.8, 3.9)."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from khepera_forage.robots.khepera import MARKER_LENGTH
from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.detection.hole_pattern import SAMPLE, HolePattern
from khepera_forage.vision.detection.image_patch import ImagePatch, ShapeMoments, shape_moments
from khepera_forage.vision.detection.rectangle_fit import RectangleFit
from khepera_forage.vision.detection.segmentation import Contour, Frame
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.shapes import GRID_HOLES, GRID_SIDE, HOLE_SIDE, MARKER_HOLES
from khepera_forage.vision.tracker_settings import TrackerSettings

_SQUARE = np.ones((3, 3), np.uint8)
_MAX_REPEATS = 3
"""Greatest number of times the border is searched around the last estimate."""
_CONVERGED = 0.5
"""Region pixels, at the corners, below which another search changes nothing."""
_SEEN_SIZE = 0.97
"""Size of a marker's white as a share of its true size: its frame and blur take a few percent."""
_SAME_SHAPE, _OTHER_SIZE = 0.05, 0.06
"""Difference between the shares of length and width up to which all of a marker is seen; and the relative difference
in size from which a marker is searched for at its own size."""
_MIN_AREA = 0.6
"""Share of a marker's area that must be seen."""
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
        holes: Number of holes, or of the marker; 0 if it is uncertain.
        holes_area: In square region pixels.
        mask: 255 within the marker, of the patch's size.
        trouble: Why the marker is uncertain; empty if it is not.
    """

    moments: ShapeMoments
    heading: float
    holes: int
    holes_area: float
    mask: Frame
    trouble: str


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
        self._border = RectangleFit(
            settings.marker_length / MM_PER_PIXEL, settings.marker_width / MM_PER_PIXEL
        )
        arrangements, side = (
            (GRID_HOLES, GRID_SIDE) if settings.markers == "grid" else (MARKER_HOLES, HOLE_SIDE)
        )
        self._pattern = HolePattern(
            {
                n: holes
                for n, holes in arrangements.items()
                if n in settings.numbers or settings.markers == "tags"
            },
            settings.hole_side * side / HOLE_SIDE,
            settings.marker_length,
            settings.marker_width,
            settings.marker_length / MARKER_LENGTH,
        )

    def detect(self, patch: ImagePatch, joined: bool) -> DetectedMarker | None:
        """The marker in a patch.

        Args:
            patch: Contains the shape.
            joined: Whether the shape results from joining pieces. The border of a single piece must fit exactly: a part
                of a marker would fit loosely at a wrong place.

        Returns:
            None for anything else, or for a marker whose pose is uncertain.
        """
        import cv2

        # Closing fills notches; opening removes whatever is narrower than the kernel (food at the rim, a cable).
        closed = cv2.morphologyEx(patch.filled, cv2.MORPH_CLOSE, _SQUARE)
        mask: Frame = cv2.morphologyEx(closed, cv2.MORPH_OPEN, self._opening_kernel)  # type: ignore[assignment]
        estimate = shape_moments(patch, mask, self._calibration, self._settings.marker_height)
        if estimate is None or not self._has_marker_size(estimate):
            return None
        moments, scale = self._fitted(patch, estimate, joined)
        if moments is None or (patch.edge and self._is_cut_off(moments)):
            return None
        mask = self._marker_mask(patch, moments)
        reading = self._pattern.read(self._rectified(patch, moments, scale), moments.level)
        heading = moments.axis if reading.forward else moments.axis + math.pi
        return DetectedMarker(moments, heading, reading.number, reading.area, mask, reading.trouble)

    def covered(self, marker: DetectedMarker, contours: Sequence[Contour]) -> list[bool]:
        """Whether the middle of each contour lies within a marker."""
        (xu, xv), (yu, yv) = self._steps(marker.moments, 1.0)
        determinant = xu * yv - xv * yu
        length, width = self._settings.marker_length / 2, self._settings.marker_width / 2
        covered = []
        for contour in contours:
            column, row = contour.sum(axis=(0, 1)).tolist()
            u = column / len(contour) + 0.5 - marker.moments.u
            v = row / len(contour) + 0.5 - marker.moments.v
            a, b = (u * yv - v * yu) / determinant, (v * xu - u * xv) / determinant
            covered.append(abs(a) <= length and abs(b) <= width)
        return covered

    def _has_marker_size(self, moments: ShapeMoments) -> bool:
        tolerance = self._settings.tolerance
        return (
            moments.area >= _MIN_AREA * self._area
            and moments.area >= _MIN_FILL * 12 * moments.major * moments.minor
            and abs(moments.major / self._major - 1) <= tolerance
            and abs(moments.minor / self._minor - 1) <= tolerance
        )

    def _fitted(
        self, patch: ImagePatch, estimate: ShapeMoments, loose: bool
    ) -> tuple[ShapeMoments | None, float]:
        """The moments with centre and axis of the marker whose border lies near the estimate; and its relative size."""
        fitted, clear = self._fitted_at(patch, estimate, 1.0, loose)
        scale = self._scale(estimate)
        if not clear and abs(scale - 1) > _OTHER_SIZE:
            own_size, clear = self._fitted_at(patch, estimate, scale, loose)
            if clear:
                return own_size, scale
        return fitted, scale if clear else 1.0

    def _fitted_at(
        self, patch: ImagePatch, moments: ShapeMoments, scale: float, loose: bool
    ) -> tuple[ShapeMoments | None, bool]:
        """The same for a marker of another size, as a multiple of its true size; and whether little of it is hidden."""
        clear = False
        for _ in range(_MAX_REPEATS):
            along, across = self._steps(moments, MM_PER_PIXEL * scale)
            start = (moments.u - 0.5, moments.v - 0.5)
            affine = np.array([[along[0], across[0], start[0]], [along[1], across[1], start[1]]])
            rectangle = self._border.fit(patch.frame, affine, moments.level, patch.floor, loose)
            if rectangle is None:
                return None, False
            (a, b), turn, clear = rectangle
            u = moments.u + a * along[0] + b * across[0]
            v = moments.v + a * along[1] + b * across[1]
            x, y = self._calibration.to_region(u, v, self._settings.marker_height)
            moments = moments._replace(u=u, v=v, x=x, y=y, axis=moments.axis + turn)
            if math.hypot(a, b) + abs(turn) * 2 * self._major < _CONVERGED:
                break
        return moments, clear

    def _scale(self, estimate: ShapeMoments) -> float:
        """Size of a marker as a multiple of its true size; 1 unless all of it is seen."""
        along, across = estimate.major / self._major, estimate.minor / self._minor
        return (along + across) / 2 / _SEEN_SIZE if abs(along - across) < _SAME_SHAPE else 1.0

    def _corners(self, moments: ShapeMoments) -> list[tuple[float, float]]:
        """Corners in the picture of a marker at that pose."""
        along, across = self._steps(moments, 1.0)
        length, width = self._settings.marker_length / 2, self._settings.marker_width / 2
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
            -_MAX_OUTSIDE <= u <= self._calibration.size[0] + _MAX_OUTSIDE
            and -_MAX_OUTSIDE <= v <= self._calibration.size[1] + _MAX_OUTSIDE
            for u, v in self._corners(moments)
        )

    def _marker_mask(self, patch: ImagePatch, moments: ShapeMoments) -> Frame:
        """255 within a marker at that pose."""
        import cv2

        corners = [(u - 0.5 - patch.column, v - 0.5 - patch.row) for u, v in self._corners(moments)]
        mask = np.zeros_like(patch.filled)
        cv2.fillConvexPoly(mask, np.rint(np.multiply(corners, 16)).astype(np.int32), 255, cv2.LINE_8, 4)
        return mask

    def _steps(self, moments: ShapeMoments, length: float) -> tuple[tuple[float, float], tuple[float, float]]:
        """A step of this length (mm) along the marker and one to its left, in pixels of the picture."""
        xu, xv, yu, yv = self._calibration.jacobian(moments.u, moments.v, self._settings.marker_height)
        length /= MM_PER_PIXEL * (xu * yv - xv * yu)  # through the inverse of the Jacobian
        cos, sin = math.cos(moments.axis) * length, math.sin(moments.axis) * length
        return (yv * cos - xv * sin, xu * sin - yu * cos), (-yv * sin - xv * cos, xu * cos + yu * sin)

    def _rectified(self, patch: ImagePatch, moments: ShapeMoments, scale: float) -> Frame:
        """The marker with its frame, upright, one sample per 2.5 mm: column 0 at one end, row 0 at its right side."""
        import cv2

        along, across = self._steps(moments, SAMPLE * scale)
        middle = ((self._pattern.columns - 1) / 2, (self._pattern.rows - 1) / 2)
        start_u = moments.u - 0.5 - along[0] * middle[0] - across[0] * middle[1]
        start_v = moments.v - 0.5 - along[1] * middle[0] - across[1] * middle[1]
        affine = np.array([[along[0], across[0], start_u], [along[1], across[1], start_v]])
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        return cv2.warpAffine(patch.frame, affine, (self._pattern.columns, self._pattern.rows), flags=flags)  # type: ignore[return-value]
