"""From what is bright in a frame to detections: which shape is a marker, which is food, and what to try if neither."""

import math
from collections.abc import Iterator

import numpy as np

from khepera_forage.vision.association import Detection
from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.detection.food_detector import FoodFinder
from khepera_forage.vision.detection.image_patch import Form, Patch, cut
from khepera_forage.vision.detection.marker_detector import MarkerFinder, MarkerSeen
from khepera_forage.vision.detection.segmentation import Bright, Contour, Frame, outer_contours
from khepera_forage.vision.tracker_settings import TrackerSettings

_LEAST = 0.4
"""Share of food's area below which a bright shape is not taken for food."""
_SPECK = 0.15
"""Share of food's area below which a bright spot is not even a piece of something."""
_GAP = 20.0
"""mm: gaps up to that wide (a cable of 10 mm, blurred) are closed between the pieces of what a cable cuts asunder."""
_MOST_FOODS = 4.5
"""How many food objects that touch each other are told apart."""
_MARKER_AREA = (0.5, 3.0)
"""Shares of a marker's area, holes filled: below it is food at most, above a wall or a sheet of paper at least."""

Found = tuple[Detection, bool]
"""A detection, and whether its orientation is the right way round for sure."""


class Finder:
    """Finds markers and food among bright shapes.

    Args:
        settings: Sizes and tolerances.
        calibration: From the picture to the floor.
        scale: Pixels of the picture in a mm, about.
    """

    def __init__(self, settings: TrackerSettings, calibration: Calibration, scale: float) -> None:
        self._settings, self._calibration = settings, calibration
        self._markers = MarkerFinder(settings, calibration, scale)
        self._foods = FoodFinder(settings, calibration)
        self._gap = np.ones((max(1, math.ceil(_GAP * scale)) + 1,) * 2, np.uint8)
        self._food_area = math.pi * settings.food_radius**2 * scale**2
        self._marker_area = settings.marker_length * settings.marker_width * scale**2

    def find(self, bright: Bright) -> list[Found]:
        """All markers and food in a frame."""
        found: list[Found] = []
        rest = []
        for outline in outer_contours(bright.mask):
            if len(outline) ** 2 >= _SPECK * self._food_area:  # a bound that costs nothing: most are specks
                known = list(self._known(bright, outline))
                found += known
                if not known and _filled_area(outline) >= _SPECK * self._food_area:
                    rest.append(outline)
        return found + self._mended(bright, rest) if len(rest) > 1 else found

    def _mended(self, bright: Bright, pieces: list[Contour]) -> list[Found]:
        """What the pieces are that a cable has cut asunder, once its gap is closed."""
        import cv2

        torn = np.zeros_like(bright.mask)
        cv2.drawContours(torn, pieces, -1, 255, cv2.FILLED)
        closed = cv2.morphologyEx(torn, cv2.MORPH_CLOSE, self._gap)
        return [found for outline in outer_contours(closed) for found in self._known(bright, outline)]  # type: ignore[arg-type] # uint8

    def _known(self, bright: Bright, outline: Contour) -> Iterator[Found]:
        """The marker, with food beside it, or the foods that one outline encloses."""
        area = _filled_area(outline)
        least, most = (share * self._marker_area for share in _MARKER_AREA)
        if not _LEAST * self._food_area <= area <= most:
            return
        patch = cut(bright, outline)
        if area >= least:
            marker = self._markers.find(patch)
            if marker is not None:
                yield self._marker(patch, outline, area, marker), marker.sure
                if area > self._marker_area + 0.5 * self._food_area:
                    yield from self._beside(bright, patch, marker)
                return
        food = self._foods.find(patch)
        if food is not None:
            yield self._food(patch, outline, area, food), True
        elif area < _MOST_FOODS * self._food_area:
            for food, shape in self._foods.part(patch):
                yield self._piece(patch, shape, food), True

    def _beside(self, bright: Bright, patch: Patch, marker: MarkerSeen) -> Iterator[Found]:
        """Food whose outline has run into a marker's."""
        import cv2

        rest = cv2.subtract(
            cv2.bitwise_and(patch.filled, patch.white), cv2.dilate(marker.shape, np.ones((3, 3)))
        )
        for outline in outer_contours(rest):  # type: ignore[arg-type] # uint8
            outline += np.array([patch.column, patch.row], np.int32)
            area = _filled_area(outline)
            if area >= _LEAST * self._food_area:
                part = cut(bright, outline)
                food = self._foods.find(part)
                if food is not None:
                    yield self._food(part, outline, area, food), True

    def _marker(self, patch: Patch, outline: Contour, area: float, marker: MarkerSeen) -> Detection:
        seen = marker.form
        orientation = round(math.degrees(marker.heading)) % 360
        settings = self._settings
        return self._detection(
            patch, outline, area, seen, settings.marker_height, marker.holes, orientation, marker.holes_area
        )

    def _food(self, patch: Patch, outline: Contour, area: float, food: Form) -> Detection:
        return self._detection(patch, outline, area, food, self._settings.food_height)

    def _piece(self, patch: Patch, shape: Frame, food: Form) -> Detection:
        """One of several foods that touch."""
        outline = max(outer_contours(shape), key=len) + np.array([patch.column, patch.row], np.int32)
        return self._detection(patch, outline, _filled_area(outline), food, self._settings.food_height)

    def _detection(
        self,
        patch: Patch,
        outline: Contour,
        area: float,
        seen: Form,
        height: float,
        holes: int = 0,
        orientation: int = 0,
        holes_area: float = 0.0,
    ) -> Detection:
        import cv2

        unit = self._calibration.stretch(seen.u, seen.v, height).area
        area = area * unit - holes_area
        # The contour runs through the middles of the border pixels; around them it is longer by pi.
        perimeter = (cv2.arcLength(outline, True) + math.pi) * math.sqrt(unit)
        column, row = min(outline[:, 0].tolist(), key=lambda p: (p[1], p[0]))
        first_x, first_y = self._calibration.to_region(column + 0.5, row + 0.5, height)
        return Detection(
            seen.x,
            seen.y,
            holes,
            orientation,
            patch.edge,
            first_x,
            first_y,
            area,
            perimeter,
            perimeter * perimeter / area,
        )


def _filled_area(outline: Contour) -> float:
    """Pixels within an outline, its own included (Pick's theorem)."""
    import cv2

    return cv2.contourArea(outline) + len(outline) / 2 + 1
