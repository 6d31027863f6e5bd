"""A scene drawn over its frame, for previews and for the documentation."""

import math

import numpy as np
from numpy.typing import NDArray

from khepera_forage.extras import require
from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.detection.segmentation import check_frame
from khepera_forage.vision.scene import MM_PER_PIXEL, Region, Scene
from khepera_forage.vision.tracker_settings import TrackerSettings

Colour = tuple[int, int, int]
_MARKER: Colour = (255, 90, 60)
_FOOD: Colour = (60, 220, 90)
_LOST: Colour = (150, 150, 160)
_FRACTIONAL_BITS = 4
"""Fractional bits of OpenCV's drawing coordinates."""
_CIRCLE_POINTS = 24
"""Corners of the polygon that is drawn for a disc."""


def draw_scene(
    frame: NDArray[np.uint8],
    scene: Scene,
    calibration: Calibration | None = None,
    settings: TrackerSettings | None = None,
) -> NDArray[np.uint8]:
    """The frame with its regions: outline, centre, heading and "label:holes"; lost regions grey with a question mark.

    Args:
        frame: 480 x 640 grey levels; not changed.
        scene: The tracker's scene after this frame.
        calibration: The tracker's; None for `Calibration.identity()`.
        settings: The tracker's, for sizes and heights; None for the defaults.

    Returns:
        480 x 640 x 3: red, green, blue.

    Raises:
        ImportError: OpenCV is not installed.
        ValueError: A frame that is not 480 x 640 grey levels.
    """
    require("drawing a scene", "camera")
    import cv2

    check_frame(frame)
    picture: NDArray[np.uint8] = cv2.cvtColor(frame, cv2.COLOR_GRAY2RGB)  # type: ignore[assignment]
    overlay = _Overlay(picture, calibration or Calibration.identity(), settings or TrackerSettings())
    for region in scene.regions:
        overlay.draw(region)
    return picture


class _Overlay:
    """Draws regions on one picture."""

    def __init__(
        self, picture: NDArray[np.uint8], calibration: Calibration, settings: TrackerSettings
    ) -> None:
        self._picture, self._calibration, self._settings = picture, calibration, settings

    def draw(self, region: Region) -> None:
        import cv2

        marker = region.holes > 0
        colour = (_MARKER if marker else _FOOD) if region.found else _LOST
        self._line(region, self._outline(region), colour, closed=True)
        for stroke in ([(-1.5, 0.0), (1.5, 0.0)], [(0.0, -1.5), (0.0, 1.5)]):
            self._line(region, stroke, colour)
        if marker:
            tip = self._settings.marker_length / MM_PER_PIXEL * 0.8
            arrow_head = [(tip - 3, 2.5), (tip, 0.0), (tip - 3, -2.5)]
            self._line(region, [(0.0, 0.0), (tip, 0.0)], colour)
            self._line(region, arrow_head, colour)
        text = f"{region.label}:{region.holes}" + ("" if region.found else "?")
        u, v = self._picture_point(region, 0.0, 0.0)
        offset = self._settings.marker_width if marker else 2 * self._settings.food_radius
        corner = (round(u + offset / MM_PER_PIXEL), round(v - offset / MM_PER_PIXEL))
        cv2.putText(self._picture, text, corner, cv2.FONT_HERSHEY_SIMPLEX, 0.4, colour, 1, cv2.LINE_AA)

    def _outline(self, region: Region) -> list[tuple[float, float]]:
        """Corners in the region's own frame (region pixels, x forward)."""
        settings = self._settings
        if region.holes > 0:
            a, b = settings.marker_length / MM_PER_PIXEL / 2, settings.marker_width / MM_PER_PIXEL / 2
            return [(a, b), (-a, b), (-a, -b), (a, -b)]
        radius = settings.food_radius / MM_PER_PIXEL
        angles = (2 * math.pi * i / _CIRCLE_POINTS for i in range(_CIRCLE_POINTS))
        return [(radius * math.cos(angle), radius * math.sin(angle)) for angle in angles]

    def _line(
        self, region: Region, points: list[tuple[float, float]], colour: Colour, *, closed: bool = False
    ) -> None:
        """A line through points in the region's own frame (region pixels, x forward)."""
        import cv2

        corners = np.array([self._picture_point(region, *point) for point in points]) - 0.5
        fixed_point = np.rint(corners * 2**_FRACTIONAL_BITS).astype(np.int32)
        cv2.polylines(self._picture, [fixed_point], closed, colour, 1, cv2.LINE_AA, _FRACTIONAL_BITS)

    def _picture_point(self, region: Region, forward: float, left: float) -> tuple[float, float]:
        """The point of the picture that shows a point in the region's own frame (region pixels)."""
        heading = math.radians(region.orientation)
        height = self._settings.marker_height if region.holes > 0 else self._settings.food_height
        x = region.x + forward * math.cos(heading) - left * math.sin(heading)
        y = region.y + forward * math.sin(heading) + left * math.cos(heading)
        return self._calibration.to_picture(x, y, height)
