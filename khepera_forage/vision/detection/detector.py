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
from khepera_forage.vision.image_quality import BLUR_LIMIT, white_and_blur
from khepera_forage.vision.scene import MM_PER_PIXEL
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

_WIDE, _LONG, _CORE = 1.4, 2.4, 0.7
"""Diameters of food: shapes that are wider, or longer, are walls; and the least width of food beside them."""
_MEASURE_INTERVAL, _NEWEST, _LEAST_BLUR = 5, 0.3, 0.5
"""Markers from one measurement of white to the next, the weight of the newest, and the least blur in pixels."""
_PART = 0.35
"""Share of a marker's area from which a shape that is no marker is reported."""


class Trouble(NamedTuple):
    """A shape that is not reported, because it would be uncertain.

    Attributes:
        kind: A key of `TROUBLES`.
        x: In region pixels.
        y: In region pixels.
    """

    kind: str
    x: float
    y: float

    @property
    def text(self) -> str:
        """The trouble in one sentence."""
        place = f"({self.x * MM_PER_PIXEL:.0f}, {self.y * MM_PER_PIXEL:.0f}) mm"
        return TROUBLES[self.kind].format(place=place)


class Found(NamedTuple):
    """What a frame shows.

    Attributes:
        detections: Markers and food.
        troubles: Uncertain shapes.
    """

    detections: list[Detection]
    troubles: list[Trouble]


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
        import cv2

        self._settings, self._calibration = settings, calibration
        self._markers = MarkerDetector(settings, calibration, scale)
        self._foods = FoodDetector(settings, calibration)
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
        self._troubles: list[Trouble] = []
        self._white, self._blur, self._until_measured = 0.0, BLUR_LIMIT, 0
        self._least, self._most = (share * self._marker_area for share in _MARKER_AREA)

    def detect(self, segmentation: Segmentation, markers: bool = True) -> Found:
        """All food in a frame, and all markers with holes unless robots carry tags."""
        pieces = []
        for contour in outer_contours(segmentation.mask):
            # The contour's length bounds the area from above and is cheap: most shapes are specks.
            if len(contour) ** 2 >= _MIN_PIECE_AREA * self._food_area:
                area = _filled_area(contour)
                if area >= _MIN_PIECE_AREA * self._food_area:
                    pieces.append(_Piece(contour, area))
        self._troubles = []
        seen: list[DetectedMarker] = []
        found: list[Detection] = []
        if markers:
            found, pieces = self._markers_among(segmentation, pieces, seen, joined=False)
        rest = [piece for piece in pieces if piece.area <= self._most]
        if markers and sum(piece.area for piece in rest) >= self._least:
            # A cable cuts a marker in pieces, or cuts notches into its border.
            joined = self._joined(segmentation, rest)
            found += self._markers_among(segmentation, joined, seen, joined=True)[0]
        covered = [self._markers.covered(marker, [piece.contour for piece in rest]) for marker in seen]
        rest = [piece for number, piece in enumerate(rest) if not any(on[number] for on in covered)]
        foods, rest = self._foods_among(segmentation, rest)
        if len(rest) > 1:
            more, rest = self._foods_among(segmentation, self._joined(segmentation, rest))
            foods += more
        for piece in rest if markers else ():
            self._report_cover(piece)
        walls = [piece.contour for piece in pieces if piece.area > self._most]
        if walls:
            others = [piece.contour for piece in pieces if piece.area <= self._most]
            foods += self._foods_at_walls(segmentation, walls, others)
        return Found(found + foods, self._troubles)

    def _foods_at_walls(
        self, segmentation: Segmentation, walls: list[Contour], others: list[Contour]
    ) -> list[Detection]:
        """Food that touches bright walls or a bright surface: what remains without long and wide shapes."""
        import cv2

        mask = np.zeros_like(segmentation.mask)
        cv2.drawContours(mask, walls, -1, 255, cv2.FILLED)
        cv2.drawContours(mask, others, -1, 0, cv2.FILLED)
        cv2.bitwise_and(mask, segmentation.mask, dst=mask)
        for kernels in self._wall_kernels:
            wall = np.max([cv2.morphologyEx(mask, cv2.MORPH_OPEN, kernel) for kernel in kernels], axis=0)
            mask &= ~wall
        mask = cv2.morphologyEx(mask, cv2.MORPH_OPEN, self._food_kernel)  # type: ignore[assignment] # uint8
        found = []
        for contour in outer_contours(mask):
            patch, piece = cut_patch(segmentation, contour), _Piece(contour, _filled_area(contour))
            food = self._foods.detect(patch, rim=True)
            if food is not None:
                found.append(self._food(patch, piece, food))
        return found

    def _report_cover(self, piece: _Piece) -> None:
        """Report a shape that may be a part of a marker."""
        import cv2

        (u, v), (length, width), _ = cv2.minAreaRect(piece.contour)
        if piece.area >= _PART * self._marker_area and math.hypot(length, width) <= 1.2 * self._diagonal:
            x, y = self._calibration.to_region(u + 0.5, v + 0.5, self._settings.marker_height)
            self._troubles.append(Trouble("cover", x, y))

    def _markers_among(
        self, segmentation: Segmentation, pieces: list[_Piece], markers: list[DetectedMarker], joined: bool
    ) -> tuple[list[Detection], list[_Piece]]:
        """Detections of the markers among some pieces, and the other pieces.

        Args:
            segmentation: Of the frame.
            pieces: Bright shapes.
            markers: All markers are added to this list, even those whose number is uncertain.
            joined: Whether the pieces result from joining. If not, food whose contour has merged with a marker's is
                detected, too; joined pieces of food are detected on their own.
        """
        found: list[Detection] = []
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
                self._measure_white(patch)
                found.append(self._marker(patch, piece, marker))
            else:
                self._troubles.append(Trouble(marker.trouble, marker.moments.x, marker.moments.y))
            if not joined and piece.area > self._marker_area + 0.5 * self._food_area:
                found += self._food_beside(segmentation, patch, marker)
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

    def _joined(self, segmentation: Segmentation, pieces: list[_Piece]) -> list[_Piece]:
        """The shapes that result when the gaps between pieces, and their notches, are closed."""
        import cv2

        mask = np.zeros_like(segmentation.mask)
        cv2.drawContours(mask, [piece.contour for piece in pieces], -1, 255, cv2.FILLED)
        closed = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, self._gap_kernel)
        return [_Piece(contour, _filled_area(contour)) for contour in outer_contours(closed)]  # type: ignore[arg-type] # uint8

    def _foods_in(self, segmentation: Segmentation, piece: _Piece) -> Iterator[Detection]:
        """The food objects that one contour encloses."""
        if piece.area < _MIN_FOOD_AREA * self._food_area:
            return
        patch = cut_patch(segmentation, piece.contour)
        food = self._foods.detect(patch)
        if food is not None:
            if not self._is_reflection(patch, food):
                yield self._food(patch, piece, food)
        elif piece.area < _MAX_TOUCHING_FOODS * self._food_area:
            for food, mask in self._foods.split(patch):
                yield self._split_food(patch, mask, food)

    def _is_reflection(self, patch: ImagePatch, food: ShapeMoments) -> bool:
        """Whether a disc may be a reflection; it is then reported as a trouble."""
        trouble = self._foods.trouble(patch, food, self._white, self._blur)
        if trouble:
            self._troubles.append(Trouble(trouble, food.x, food.y))
        return bool(trouble)

    def _measure_white(self, patch: ImagePatch) -> None:
        """Measure, now and then, what the white of a marker looks like: food looks the same."""
        self._until_measured -= 1
        if self._until_measured < 0:
            self._until_measured = _MEASURE_INTERVAL
            white, blur = white_and_blur(patch.grey, patch.filled > 0, max(patch.floor, 1))
            share = _NEWEST if self._white else 1.0
            self._white += share * (white - self._white)
            self._blur += share * (max(blur, _LEAST_BLUR) - self._blur)

    def _food_beside(
        self, segmentation: Segmentation, patch: ImagePatch, marker: DetectedMarker
    ) -> Iterator[Detection]:
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
                if food is not None and not self._is_reflection(part, food):
                    yield self._food(part, piece, food)

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
