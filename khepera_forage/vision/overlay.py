"""A scene drawn over its frame, for previews and for the documentation."""

import math

import numpy as np
from numpy.typing import NDArray

from khepera_forage.extras import require
from khepera_forage.robots.khepera import MARKER_LENGTH, MARKER_WIDTH
from khepera_forage.vision.calibration import DEFAULT_SIZE, Calibration
from khepera_forage.vision.scene import MM_PER_PIXEL, Region, Scene, kind_text
from khepera_forage.vision.tracker_settings import TrackerSettings
from khepera_forage.vision.video import Frame, as_grey

Colour = tuple[int, int, int]
MARKER: Colour = (255, 90, 60)
FOOD: Colour = (60, 220, 90)
LOST: Colour = (150, 150, 160)
"""Red, green, blue of found markers, of found food and of lost regions."""
_FRACTIONAL_BITS = 4
"""Fractional bits of OpenCV's drawing coordinates."""
_CIRCLE = [(math.cos(math.tau * i / 24), math.sin(math.tau * i / 24)) for i in range(24)]
_TEXT_SIZE, _TEXT_GROWTH = 0.4, 0.2
"""Size of captions in OpenCV's unit, about 22 pixels: in a frame 640 pixels wide, and more for each further 640."""


def draw_scene(
    frame: Frame, scene: Scene, calibration: Calibration | None = None, settings: TrackerSettings | None = None
) -> NDArray[np.uint8]:
    """The frame with its regions: outline, centre, heading of markers, and `caption`; lost regions are grey.

    Args:
        frame: Grey levels, or blue, green and red; not changed.
        scene: The tracker's scene after this frame.
        calibration: The tracker's; None for `Calibration.identity()` at the size of the frame.
        settings: The tracker's, for sizes and heights; None for the defaults.

    Returns:
        A picture of the frame's size: red, green, blue.

    Raises:
        ImportError: OpenCV is not installed.
        ValueError: A frame of another type.
    """
    require("drawing a scene", "camera")
    import cv2

    frame = as_grey(frame)
    picture: NDArray[np.uint8] = cv2.cvtColor(frame, cv2.COLOR_GRAY2RGB)  # type: ignore[assignment]
    settings = settings or TrackerSettings()
    calibration = calibration or Calibration.identity(size=frame.shape[::-1])
    enlargement = max(1, round(frame.shape[1] / DEFAULT_SIZE[0]))
    thickness, size = (enlargement + 1) // 2, _TEXT_SIZE + _TEXT_GROWTH * (enlargement - 1)
    tags, tip = settings.markers == "tags", MARKER_LENGTH / MM_PER_PIXEL * 0.8
    length, width = ((settings.tag_size if tags else side) / MM_PER_PIXEL / 2 for side in (MARKER_LENGTH, MARKER_WIDTH))
    box = [(length, width), (-length, width), (-length, -width), (length, -width)]
    radius = settings.food_radius / MM_PER_PIXEL
    disc = [(radius * x, radius * y) for x, y in _CIRCLE]
    cross = [(-1.5, 0.0), (1.5, 0.0)], [(0.0, -1.5), (0.0, 1.5)]
    arrow = [(0.0, 0.0), (tip, 0.0)], [(tip - 3, 2.5), (tip, 0.0), (tip - 3, -2.5)]
    for region in scene.regions:
        marker = region.holes > 0
        colour = (MARKER if marker else FOOD) if region.found else LOST
        height = settings.marker_height if marker else settings.food_height
        strokes = (box if marker else disc, *cross, *(arrow if marker else ()))
        heading = math.radians(region.orientation)
        cos, sin = math.cos(heading), math.sin(heading)
        drawn = []
        for stroke in strokes:
            places = [(region.x + x * cos - y * sin, region.y + x * sin + y * cos) for x, y in stroke]
            drawn.append(np.array([calibration.to_picture(x, y, height) for x, y in places]))
            points = np.rint((drawn[-1] - 0.5) * 2**_FRACTIONAL_BITS).astype(np.int32)
            closed = stroke is strokes[0]
            cv2.polylines(picture, [points], closed, colour, thickness, cv2.LINE_AA, _FRACTIONAL_BITS)
        outline, *_ = drawn
        # The caption of a marker is above its outline, that of food below, so that neighbours stay apart.
        text, gap = caption(region), 3 * enlargement
        (_, letters), _ = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, size, thickness)
        bottom = outline[:, 1].min() - gap if marker else outline[:, 1].max() + gap + letters
        place = (round(outline[:, 0].min()), round(bottom))
        cv2.putText(picture, text, place, cv2.FONT_HERSHEY_SIMPLEX, size, colour, thickness, cv2.LINE_AA)
    return picture


def caption(region: Region) -> str:
    """What is written beside a region: its label, its kind, and whether it is lost."""
    return f"{region.label}: {kind_text(region)}{'' if region.found else ', lost'}"
