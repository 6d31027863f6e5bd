"""Food: from a bright shape to the centres of the discs that it is made of."""

import math
from collections.abc import Iterator

import numpy as np

from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.detection.image_patch import Form, Patch, form
from khepera_forage.vision.detection.segmentation import Frame
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.tracker_settings import TrackerSettings

_FULL = 0.7
"""Share of the ellipse with the same moments that food fills at least: a kinked cable end fills less."""
_AREA = (0.8, 1.5)
"""Shares of food's area between which a disc is food as a whole: of one half hidden, the centre is not known."""
_PEELS = 3
"""How often at most a row of pixels is taken off all round touching discs to part them."""
_CROSS = np.array([[0, 1, 0], [1, 1, 1], [0, 1, 0]], np.uint8)


class FoodFinder:
    """Tells food from everything else that is bright.

    Args:
        settings: Sizes and tolerances.
        calibration: From the picture to the floor.
    """

    def __init__(self, settings: TrackerSettings, calibration: Calibration) -> None:
        self._settings, self._calibration = settings, calibration
        # The standard deviation of a disc along any axis is half its radius.
        self._deviation = settings.food_radius / MM_PER_PIXEL / 2
        self._area = math.pi * (settings.food_radius / MM_PER_PIXEL) ** 2

    def find(self, patch: Patch) -> Form | None:
        """The one food object that a patch shows; None if it shows something else, or only part of one."""
        seen = form(patch, patch.filled, self._calibration, self._settings.food_height)
        return seen if seen is not None and self._sized(seen) else None

    def part(self, patch: Patch) -> Iterator[tuple[Form, Frame]]:
        """The food objects that touch each other in a patch, each with its own part of the shape."""
        import cv2

        level = cv2.mean(patch.grey, patch.filled)[
            0
        ]  # the edges' own brightness pulls it down, and parts the better
        cores = patch.filled & (patch.grey > level)
        for _ in range(_PEELS):
            count, labels = cv2.connectedComponents(cores)
            if count > 2:
                break
            cores = cv2.erode(cores, _CROSS)  # type: ignore[assignment]
        else:
            return
        # Each pixel goes to the nearest core: where two discs touch, the border between them is straight.
        away = np.stack(
            [cv2.distanceTransform((labels != i).astype(np.uint8), cv2.DIST_L2, 5) for i in range(1, count)]
        )
        nearest = away.argmin(axis=0)
        for i in range(count - 1):
            shape = np.where(nearest == i, patch.filled, np.uint8(0))
            seen = form(patch, shape, self._calibration, self._settings.food_height)
            if seen is not None and self._sized(seen):
                yield seen, shape

    def _sized(self, seen: Form) -> bool:
        tolerance = self._settings.tolerance
        least, most = (share * self._area for share in _AREA)
        full = least <= seen.area <= most and seen.area >= _FULL * 4 * math.pi * seen.major * seen.minor
        return full and all(abs(d / self._deviation - 1) <= tolerance for d in (seen.major, seen.minor))
