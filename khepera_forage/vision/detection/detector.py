"""From the bright shapes of a frame to detections: markers, food, food beside a marker, and shapes split by a cable."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import cv2
import numpy as np

from khepera_forage.vision.association import Detection
from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.detection.food_detector import FoodDetector
from khepera_forage.vision.detection.hole_pattern import Reading
from khepera_forage.vision.detection.marker_detector import DetectedMarker, MarkerDetector
from khepera_forage.vision.detection.segmentation import (
    Contour,
    Frame,
    ImagePatch,
    Segmentation,
    ShapeMoments,
    cut_patch,
    filled_area,
    outer_contours,
)
from khepera_forage.vision.image_quality import BLUR_LIMIT, white_and_blur
from khepera_forage.vision.scene import place_text
from khepera_forage.vision.tracker_settings import TrackerSettings

_MIN_FOOD_AREA = 0.4
"""Share of food's area below which a bright shape is not taken for food."""
_MIN_PIECE_AREA = 0.15
"""Share of food's area below which a bright shape is not taken for a piece of anything."""
_GAP = 20.0
"""Width in mm of the gaps that are closed between the pieces of a shape split by a cable (12 mm wide, blurred)."""
_MAX_TOUCHING_FOODS = 4.5
"""Area, in food objects, below which a shape may consist of touching food objects."""
_MARKER_AREA = (0.5, 3.0)
"""Least and greatest area of a marker, holes filled, as shares of its true area: smaller shapes are at most food,
larger ones are walls or sheets of paper."""
_WIDE, _LONG, _CORE = 1.4, 2.4, 0.7
"""Diameters of food: shapes that are wider, or longer, are walls; and the least width of food beside them."""
_MEASURE_INTERVAL, _NEWEST, _LEAST_BLUR = 5, 0.3, 0.5
"""Markers from one measurement of white to the next, the weight of the newest, and the least blur in pixels."""
_PART = 0.35
"""Share of a marker's area from which a shape that is no marker is reported."""

TROUBLES = {
    "glare": "a reflection lies over the marker at {place}: move the lamp, or print on matt paper",
    "cover": "the white of the marker at {place} is not where it should be: something covers a part of it, or the hard "
    "edge of a shadow lies over it",
    "pale holes": "the holes of the marker at {place} are too pale: print them black",
    "cables": "cables hide the holes of the marker at {place}: lead them elsewhere",
    "holes": "the holes of the marker at {place} are those of no marker in use, or a reflection hides some",
    "reflection": "the bright spot at {place} has no sharp border: it is no food, but a reflection, or out of focus",
    "bright food": "the bright spot at {place} is brighter than white paper: a reflection",
}
"""What makes a shape uncertain, with its remedy."""


class _Piece(NamedTuple):
    """A bright shape: its contour, and the number of pixels within it."""

    contour: Contour
    area: float


def _pieces(mask: Frame, offset: tuple[int, int] = (0, 0)) -> list[_Piece]:
    """The bright shapes of a mask that begins at a column and row of the picture."""
    contours = (contour + np.array(offset, np.int32) for contour in outer_contours(mask))
    return [_Piece(contour, filled_area(contour)) for contour in contours]


class Detector:
    """Detects markers and food among the bright shapes of a frame.

    Attributes:
        warnings: Shapes of the last frame that are not reported, because they would be uncertain: `TROUBLES`, by key.
    """

    def __init__(self, settings: TrackerSettings, calibration: Calibration) -> None:
        self.warnings: dict[str, str] = {}
        self._settings, self._calibration = settings, calibration
        self._markers, self._foods = (
            MarkerDetector(settings, calibration),
            FoodDetector(settings, calibration),
        )
        scale = 1 / calibration.mm_per_pixel()
        self._gap_kernel = np.ones((max(1, math.ceil(_GAP * scale)) + 1,) * 2, np.uint8)
        diameter = 2 * settings.food_radius * scale
        wide, long, core = (max(3, round(share * diameter)) for share in (_WIDE, _LONG, _CORE))
        line, diagonal = np.ones((1, long), np.uint8), np.eye(round(long / math.sqrt(2)), dtype=np.uint8)
        self._wall_kernels: list[list[Frame]] = [
            [cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (wide, wide))],  # type: ignore[list-item] # uint8
            [line, line.T, diagonal, np.ascontiguousarray(diagonal[::-1])],
        ]
        self._food_kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (core, core))
        self._food_area = math.pi * settings.food_radius**2 * scale**2
        self._marker_area = settings.marker_length * settings.marker_width * scale**2
        self._diagonal = math.hypot(settings.marker_length, settings.marker_width) * scale
        self._least, self._most = (share * self._marker_area for share in _MARKER_AREA)
        self._white, self._blur, self._until_measured = 0.0, BLUR_LIMIT, 0

    def detect(self, segmentation: Segmentation, markers: bool = True) -> list[Detection]:
        """All food in a frame, and all markers with holes unless robots carry tags."""
        self.warnings = {}
        least = _MIN_PIECE_AREA * self._food_area
        # The contour's length bounds the area from above and is cheap: most shapes are specks.
        contours = [c for c in outer_contours(segmentation.mask) if len(c) ** 2 >= least]
        pieces = [piece for piece in (_Piece(c, filled_area(c)) for c in contours) if piece.area >= least]
        seen: list[DetectedMarker] = []
        found: list[Detection] = []
        if markers:
            found, pieces = self._markers_among(segmentation, pieces, seen, joined=False)
        walls = [piece.contour for piece in pieces if piece.area > self._most]
        rest = small = [piece for piece in pieces if piece.area <= self._most]
        if markers and sum(piece.area for piece in rest) >= self._least:
            # A cable cuts a marker in pieces, or cuts notches into its border.
            joined = self._joined(segmentation, rest)
            found += self._markers_among(segmentation, joined, seen, joined=True)[0]
        rest = [piece for piece in rest if not any(_covers(marker, piece) for marker in seen)]
        foods, rest = self._foods_among(segmentation, rest)
        found += foods
        if len(rest) > 1:
            foods, rest = self._foods_among(segmentation, self._joined(segmentation, rest))
            found += foods
        for piece in rest if markers else ():
            self._report_cover(piece)
        if walls:
            found += self._foods_at_walls(segmentation, walls, [piece.contour for piece in small])
        return found

    def _markers_among(
        self, segmentation: Segmentation, pieces: list[_Piece], markers: list[DetectedMarker], joined: bool
    ) -> tuple[list[Detection], list[_Piece]]:
        """Detections of the markers among some pieces, and the other pieces.

        All markers are added to `markers`, even those whose number is uncertain. Unless the pieces result from joining,
        food whose contour has merged with a marker's is detected, too; joined pieces of food are detected on their own.
        """
        found: list[Detection] = []
        rest = []
        for piece in pieces:
            marker = None
            if self._least <= piece.area <= self._most:
                patch = cut_patch(segmentation, piece.contour)
                marker = self._markers.detect(segmentation.frame, patch, joined)
            if marker is None:
                rest.append(piece)
                continue
            markers.append(marker)
            if marker.reading.number:
                self._measure_white(patch)
                found.append(self._detection(piece, patch.edge, marker.moments, marker.reading))
            else:
                self._report(marker.reading.trouble, marker.moments.x, marker.moments.y)
            if not joined and piece.area > self._marker_area + 0.5 * self._food_area:
                found += self._foods_beside(segmentation, patch, marker)
        return found, rest

    def _foods_among(
        self, segmentation: Segmentation, pieces: list[_Piece]
    ) -> tuple[list[Detection], list[_Piece]]:
        """Detections of the food among some pieces, and the other pieces."""
        found: list[Detection] = []
        rest = []
        for piece in pieces:
            foods = list(self._foods_in(segmentation, piece))
            found += foods
            if not foods:
                rest.append(piece)
        return found, rest

    def _foods_in(self, segmentation: Segmentation, piece: _Piece) -> Iterator[Detection]:
        """The food objects that one contour encloses."""
        if piece.area < _MIN_FOOD_AREA * self._food_area:
            return
        patch = cut_patch(segmentation, piece.contour)
        food = self._foods.detect(patch)
        if food is not None:
            trouble = self._foods.trouble(patch, food, self._white, self._blur)
            if trouble:
                self._report(trouble, food.x, food.y)
            else:
                yield self._detection(piece, patch.edge, food)
        elif piece.area < _MAX_TOUCHING_FOODS * self._food_area:
            for food, mask in self._foods.split(patch):
                part = max(_pieces(mask, (patch.column, patch.row)), key=lambda piece: len(piece.contour))
                yield self._detection(part, patch.edge, food)

    def _foods_beside(
        self, segmentation: Segmentation, patch: ImagePatch, marker: DetectedMarker
    ) -> list[Detection]:
        """Food whose contour has merged with a marker's."""
        mask = np.zeros_like(patch.filled)
        corners = marker.corners - 0.5 - (patch.column, patch.row)
        cv2.fillConvexPoly(mask, np.rint(corners * 16).astype(np.int32), 255, cv2.LINE_8, 4)
        mask = cv2.dilate(mask, np.ones((3, 3)))  # type: ignore[assignment] # uint8
        rest = patch.filled & patch.white & ~mask
        return self._foods_among(segmentation, _pieces(rest, (patch.column, patch.row)))[0]

    def _foods_at_walls(
        self, segmentation: Segmentation, walls: list[Contour], others: list[Contour]
    ) -> Iterator[Detection]:
        """Food that touches bright walls or a bright surface: what remains without long and wide shapes."""
        mask = np.zeros_like(segmentation.mask)
        cv2.drawContours(mask, walls, -1, 255, cv2.FILLED)
        cv2.drawContours(mask, others, -1, 0, cv2.FILLED)
        mask &= segmentation.mask
        for kernels in self._wall_kernels:
            mask &= ~np.max([cv2.morphologyEx(mask, cv2.MORPH_OPEN, kernel) for kernel in kernels], axis=0)
        for piece in _pieces(cv2.morphologyEx(mask, cv2.MORPH_OPEN, self._food_kernel)):  # type: ignore[arg-type] # uint8
            patch = cut_patch(segmentation, piece.contour)
            food = self._foods.detect(patch, rim=True)
            if food is not None:
                yield self._detection(piece, patch.edge, food)

    def _joined(self, segmentation: Segmentation, pieces: list[_Piece]) -> list[_Piece]:
        """The shapes that result when the gaps between pieces, and their notches, are closed."""
        mask = np.zeros_like(segmentation.mask)
        cv2.drawContours(mask, [piece.contour for piece in pieces], -1, 255, cv2.FILLED)
        return _pieces(cv2.morphologyEx(mask, cv2.MORPH_CLOSE, self._gap_kernel))  # type: ignore[arg-type] # uint8

    def _measure_white(self, patch: ImagePatch) -> None:
        """Measure, now and then, what the white of a marker looks like: food looks the same."""
        self._until_measured -= 1
        if self._until_measured < 0:
            self._until_measured = _MEASURE_INTERVAL
            white, blur = white_and_blur(patch.grey, patch.filled > 0, max(patch.floor, 1))
            share = _NEWEST if self._white else 1.0
            self._white += share * (white - self._white)
            self._blur += share * (max(blur, _LEAST_BLUR) - self._blur)

    def _report_cover(self, piece: _Piece) -> None:
        """Report a shape that may be a part of a marker."""
        (u, v), (length, width), _ = cv2.minAreaRect(piece.contour)
        if piece.area >= _PART * self._marker_area and math.hypot(length, width) <= 1.2 * self._diagonal:
            self._report(
                "cover", *self._calibration.to_region(u + 0.5, v + 0.5, self._settings.marker_height)
            )

    def _report(self, trouble: str, x: float, y: float) -> None:
        self.warnings[trouble] = TROUBLES[trouble].format(place=place_text(x, y))

    def _detection(
        self, piece: _Piece, edge: bool, moments: ShapeMoments, marker: Reading | None = None
    ) -> Detection:
        """The detection of food, or of a marker."""
        height = self._settings.food_height if marker is None else self._settings.marker_height
        unit = self._calibration.jacobian(moments.u, moments.v, height).area
        contour, area = piece.contour, piece.area * unit
        holes = orientation = 0
        if marker is not None:
            holes, orientation = marker.number, round(math.degrees(moments.axis)) % 360
            area -= marker.area
        # The contour runs through the middles of the border pixels; the outline around them is longer by pi.
        perimeter = (cv2.arcLength(contour, True) + math.pi) * math.sqrt(unit)
        rows = contour[:, 0, 1]
        row = int(rows.min())
        column = int(contour[rows == row, 0, 0].min())
        first = self._calibration.to_region(column + 0.5, row + 0.5, height)
        compactness = perimeter * perimeter / area
        return Detection(moments.x, moments.y, holes, orientation, edge, *first, area, perimeter, compactness)


def _covers(marker: DetectedMarker, piece: _Piece) -> bool:
    """Whether the middle of a piece lies within a marker."""
    middle = piece.contour.mean(axis=(0, 1)) + 0.5
    return cv2.pointPolygonTest(marker.corners.astype(np.float32), middle.tolist(), False) >= 0
