"""Robots' markers: from a bright shape to pose and number of holes (figures 3.8, 3.9)."""

import math
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from khepera_forage.robots.khepera import MARKER_LENGTH
from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.detection.hole_pattern import SAMPLE, HolePattern, Reading
from khepera_forage.vision.detection.rectangle_fit import RectangleFit
from khepera_forage.vision.detection.segmentation import Frame, ImagePatch, ShapeMoments, shape_moments
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.shapes import GRID_HOLES, GRID_SIDE, HOLE_SIDE, MARKER_HOLES
from khepera_forage.vision.tracker_settings import TrackerSettings

_SQUARE = np.ones((3, 3), np.uint8)
_MAX_REPEATS, _CONVERGED = 3, 0.5
"""Greatest number of times the border is searched around the last estimate, and region pixels, at the corners, below
which another search changes nothing."""
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
_CORNERS = np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)])


class DetectedMarker(NamedTuple):
    """A marker in a frame: the axis of its moments is the heading; its corners are 4 x 2 pixels of the picture."""

    moments: ShapeMoments
    reading: Reading
    corners: NDArray[np.float64]


class MarkerDetector:
    """Distinguishes markers from other bright shapes, and measures their pose and holes."""

    def __init__(self, settings: TrackerSettings, calibration: Calibration) -> None:
        self._calibration, self._tolerance = calibration, settings.tolerance
        self._height = settings.marker_height
        diameter = max(3, round(_OPENING * 2 * settings.food_radius / calibration.mm_per_pixel()))
        self._opening_kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (diameter, diameter))
        length, width = settings.marker_length / MM_PER_PIXEL, settings.marker_width / MM_PER_PIXEL
        self._half_size, self._area = np.array((length / 2, width / 2)), length * width
        # Standard deviations of a rectangle are its sides over the root of 12.
        self._major, self._minor = length / math.sqrt(12), width / math.sqrt(12)
        self._border = RectangleFit(length, width)
        arrangements, side = (
            (GRID_HOLES, GRID_SIDE) if settings.markers == "grid" else (MARKER_HOLES, HOLE_SIDE)
        )
        used = arrangements.keys() if settings.markers == "tags" else settings.numbers
        stretch = settings.marker_length / MARKER_LENGTH
        self._pattern = HolePattern(
            {n: [(stretch * x, stretch * y) for x, y in arrangements[n]] for n in sorted(used)},
            settings.hole_side * side / HOLE_SIDE,
            settings.marker_length,
            settings.marker_width,
        )

    def detect(self, frame: Frame, patch: ImagePatch, joined: bool) -> DetectedMarker | None:
        """The marker in a patch.

        Args:
            frame: Of which the patch is a part.
            patch: Contains the shape.
            joined: Whether the shape results from joining pieces. The border of a single piece must fit exactly: a part
                of a marker would fit loosely at a wrong place.

        Returns:
            None for anything else, or for a marker whose pose is uncertain.
        """
        # Closing fills notches; opening removes whatever is narrower than the kernel (food at the rim, a cable).
        closed = cv2.morphologyEx(patch.filled, cv2.MORPH_CLOSE, _SQUARE)
        mask: Frame = cv2.morphologyEx(closed, cv2.MORPH_OPEN, self._opening_kernel)  # type: ignore[assignment]
        estimate = shape_moments(patch, mask, self._calibration, self._height)
        if estimate is None or not self._has_marker_size(estimate):
            return None
        moments, clear = self._fitted(frame, patch, estimate, 1.0, joined)
        # Unless all of it is seen, a marker has its true size.
        along, across = estimate.major / self._major, estimate.minor / self._minor
        own_size = (along + across) / 2 / _SEEN_SIZE if abs(along - across) < _SAME_SHAPE else 1.0
        size = own_size if clear else 1.0
        if not clear and abs(own_size - 1) > _OTHER_SIZE:
            other, clear = self._fitted(frame, patch, estimate, own_size, joined)
            if clear:
                moments, size = other, own_size
        if moments is None:
            return None
        steps, middle = self._steps(moments)
        corners = middle + _CORNERS * self._half_size @ steps.T
        if (
            patch.edge
            and (
                (corners < -_MAX_OUTSIDE) | (corners > np.array(self._calibration.size) + _MAX_OUTSIDE)
            ).any()
        ):
            return None  # it would be measured shifted and turned
        reading = self._pattern.read(self._rectified(frame, middle, size * steps), moments.level)
        if not reading.forward:
            moments = moments._replace(axis=moments.axis + math.pi)
        return DetectedMarker(moments, reading, corners)

    def _has_marker_size(self, moments: ShapeMoments) -> bool:
        return (
            moments.area >= _MIN_AREA * self._area
            and moments.area >= _MIN_FILL * 12 * moments.major * moments.minor
            and abs(moments.major / self._major - 1) <= self._tolerance
            and abs(moments.minor / self._minor - 1) <= self._tolerance
        )

    def _fitted(
        self, frame: Frame, patch: ImagePatch, moments: ShapeMoments, size: float, loose: bool
    ) -> tuple[ShapeMoments | None, bool]:
        """The moments with centre and axis of the marker whose border lies near, and whether little of it is hidden.

        `size` is that of the marker as a multiple of its true size.
        """
        clear = False
        for _ in range(_MAX_REPEATS):
            steps, middle = self._steps(moments)
            affine = np.column_stack((size * steps, middle - 0.5))
            rectangle = self._border.fit(frame, affine, moments.level, patch.floor, loose)
            if rectangle is None:
                return None, False
            a, b, turn, clear = rectangle
            u, v = (middle + size * steps @ (a, b)).tolist()
            x, y = self._calibration.to_region(u, v, self._height)
            moments = moments._replace(u=u, v=v, x=x, y=y, axis=moments.axis + turn)
            if math.hypot(a, b) + abs(turn) * 2 * self._major < _CONVERGED:
                break
        return moments, clear

    def _steps(self, moments: ShapeMoments) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """In the picture: steps of a region pixel along and across the marker (columns), and its middle."""
        jacobian = self._calibration.jacobian(moments.u, moments.v, self._height)
        cos, sin = math.cos(moments.axis), math.sin(moments.axis)
        steps = np.linalg.inv(np.array(jacobian).reshape(2, 2)) @ [[cos, -sin], [sin, cos]]
        return steps, np.array(moments[:2])

    def _rectified(self, frame: Frame, middle: NDArray[np.float64], steps: NDArray[np.float64]) -> Frame:
        """The marker with its black frame, upright: column 0 at one end, row 0 at its right side."""
        steps = steps * SAMPLE / MM_PER_PIXEL
        columns, rows = self._pattern.columns, self._pattern.rows
        start = middle - 0.5 - steps @ ((columns - 1) / 2, (rows - 1) / 2)
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        return cv2.warpAffine(frame, np.column_stack((steps, start)), (columns, rows), flags=flags)  # type: ignore[return-value]
