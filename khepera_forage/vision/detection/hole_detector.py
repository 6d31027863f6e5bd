"""A marker turned upright: how many holes it has, and where (figures 3.8, 3.9)."""

import numpy as np

from khepera_forage.vision.detection.segmentation import Frame
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.tracker_settings import TrackerSettings

SAMPLE = 2.5
"""mm on the floor between the samples of an upright marker."""
_RIM = 7.5
"""mm along a marker's border in which nothing is counted: blur darkens it, and a fit may be off by a pixel."""
_BRIDGE = 5.0
"""mm: bright things across a hole up to that wide (a light cable) do not split it."""
_THIN = 0.6
"""Share of a hole's side: what is thinner is no hole (a dark cable)."""
_WIDE = 0.9
"""The same for what runs to the marker's border: a wide cable, or a cable over a hole."""
_HOLE_AREA = (0.35, 1.8)
"""Shares of a hole's area between which something dark is taken for one."""
_HOLE_SIDE = 1.5
"""Times a hole's side that a hole may be long."""
_STRAY = 0.2
"""Share of a hole's area: anything dark that is larger, no hole, and does not come in over the border, leaves the
number of holes in doubt."""


class HoleReader:
    """Reads the holes in a marker, and says nothing when in doubt.

    Args:
        settings: Sizes and contrast.
    """

    def __init__(self, settings: TrackerSettings) -> None:
        self._contrast = settings.hole_contrast
        self.columns = round(settings.marker_length / SAMPLE)
        self.rows = round(settings.marker_width / SAMPLE)
        self._rim = round(_RIM / SAMPLE)
        self._side = side = settings.hole_side / SAMPLE
        self._hole = side * side
        self._close = np.ones((round(_BRIDGE / SAMPLE) + 1,) * 2, np.uint8)
        self._open = np.ones((max(1, round(_THIN * side)),) * 2, np.uint8)
        self._open_wide = np.ones((max(1, round(_WIDE * side)),) * 2, np.uint8)

    def read(self, upright: Frame, level: float) -> tuple[int, float, float] | None:
        """The holes of a marker.

        Args:
            upright: Its grey levels, `rows` x `columns` samples, its axis along the rows.
            level: Grey level of its white.

        Returns:
            Their number, how far in mm their centre lies from the middle towards the last column, and their area in
            square region pixels; None for no hole, or when cables leave their number in doubt.
        """
        import cv2

        dark = cv2.compare(upright, level * self._contrast, cv2.CMP_LT)  # type: ignore[call-overload]
        rim = self._rim
        dark[:rim], dark[-rim:], dark[:, :rim], dark[:, -rim:] = 0, 0, 0, 0
        if not dark.any():
            return None
        clean = self._without_cables(cv2.morphologyEx(dark, cv2.MORPH_CLOSE, self._close))  # type: ignore[arg-type]
        if clean is None:
            return None
        count, _, stats, centres = cv2.connectedComponentsWithStats(clean)
        if count == 1:
            return None
        if not all(self._within(*spot) for spot in stats[1:].tolist()):
            return None
        areas = stats[1:, cv2.CC_STAT_AREA].tolist()
        if self._doubtful(cv2.subtract(dark, cv2.dilate(clean, self._close))):  # type: ignore[arg-type] # uint8
            return None
        ahead = float(centres[1:, 0].mean() + 0.5 - self.columns / 2) * SAMPLE
        return count - 1, ahead, sum(areas) * (SAMPLE / MM_PER_PIXEL) ** 2

    def _without_cables(self, dark: Frame) -> Frame | None:
        """Only what is as wide as a hole; None when a cable is as wide as that, and could be taken for one.

        Cables run to the border, and holes do not, unless one lies under a cable.
        """
        import cv2

        count, labels, stats, _ = cv2.connectedComponentsWithStats(dark)
        running = [i for i in range(1, count) if not self._inner(*stats[i, :4].tolist())]
        if not running:
            return cv2.morphologyEx(dark, cv2.MORPH_OPEN, self._open)  # type: ignore[return-value] # uint8
        cable = np.isin(labels, running)
        holes = cv2.morphologyEx(np.where(cable, np.uint8(0), dark), cv2.MORPH_OPEN, self._open)
        crossed = cv2.morphologyEx(np.where(cable, dark, np.uint8(0)), cv2.MORPH_OPEN, self._open_wide)
        rest = np.where(cable & (cv2.dilate(crossed, self._close) == 0), dark, np.uint8(0))
        if cv2.morphologyEx(rest, cv2.MORPH_OPEN, self._open).any():
            return None
        return cv2.bitwise_or(holes, crossed)  # type: ignore[return-value] # uint8

    def _within(self, left: int, top: int, width: int, height: int, area: int) -> bool:
        """Whether a dark spot is a hole: of its size, and clear of the border, to which a cable runs."""
        least, most = (share * self._hole for share in _HOLE_AREA)
        square = max(width, height) <= _HOLE_SIDE * self._side
        return square and least <= area <= most and self._inner(left, top, width, height)

    def _inner(self, left: int, top: int, width: int, height: int) -> bool:
        right, bottom = self.columns - self._rim, self.rows - self._rim
        return left > self._rim and top > self._rim and left + width < right and top + height < bottom

    def _doubtful(self, stray: Frame) -> bool:
        """Whether dark spots that are no holes may hide one: a cable reaches the border, half a hole does not."""
        import cv2

        if cv2.countNonZero(stray) < _STRAY * self._hole:
            return False
        count, _, stats, _ = cv2.connectedComponentsWithStats(stray)
        for left, top, width, height, area in stats[1:count].tolist():
            if area >= _STRAY * self._hole and self._inner(left, top, width, height):
                return True
        return False
