"""Number and position of the holes, wherever they are, in a marker that no cable crosses (figures 3.8, 3.9)."""

from typing import NamedTuple

import numpy as np

from khepera_forage.vision.detection.segmentation import Frame
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.tracker_settings import TrackerSettings

SAMPLE = 2.5
"""mm on the floor between the samples of a rectified marker."""
_RIM = 7.5
"""Width in mm of the marker's border that is ignored: blur darkens it, and the fitted pose may be off by a pixel."""
_BRIDGE = 5.0
"""Width in mm up to which a bright object across a hole (a light cable) does not split the hole."""
_MIN_WIDTH = 0.6
"""Share of a hole's side; anything narrower is no hole."""
_HOLE_AREA = (0.35, 1.8)
"""Least and greatest area of a hole, as shares of its true area."""
_MAX_LENGTH = 1.5
"""Greatest length of a hole, in sides of a hole."""
_MAX_STRAY_AREA = 0.2
"""Share of a hole's area. A larger dark spot that is no hole and does not reach the border makes the number of holes
uncertain."""


class Holes(NamedTuple):
    """The holes of a marker.

    Attributes:
        number: Number of holes.
        offset: Distance in mm of their common centre from the middle of the marker towards the last column.
        area: Their total area in square region pixels.
    """

    number: int
    offset: float
    area: float


class HoleDetector:
    """Detects the holes in a rectified marker that no cable crosses.

    Args:
        settings: Sizes and contrast.

    Attributes:
        columns: Width of a rectified marker in samples.
        rows: Height of a rectified marker in samples.
    """

    def __init__(self, settings: TrackerSettings) -> None:
        self._contrast = settings.hole_contrast
        self.columns = round(settings.marker_length / SAMPLE)
        self.rows = round(settings.marker_width / SAMPLE)
        self._rim = round(_RIM / SAMPLE)
        self._side = side = settings.hole_side / SAMPLE
        self._hole_area = side * side
        self._bridge_kernel = np.ones((round(_BRIDGE / SAMPLE) + 1,) * 2, np.uint8)
        self._narrow_kernel = np.ones((max(1, round(_MIN_WIDTH * side)),) * 2, np.uint8)

    def detect(self, rectified: Frame, level: float) -> Holes | None:
        """The holes of a marker.

        Args:
            rectified: Grey levels of the marker, `rows` x `columns` samples, its long axis along the rows.
            level: Grey level of the marker's white.

        Returns:
            None without holes, or if their number is uncertain.
        """
        import cv2

        dark = cv2.compare(rectified, level * self._contrast, cv2.CMP_LT)  # type: ignore[call-overload]
        rim = self._rim
        dark[:rim], dark[-rim:], dark[:, :rim], dark[:, -rim:] = 0, 0, 0, 0
        if not dark.any():
            return None
        closed = cv2.morphologyEx(dark, cv2.MORPH_CLOSE, self._bridge_kernel)
        holes = cv2.morphologyEx(closed, cv2.MORPH_OPEN, self._narrow_kernel)
        labels, _, stats, centres = cv2.connectedComponentsWithStats(holes)
        if labels == 1:
            return None
        if not all(self._is_hole(*component) for component in stats[1:].tolist()):
            return None
        areas = stats[1:, cv2.CC_STAT_AREA].tolist()
        if self._has_stray_spot(cv2.subtract(dark, cv2.dilate(holes, self._bridge_kernel))):  # type: ignore[arg-type] # uint8
            return None
        offset = float(centres[1:, 0].mean() + 0.5 - self.columns / 2) * SAMPLE
        return Holes(labels - 1, offset, sum(areas) * (SAMPLE / MM_PER_PIXEL) ** 2)

    def _is_hole(self, left: int, top: int, width: int, height: int, area: int) -> bool:
        """Whether a dark component has a hole's size and does not reach the border, as a cable does."""
        least, most = (share * self._hole_area for share in _HOLE_AREA)
        compact = max(width, height) <= _MAX_LENGTH * self._side
        return compact and least <= area <= most and self._is_inside(left, top, width, height)

    def _is_inside(self, left: int, top: int, width: int, height: int) -> bool:
        """Whether a bounding box is clear of the marker's border."""
        right, bottom = self.columns - self._rim, self.rows - self._rim
        return left > self._rim and top > self._rim and left + width < right and top + height < bottom

    def _has_stray_spot(self, stray: Frame) -> bool:
        """Whether a dark spot inside the marker may be part of a hole. Spots at the border are cables."""
        import cv2

        if cv2.countNonZero(stray) < _MAX_STRAY_AREA * self._hole_area:
            return False
        count, _, stats, _ = cv2.connectedComponentsWithStats(stray)
        for left, top, width, height, area in stats[1:count].tolist():
            if area >= _MAX_STRAY_AREA * self._hole_area and self._is_inside(left, top, width, height):
                return True
        return False
