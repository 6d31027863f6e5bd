"""The robots' cables as the overhead camera sees them: thin grey curves that sway (3.7)."""

import math
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from khepera_forage.vision.rendering.appearance import CameraLook
from khepera_forage.vision.rendering.canvas import Box, Place, corners_of, pixels
from khepera_forage.vision.rendering.slow_noise import Slow
from khepera_forage.vision.scene import MM_PER_PIXEL

_PERIOD = 7.0
"""Typical seconds of a sway."""
_LOOSE = 400.0
"""mm from the anchor beyond which a cable bows in full; nearer it hangs more steeply, and less is seen of its bow."""
_POINTS = 24
"""Of the curve that is drawn in straight pieces."""
_LINE_WIDTHS = {1: 1.35, 2: 3.4}
"""Pixels that OpenCV's smooth lines of thickness 1 and 2 are wide: their coverage summed across, by measurement at
slopes of 0 to 90 degrees (within 15 % and 4 %)."""
_BITS = 4


class Cables:
    """A cable from one anchor overhead to each robot.

    A cable runs out from under its robot's own marker, for its plug is on the robot, so that it lies over other
    markers and food but never over its own. Seen from above it is a bow, whose belly sways.

    Args:
        look: Grey level, thickness, sag and sway.
        anchor: Where all cables hang from, in mm as seen from above.
        rng: Draws to which side each cable hangs, and its waves.
        count: Of cables.

    Attributes:
        curves: Where each hung when last drawn, from the anchor to the middle of its robot's marker: points x
            to the right and y up, in pixels.
    """

    def __init__(
        self, look: CameraLook, anchor: tuple[float, float], rng: np.random.Generator, count: int
    ) -> None:
        self._look = look
        self.curves: list[NDArray[np.float64]] = []
        self._anchor = np.array(pixels(*anchor))
        self._slow = Slow(rng, count, _PERIOD)
        self._sides = rng.choice((-1.0, 1.0), count)
        width = look.cable_width / MM_PER_PIXEL
        self._thickness = min((t for t, w in _LINE_WIDTHS.items() if width <= w), default=2)
        self._coverage = min(1.0, width / _LINE_WIDTHS[self._thickness])
        self._shares = np.linspace(0, 1, _POINTS)[:, None]

    def draw(self, picture: NDArray[np.uint8], markers: Sequence[Place], sheet: Box, seconds: float) -> None:
        """Draw all cables over a picture.

        Args:
            picture: 480 x 640 grey levels, changed in place.
            markers: Where each robot's marker lies in the picture.
            sheet: Outline of a marker in its own frame, mm.
            seconds: Time since the reset.
        """
        bows = self._bows(seconds)
        self.curves = [self._curve(marker, bow) for marker, bow in zip(markers, bows, strict=True)]
        for marker, curve in zip(markers, self.curves, strict=True):
            self._draw(picture, curve, corners_of(sheet, marker))

    def _bows(self, seconds: float) -> list[float]:
        bows = self._look.cable_sag * self._sides + self._look.cable_sway * self._slow.at(seconds)
        return [float(bow) / MM_PER_PIXEL for bow in bows]

    def _curve(self, marker: Place, bow: float) -> NDArray[np.float64]:
        """Points from the anchor to the middle of a marker, in pixels as OpenCV counts them."""
        start, end = self._anchor, np.array((marker.x, marker.y))
        along = end - start
        length = math.hypot(*along)
        aside = np.array((-along[1], along[0])) / max(length, 1e-9)
        belly = (start + end) / 2 + 2 * bow * min(1.0, length * MM_PER_PIXEL / _LOOSE) * aside
        s = self._shares
        curve: NDArray[np.float64] = (1 - s) ** 2 * start + 2 * s * (1 - s) * belly + s**2 * end
        return curve

    def _draw(self, picture: NDArray[np.uint8], curve: NDArray[np.float64], own: NDArray[np.float64]) -> None:
        height, width = picture.shape
        spots = np.column_stack((curve[:, 0] - 0.5, height - curve[:, 1] - 0.5))
        reach = self._thickness + 2
        left, top = np.clip(np.floor(spots.min(axis=0)) - reach, 0, (width, height)).astype(int).tolist()
        right, bottom = np.clip(np.ceil(spots.max(axis=0)) + reach, 0, (width, height)).astype(int).tolist()
        if left >= right or top >= bottom:
            return
        cover = np.zeros((bottom - top, right - left), np.uint8)
        line = np.round((spots - (left, top)) * 2**_BITS).astype(np.int32)
        cv2.polylines(cover, [line], False, 255, self._thickness, cv2.LINE_AA, _BITS)
        hidden = np.round((own - (left, top)) * 2**_BITS).astype(np.int32)
        cv2.fillConvexPoly(cover, hidden, 0, cv2.LINE_8, _BITS)
        rows, columns = cover.nonzero()
        share = cover[rows, columns] * (self._coverage / 255)
        rows, columns = rows + top, columns + left
        below = picture[rows, columns]
        picture[rows, columns] = np.rint(below + share * (self._look.cable - below)).astype(np.uint8)
