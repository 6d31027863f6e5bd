"""A detector as simple as the thesis describes it: one threshold, contours, and the number of holes (3.5).

The tracker closes gaps as narrow as a cable, and reads holes in the upright marker. This detector does neither, and so
shows what cables do to an image without such repairs.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from khepera_forage.vision.association import Detection
from khepera_forage.vision.rendering.appearance import CameraAppearance
from khepera_forage.vision.shapes import FOOD_FEATURES, MARKER_FEATURES, PICTURE_HEIGHT

_APPEARANCE = CameraAppearance.laboratory()
LEVEL = (_APPEARANCE.floor + _APPEARANCE.white) / 2
"""Halfway between floor and white in the middle of the image."""
_MARKER = 0.5 * MARKER_FEATURES[2].area
"""Smallest marker, in square pixels."""
_FOOD = (0.6 * FOOD_FEATURES.area, 1.6 * FOOD_FEATURES.area)
_HOLE = 2.0
"""Square pixels below which a dark spot is noise."""


def regions(frame: NDArray[np.uint8]) -> list[Detection]:
    """The regions of a frame by threshold and contours; orientations are not read."""
    bright = (frame > LEVEL).astype(np.uint8)
    contours, hierarchy = cv2.findContours(bright, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    if hierarchy is None:
        return []
    parents = hierarchy[0, :, 3].tolist()
    areas = [cv2.contourArea(contour) for contour in contours]
    found = []
    for i, contour in enumerate(contours):
        if parents[i] >= 0:
            continue
        # A contour runs through the middles of its pixels, so half a pixel lies outside it all along.
        length = cv2.arcLength(contour, True)
        area = areas[i] + length / 2 + 1
        holes = sum(parent == i and areas[j] >= _HOLE for j, parent in enumerate(parents))
        marker = holes in (1, 2) and area >= _MARKER
        if marker or (holes == 0 and _FOOD[0] <= area <= _FOOD[1]):
            u, v = _centroid(contour)
            x, y = float(u) + 0.5, PICTURE_HEIGHT - float(v) - 0.5
            found.append(Detection(x, y, holes, 0, False, x, y, area, length, length * length / area))
    return found


def _centroid(contour: cv2.typing.MatLike) -> tuple[float, float]:
    moments = cv2.moments(contour)
    return moments["m10"] / moments["m00"], moments["m01"] / moments["m00"]
