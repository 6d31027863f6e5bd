"""A scene drawn over its frame, for previews and for the documentation."""

import math

import numpy as np
from numpy.typing import NDArray

from khepera_forage.extras import require
from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.detection.segmentation import as_grey
from khepera_forage.vision.scene import MM_PER_PIXEL, Region, Scene
from khepera_forage.vision.tracker_settings import TrackerSettings

Colour = tuple[int, int, int]
MARKER: Colour = (255, 90, 60)
FOOD: Colour = (60, 220, 90)
LOST: Colour = (150, 150, 160)
"""Red, green, blue of found markers, of found food and of lost regions."""
_FRACTIONAL_BITS = 4
"""Fractional bits of OpenCV's drawing coordinates."""
_CIRCLE_POINTS = 24
"""Corners of the polygon that is drawn for a disc."""
_TEXT_SIZE, _TEXT_GROWTH = 0.4, 0.2
"""Size of captions in OpenCV's unit, about 22 pixels: in a picture of the frame's size, and more for each further
pixel of the enlargement. Captions grow less than the picture."""


def draw_scene(
    frame: NDArray[np.uint8],
    scene: Scene,
    calibration: Calibration | None = None,
    settings: TrackerSettings | None = None,
    enlargement: int = 1,
) -> NDArray[np.uint8]:
    """The frame with its regions: outline, centre, heading of markers, and `caption`; lost regions are grey.

    Args:
        frame: 480 x 640 grey levels; not changed.
        scene: The tracker's scene after this frame.
        calibration: The tracker's; None for `Calibration.identity()`.
        settings: The tracker's, for sizes and heights; None for the defaults.
        enlargement: Pixels of the picture's side for each pixel of the frame's; the drawing is as sharp as the picture.

    Returns:
        480 x 640 x 3, or as many times larger: red, green, blue.

    Raises:
        ImportError: OpenCV is not installed.
        ValueError: A frame that is not 480 x 640 grey levels, or an enlargement below 1.
    """
    require("drawing a scene", "camera")
    import cv2

    frame = as_grey(frame)
    if enlargement < 1:
        raise ValueError(f"enlargement is {enlargement!r}; allowed: at least 1")
    larger = frame.repeat(enlargement, axis=0).repeat(enlargement, axis=1)
    picture: NDArray[np.uint8] = cv2.cvtColor(larger, cv2.COLOR_GRAY2RGB)  # type: ignore[assignment]
    overlay = _Overlay(
        picture, calibration or Calibration.identity(), settings or TrackerSettings(), enlargement
    )
    for region in scene.regions:
        overlay.draw(region)
    return picture


def caption(region: Region, markers: str = "holes") -> str:
    """What is written beside a region: its label, its kind, and whether it is lost.

    Args:
        region: The region.
        markers: The kind of markers, as in `TrackerSettings`.
    """
    kind = "food"
    if region.holes:
        kind = f"{region.holes} hole{'s' * (region.holes > 1)}"
        if markers != "holes":
            kind = f"{'tag' if markers == 'tags' else 'marker'} {region.holes}"
    return f"{region.label}: {kind}{'' if region.found else ', lost'}"


class _Overlay:
    """Draws regions on one picture."""

    def __init__(
        self,
        picture: NDArray[np.uint8],
        calibration: Calibration,
        settings: TrackerSettings,
        enlargement: int,
    ) -> None:
        self._picture, self._calibration, self._settings = picture, calibration, settings
        self._enlargement = enlargement
        self._thickness = (enlargement + 1) // 2

    def draw(self, region: Region) -> None:
        marker = region.holes > 0
        colour = (MARKER if marker else FOOD) if region.found else LOST
        self._line(region, self._outline(region), colour, closed=True)
        for stroke in ([(-1.5, 0.0), (1.5, 0.0)], [(0.0, -1.5), (0.0, 1.5)]):
            self._line(region, stroke, colour)
        if marker:
            tip = self._settings.marker_length / MM_PER_PIXEL * 0.8
            arrow_head = [(tip - 3, 2.5), (tip, 0.0), (tip - 3, -2.5)]
            self._line(region, [(0.0, 0.0), (tip, 0.0)], colour)
            self._line(region, arrow_head, colour)
        self._write(region, colour)

    def _write(self, region: Region, colour: Colour) -> None:
        """The caption: that of a marker above its outline, that of food below, so that neighbours stay apart."""
        import cv2

        size = _TEXT_SIZE + _TEXT_GROWTH * (self._enlargement - 1)
        (_, height), _ = cv2.getTextSize(
            caption(region, self._settings.markers), cv2.FONT_HERSHEY_SIMPLEX, size, self._thickness
        )
        places = [self._frame_point(region, *corner) for corner in self._outline(region)]
        left = min(u for u, _ in places) * self._enlargement
        top, bottom = (end(v for _, v in places) * self._enlargement for end in (min, max))
        gap = 3 * self._enlargement
        baseline = top - gap if region.holes else bottom + gap + height
        cv2.putText(
            self._picture,
            caption(region, self._settings.markers),
            (round(left), round(baseline)),
            cv2.FONT_HERSHEY_SIMPLEX,
            size,
            colour,
            self._thickness,
            cv2.LINE_AA,
        )

    def _outline(self, region: Region) -> list[tuple[float, float]]:
        """Corners in the region's own frame (region pixels, x forward)."""
        settings = self._settings
        if region.holes > 0:
            length, width = settings.marker_length, settings.marker_width
            if settings.markers == "tags":
                length = width = settings.tag_size
            a, b = length / MM_PER_PIXEL / 2, width / MM_PER_PIXEL / 2
            return [(a, b), (-a, b), (-a, -b), (a, -b)]
        radius = settings.food_radius / MM_PER_PIXEL
        angles = (2 * math.pi * i / _CIRCLE_POINTS for i in range(_CIRCLE_POINTS))
        return [(radius * math.cos(angle), radius * math.sin(angle)) for angle in angles]

    def _line(
        self, region: Region, points: list[tuple[float, float]], colour: Colour, *, closed: bool = False
    ) -> None:
        """A line through points in the region's own frame (region pixels, x forward)."""
        import cv2

        corners = self._enlargement * np.array([self._frame_point(region, *point) for point in points]) - 0.5
        fixed_point = np.rint(corners * 2**_FRACTIONAL_BITS).astype(np.int32)
        cv2.polylines(
            self._picture, [fixed_point], closed, colour, self._thickness, cv2.LINE_AA, _FRACTIONAL_BITS
        )

    def _frame_point(self, region: Region, forward: float, left: float) -> tuple[float, float]:
        """The point of the frame that shows a point in the region's own frame (region pixels)."""
        heading = math.radians(region.orientation)
        height = self._settings.marker_height if region.holes > 0 else self._settings.food_height
        x = region.x + forward * math.cos(heading) - left * math.sin(heading)
        y = region.y + forward * math.sin(heading) + left * math.cos(heading)
        return self._calibration.to_picture(x, y, height)
