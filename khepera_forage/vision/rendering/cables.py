"""The robots' cables as the overhead camera sees them: thin grey curves that sway (3.7)."""

import math
from collections.abc import Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from khepera_forage.vision.rendering.appearance import CameraAppearance
from khepera_forage.vision.rendering.canvas import Box, ImagePose, box_corners, to_pixels
from khepera_forage.vision.rendering.light import SlowNoise
from khepera_forage.vision.scene import MM_PER_PIXEL

_PERIOD = 7.0
"""Typical period of the sway in s."""
_FULL_SAG_LENGTH = 400.0
"""mm between anchor and robot from which on a cable sags in full; a nearer cable is steeper and shows less sag."""
_POINTS = 24
"""Points on the polyline that approximates a cable."""
_FRACTIONAL_BITS = 4


class Cables:
    """One cable from the overhead anchor to each robot.

    A cable enters its robot under the marker, for the plug is on the robot. It therefore covers other markers and
    food, but never its own robot's marker. Seen from above it is a quadratic curve whose middle sways.

    Args:
        appearance: Grey level, thickness, sag and sway.
        anchor: Where all cables hang from, in mm as seen from above.
        rng: Draws the side to which each cable sags, and its sway.
        count: Number of cables.

    Attributes:
        curves: The cables as last drawn, from the anchor to the middle of the robot's marker: points in pixels, x to
            the right and y up.
    """

    def __init__(
        self,
        appearance: CameraAppearance,
        anchor: tuple[float, float],
        rng: np.random.Generator,
        count: int,
    ) -> None:
        self._appearance = appearance
        self.curves: list[NDArray[np.float64]] = []
        self._anchor = np.array(to_pixels(*anchor))
        self._sway = SlowNoise(rng, count, _PERIOD)
        self._sides = rng.choice((-1.0, 1.0), count)
        self._shares = np.linspace(0, 1, _POINTS)[:, None]

    def draw(
        self, picture: NDArray[np.uint8], markers: Sequence[ImagePose], sheet: Box, seconds: float
    ) -> None:
        """Draw all cables over a picture.

        Args:
            picture: 480 x 640 grey levels, changed in place.
            markers: Pose of each robot's marker in the picture.
            sheet: Outline of a marker in its own frame, mm.
            seconds: Time since the reset.
        """
        sags = self._sags(seconds)
        self.curves = [self._curve(marker, sag) for marker, sag in zip(markers, sags, strict=True)]
        for marker, curve in zip(markers, self.curves, strict=True):
            appearance = self._appearance
            width = appearance.cable_width / MM_PER_PIXEL
            draw_cable(picture, curve, width, appearance.cable, box_corners(sheet, marker))

    def _sags(self, seconds: float) -> list[float]:
        """Signed sideways distance in pixels of the middle of each cable from the straight line."""
        sags = self._appearance.cable_sag * self._sides + self._appearance.cable_sway * self._sway.at(seconds)
        return [float(sag) / MM_PER_PIXEL for sag in sags]

    def _curve(self, marker: ImagePose, sag: float) -> NDArray[np.float64]:
        """Points from the anchor to the middle of a marker: pixels, x right and y up."""
        start, end = self._anchor, np.array((marker.x, marker.y))
        along = end - start
        length = math.hypot(*along)
        normal = np.array((-along[1], along[0])) / max(length, 1e-9)
        control = (start + end) / 2 + 2 * sag * min(1.0, length * MM_PER_PIXEL / _FULL_SAG_LENGTH) * normal
        s = self._shares
        curve: NDArray[np.float64] = (1 - s) ** 2 * start + 2 * s * (1 - s) * control + s**2 * end
        return curve


def draw_cable(
    picture: NDArray[np.uint8],
    curve: NDArray[np.float64],
    width: float,
    grey: float,
    above: NDArray[np.float64] | None = None,
) -> None:
    """Draw one cable.

    Args:
        picture: 480 x 640 grey levels, changed in place.
        curve: Points of the cable: n x 2 pixels, x to the right and y up.
        width: In pixels.
        grey: Grey level of the cable.
        above: Corners (column and row) of the marker above the cable, which hides it; None for no marker.
    """
    height, across = picture.shape
    points = np.column_stack((curve[:, 0] - 0.5, height - curve[:, 1] - 0.5))
    reach = math.ceil(width) + 2
    left, top = np.clip(np.floor(points.min(axis=0)) - reach, 0, (across, height)).astype(int).tolist()
    right, bottom = np.clip(np.ceil(points.max(axis=0)) + reach, 0, (across, height)).astype(int).tolist()
    if left >= right or top >= bottom:
        return
    near = np.zeros((bottom - top, right - left), np.uint8)
    line = np.round((points - (left, top)) * 2**_FRACTIONAL_BITS).astype(np.int32)
    cv2.polylines(near, [line], False, 255, reach, cv2.LINE_8, _FRACTIONAL_BITS)
    if above is not None:
        hidden = np.round((above - (left, top)) * 2**_FRACTIONAL_BITS).astype(np.int32)
        cv2.fillConvexPoly(near, hidden, 0, cv2.LINE_8, _FRACTIONAL_BITS)
    rows, columns = near.nonzero()
    rows, columns = rows + top, columns + left
    share = _coverage(np.column_stack((columns, rows)), points, width)
    below = picture[rows, columns]
    picture[rows, columns] = np.rint(below + share * (grey - below)).astype(np.uint8)


def _coverage(pixels: NDArray[np.int64], line: NDArray[np.float64], width: float) -> NDArray[np.float64]:
    """The share of each pixel that a line of some width covers.

    Args:
        pixels: Middles of pixels, n x 2.
        line: Points of the line in the same coordinates, m x 2.
        width: In pixels.
    """
    starts, steps = line[:-1], np.diff(line, axis=0)
    squares = np.maximum((steps * steps).sum(axis=1), 1e-12)
    offset_x, offset_y = (pixels[:, i, None] - starts[:, i] for i in (0, 1))
    along = ((offset_x * steps[:, 0] + offset_y * steps[:, 1]) / squares).clip(0, 1)
    distances = (offset_x - along * steps[:, 0]) ** 2 + (offset_y - along * steps[:, 1]) ** 2
    # A pixel as a strip as wide as itself: exact for lines along rows and columns, and within 5 % for all others.
    edge = (width + 1) / 2 - np.sqrt(distances.min(axis=1))
    coverage: NDArray[np.float64] = edge.clip(0, min(1.0, width))
    return coverage
