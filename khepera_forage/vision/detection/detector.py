"""From the bright shapes of a frame to detections: markers, food, food beside a marker, and shapes split by a cable."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from khepera_forage.vision.association import Detection
from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.detection.food_detector import FoodDetector
from khepera_forage.vision.detection.image_patch import ImagePatch, ShapeMoments, cut_patch
from khepera_forage.vision.detection.marker_detector import DetectedMarker, MarkerDetector
from khepera_forage.vision.detection.segmentation import Contour, Frame, Segmentation, outer_contours
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


class OrientedDetection(NamedTuple):
    """A detection, and whether its orientation is certain; if not, it may be off by 180 degrees."""

    detection: Detection
    front_known: bool


class _Piece(NamedTuple):
    """A bright shape: its contour, and the number of pixels within it."""

    contour: Contour
    area: float


class Detector:
    """Detects markers and food among the bright shapes of a frame.

    Args:
        settings: Sizes and tolerances.
        calibration: From the picture to the floor.
        scale: Approximate number of picture pixels per mm.
    """

    def __init__(self, settings: TrackerSettings, calibration: Calibration, scale: float) -> None:
        self._settings, self._calibration = settings, calibration
        self._markers = MarkerDetector(settings, calibration, scale)
        self._foods = FoodDetector(settings, calibration)
        self._gap_kernel = np.ones((max(1, math.ceil(_GAP * scale)) + 1,) * 2, np.uint8)
        self._food_area = math.pi * settings.food_radius**2 * scale**2
        self._marker_area = settings.marker_length * settings.marker_width * scale**2
        self._least, self._most = (share * self._marker_area for share in _MARKER_AREA)

    def detect(self, segmentation: Segmentation) -> list[OrientedDetection]:
        """All markers and food in a frame."""
        pieces = []
        for contour in outer_contours(segmentation.mask):
            # The contour's length bounds the area from above and is cheap: most shapes are specks.
            if len(contour) ** 2 >= _MIN_PIECE_AREA * self._food_area:
                area = _filled_area(contour)
                if area >= _MIN_PIECE_AREA * self._food_area:
                    pieces.append(_Piece(contour, area))
        markers: list[DetectedMarker] = []
        found, pieces = self._markers_among(segmentation, pieces, markers, joined=False)
        rest = [piece for piece in pieces if piece.area <= self._most]
        if sum(piece.area for piece in rest) >= self._least:
            # A cable cuts a marker in pieces, or cuts notches into its border.
            joined = self._joined(segmentation, rest)
            found += self._markers_among(segmentation, joined, markers, joined=True)[0]
        covered = [self._markers.covered(marker, [piece.contour for piece in rest]) for marker in markers]
        rest = [piece for number, piece in enumerate(rest) if not any(on[number] for on in covered)]
        foods, rest = self._foods_among(segmentation, rest)
        if len(rest) > 1:
            foods += self._foods_among(segmentation, self._joined(segmentation, rest))[0]
        return found + foods

    def _markers_among(
        self, segmentation: Segmentation, pieces: list[_Piece], markers: list[DetectedMarker], joined: bool
    ) -> tuple[list[OrientedDetection], list[_Piece]]:
        """Detections of the markers among some pieces, and the other pieces.

        Args:
            segmentation: Of the frame.
            pieces: Bright shapes.
            markers: All markers are added to this list, even those whose number of holes is uncertain.
            joined: Whether the pieces result from joining. If not, food whose contour has merged with a marker's is
                detected, too; joined pieces of food are detected on their own.
        """
        found: list[OrientedDetection] = []
        rest = []
        for piece in pieces:
            patch = (
                cut_patch(segmentation, piece.contour) if self._least <= piece.area <= self._most else None
            )
            marker = None if patch is None else self._markers.detect(patch, joined)
            if patch is None or marker is None:
                rest.append(piece)
                continue
            markers.append(marker)
            if marker.holes:
                found.append(OrientedDetection(self._marker(patch, piece, marker), marker.front_known))
            if not joined and piece.area > self._marker_area + 0.5 * self._food_area:
                found += self._food_beside(segmentation, patch, marker)
        return found, rest

    def _foods_among(
        self, segmentation: Segmentation, pieces: list[_Piece]
    ) -> tuple[list[OrientedDetection], list[_Piece]]:
        """Detections of the food among some pieces, and the other pieces."""
        found: list[OrientedDetection] = []
        rest = []
        for piece in pieces:
            foods = list(self._foods_in(segmentation, piece))
            found += foods
            if not foods:
                rest.append(piece)
        return found, rest

    def _joined(self, segmentation: Segmentation, pieces: list[_Piece]) -> list[_Piece]:
        """The shapes that result when the gaps between pieces, and their notches, are closed."""
        import cv2

        mask = np.zeros_like(segmentation.mask)
        cv2.drawContours(mask, [piece.contour for piece in pieces], -1, 255, cv2.FILLED)
        closed = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, self._gap_kernel)
        return [_Piece(contour, _filled_area(contour)) for contour in outer_contours(closed)]  # type: ignore[arg-type] # uint8

    def _foods_in(self, segmentation: Segmentation, piece: _Piece) -> Iterator[OrientedDetection]:
        """The food objects that one contour encloses."""
        if piece.area < _MIN_FOOD_AREA * self._food_area:
            return
        patch = cut_patch(segmentation, piece.contour)
        food = self._foods.detect(patch)
        if food is not None:
            yield OrientedDetection(self._food(patch, piece, food), True)
        elif piece.area < _MAX_TOUCHING_FOODS * self._food_area:
            for food, mask in self._foods.split(patch):
                yield OrientedDetection(self._split_food(patch, mask, food), True)

    def _food_beside(
        self, segmentation: Segmentation, patch: ImagePatch, marker: DetectedMarker
    ) -> Iterator[OrientedDetection]:
        """Food whose contour has merged with a marker's."""
        import cv2

        rest = cv2.subtract(
            cv2.bitwise_and(patch.filled, patch.white), cv2.dilate(marker.mask, np.ones((3, 3)))
        )
        for contour in outer_contours(rest):  # type: ignore[arg-type] # uint8
            contour += np.array([patch.column, patch.row], np.int32)
            piece = _Piece(contour, _filled_area(contour))
            if piece.area >= _MIN_FOOD_AREA * self._food_area:
                part = cut_patch(segmentation, contour)
                food = self._foods.detect(part)
                if food is not None:
                    yield OrientedDetection(self._food(part, piece, food), True)

    def _marker(self, patch: ImagePatch, piece: _Piece, marker: DetectedMarker) -> Detection:
        orientation = round(math.degrees(marker.heading)) % 360
        return self._detection(
            patch,
            piece,
            marker.moments,
            self._settings.marker_height,
            marker.holes,
            orientation,
            marker.holes_area,
        )

    def _food(self, patch: ImagePatch, piece: _Piece, food: ShapeMoments) -> Detection:
        return self._detection(patch, piece, food, self._settings.food_height)

    def _split_food(self, patch: ImagePatch, mask: Frame, food: ShapeMoments) -> Detection:
        """One of several touching food objects, given by its mask."""
        contour = max(outer_contours(mask), key=len) + np.array([patch.column, patch.row], np.int32)
        return self._food(patch, _Piece(contour, _filled_area(contour)), food)

    def _detection(
        self,
        patch: ImagePatch,
        piece: _Piece,
        moments: ShapeMoments,
        height: float,
        holes: int = 0,
        orientation: int = 0,
        holes_area: float = 0.0,
    ) -> Detection:
        import cv2

        unit = self._calibration.jacobian(moments.u, moments.v, height).area
        contour, area = piece.contour, piece.area * unit - holes_area
        # The contour runs through the middles of the border pixels; the outline around them is longer by pi.
        perimeter = (cv2.arcLength(contour, True) + math.pi) * math.sqrt(unit)
        rows = contour[:, 0, 1]
        row = int(rows.min())
        column = int(contour[rows == row, 0, 0].min())
        first_x, first_y = self._calibration.to_region(column + 0.5, row + 0.5, height)
        return Detection(
            moments.x,
            moments.y,
            holes,
            orientation,
            patch.edge,
            first_x,
            first_y,
            area,
            perimeter,
            perimeter * perimeter / area,
        )


def _filled_area(contour: Contour) -> float:
    """Number of pixels within a contour, border pixels included (Pick's theorem)."""
    import cv2

    return cv2.contourArea(contour) + len(contour) / 2 + 1
