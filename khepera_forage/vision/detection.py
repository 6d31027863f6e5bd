"""From the bright shapes of a frame to detections: markers, food, food beside a marker, and shapes split by a cable."""

import math
from collections.abc import Iterator

import cv2
import numpy as np

from khepera_forage.vision.association import Detection
from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.image_quality import BLUR_LIMIT, white_and_blur
from khepera_forage.vision.markers import DetectedMarker, MarkerDetector, Reading, white_ends
from khepera_forage.vision.scene import MM_PER_PIXEL, place_text
from khepera_forage.vision.segmentation import (
    Contour,
    Frame,
    ImagePatch,
    Segmentation,
    ShapeMoments,
    cut_patch,
    filled_area,
    outer_contours,
    shape_moments,
)
from khepera_forage.vision.tracker_settings import TrackerSettings

_MIN_FOOD_AREA, _MIN_PIECE_AREA = 0.4, 0.15
"""Shares of food's area below which a bright shape is not taken for food, and not for a piece of anything."""
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

_MIN_FILL = 0.7
"""Least share of the ellipse with the same moments that food fills; the end of a kinked cable fills less."""
_AREA = (0.8, 1.7)
"""Least and greatest area of a whole disc, as shares of food's true area: a half hidden disc has no known centre, and
overexposed white grows."""
_MAX_EROSIONS = 3
"""Greatest number of erosions by one pixel to separate touching discs."""
_SOFTNESS, _SPREAD = 1.25, 0.2
"""Greatest blur of food's border in pixels: this times that of markers' borders, and a spread."""
_NOT_SATURATED, _SATURATED = 240.0, 0.1
"""Grey level of white below which it is not saturated; and the share of a disc that is saturated in a reflection."""
_CROSS = np.array([[0, 1, 0], [1, 1, 1], [0, 1, 0]], np.uint8)
_ROUND = 0.98
"""Ratio of the axes from which a shape is taken for a whole disc: at most 1 % of it is then hidden."""
_STEP, _REACH = 0.25, 2.0
"""Region pixels from one sample of a ray to the next, and between the radius and either end of a ray."""
_HIDDEN = 0.12
"""Region pixels by which the shape ends before the disc's rim where something hides it."""
_RAYS, _LEAST_RAYS, _REPEATS = 36, 15, 8
"""Rays, and rays to the visible rim from which the centre is known."""
_ANGLES = 2 * math.pi * np.arange(_RAYS) / _RAYS
_DIRECTIONS = np.stack((np.cos(_ANGLES), np.sin(_ANGLES)), axis=1)
_TERMS = np.column_stack((_DIRECTIONS, np.ones(_RAYS)))
"""How the edge along each ray changes with a shift of the centre, to first order, and with the radius, which blur and
brightness change a little."""

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


class Detector:
    """Detects markers and food among the bright shapes of a frame.

    Attributes:
        warnings: Shapes of the last frame that are not reported, because they would be uncertain: `TROUBLES`, by key.
    """

    def __init__(self, settings: TrackerSettings, calibration: Calibration) -> None:
        self.warnings: dict[str, str] = {}
        self._settings, self._calibration = settings, calibration
        self._markers = MarkerDetector(settings, calibration)
        self._radius = settings.food_radius / MM_PER_PIXEL
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
        # In pixels of the picture.
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
        pieces = [c for c in contours if filled_area(c) >= least]
        seen: list[DetectedMarker] = []
        found: list[Detection] = []
        if markers:
            found, pieces = self._markers_among(segmentation, pieces, seen, joined=False)
        walls = [piece for piece in pieces if filled_area(piece) > self._most]
        small = [piece for piece in pieces if filled_area(piece) <= self._most]
        if markers and sum(map(filled_area, small)) >= self._least:
            # A cable cuts a marker in pieces, or cuts notches into its border.
            joined = self._joined(segmentation, small)
            found += self._markers_among(segmentation, joined, seen, joined=True)[0]
        rest = [piece for piece in small if not any(_covers(marker, piece) for marker in seen)]
        foods, rest = self._foods_among(segmentation, rest)
        found += foods
        if len(rest) > 1:
            foods, rest = self._foods_among(segmentation, self._joined(segmentation, rest))
            found += foods
        for piece in rest if markers else ():
            self._report_cover(piece)
        if walls:
            found += self._foods_at_walls(segmentation, walls, small)
        return found

    def _markers_among(
        self, segmentation: Segmentation, pieces: list[Contour], markers: list[DetectedMarker], joined: bool
    ) -> tuple[list[Detection], list[Contour]]:
        """Detections of the markers among some pieces, and the other pieces.

        All markers are added to `markers`, even those whose number is uncertain. Unless the pieces result from joining,
        food whose contour has merged with a marker's is detected, too; joined pieces of food are detected on their own.
        """
        found: list[Detection] = []
        rest = []
        for piece in pieces:
            area, marker = filled_area(piece), None
            if self._least <= area <= self._most:
                patch = cut_patch(segmentation, piece)
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
            if not joined and area > self._marker_area + 0.5 * self._food_area:
                # Food whose contour has merged with the marker's.
                mask = np.zeros_like(patch.filled)
                corners = np.rint((marker.corners - 0.5 - (patch.column, patch.row)) * 16).astype(np.int32)
                cv2.fillConvexPoly(mask, corners, 255, cv2.LINE_8, 4)
                mask = cv2.dilate(mask, np.ones((3, 3)))  # type: ignore[assignment] # uint8
                beside = patch.filled & patch.white & ~mask
                others = outer_contours(beside, (patch.column, patch.row))
                found += self._foods_among(segmentation, others)[0]
        return found, rest

    def _foods_among(
        self, segmentation: Segmentation, pieces: list[Contour]
    ) -> tuple[list[Detection], list[Contour]]:
        """Detections of the food among some pieces, and the other pieces."""
        found: list[Detection] = []
        rest = []
        for piece in pieces:
            foods = list(self._foods_in(segmentation, piece))
            found += foods
            if not foods:
                rest.append(piece)
        return found, rest

    def _foods_in(self, segmentation: Segmentation, piece: Contour) -> Iterator[Detection]:
        """The food objects that one contour encloses."""
        area = filled_area(piece)
        if area < _MIN_FOOD_AREA * self._food_area:
            return
        patch = cut_patch(segmentation, piece)
        food = self._disc(patch, patch.filled)
        if food is not None:
            if food.minor < _ROUND * food.major:
                food = self._with_true_centre(patch, food)
            trouble = self._trouble(patch, food)
            if trouble:
                self._report(trouble, food.x, food.y)
            else:
                yield self._detection(piece, patch.edge, food)
        elif area < _MAX_TOUCHING_FOODS * self._food_area:
            for food, mask in self._split(patch):
                part = max(outer_contours(mask, (patch.column, patch.row)), key=len)
                yield self._detection(part, patch.edge, food)

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
        rest = cv2.morphologyEx(mask, cv2.MORPH_OPEN, self._food_kernel)
        for piece in outer_contours(rest):  # type: ignore[arg-type] # uint8
            patch = cut_patch(segmentation, piece)
            food = self._disc(patch, patch.filled)
            if food is not None:
                # The shape has lost or won a part.
                yield self._detection(piece, patch.edge, self._with_true_centre(patch, food))

    def _joined(self, segmentation: Segmentation, pieces: list[Contour]) -> list[Contour]:
        """The shapes that result when the gaps between pieces, and their notches, are closed."""
        mask = np.zeros_like(segmentation.mask)
        cv2.drawContours(mask, pieces, -1, 255, cv2.FILLED)
        return outer_contours(cv2.morphologyEx(mask, cv2.MORPH_CLOSE, self._gap_kernel))  # type: ignore[arg-type] # uint8

    def _measure_white(self, patch: ImagePatch) -> None:
        """Measure, now and then, what the white of a marker looks like: food looks the same."""
        self._until_measured -= 1
        if self._until_measured < 0:
            self._until_measured = _MEASURE_INTERVAL
            white, blur = white_and_blur(patch.grey, patch.filled > 0, max(patch.floor, 1))
            share = _NEWEST if self._white else 1.0
            self._white += share * (white - self._white)
            self._blur += share * (max(blur, _LEAST_BLUR) - self._blur)

    def _report_cover(self, piece: Contour) -> None:
        """Report a shape that may be a part of a marker."""
        (u, v), size, _ = cv2.minAreaRect(piece)
        if filled_area(piece) >= _PART * self._marker_area and math.hypot(*size) <= 1.2 * self._diagonal:
            place = self._calibration.to_region(u + 0.5, v + 0.5, self._settings.marker_height)
            self._report("cover", *place)

    def _report(self, trouble: str, x: float, y: float) -> None:
        self.warnings[trouble] = TROUBLES[trouble].format(place=place_text(x, y))

    def _detection(
        self, contour: Contour, edge: bool, moments: ShapeMoments, marker: Reading | None = None
    ) -> Detection:
        """The detection of food, or of a marker."""
        height = self._settings.food_height if marker is None else self._settings.marker_height
        unit = self._calibration.jacobian(moments.u, moments.v, height).area
        area = filled_area(contour) * unit
        holes = orientation = 0
        if marker is not None:
            holes, orientation = marker.number, round(math.degrees(moments.axis)) % 360
            area -= marker.area
        # The contour runs through the middles of the border pixels; the outline around them is longer by pi.
        perimeter = (cv2.arcLength(contour, True) + math.pi) * math.sqrt(unit)
        column, row = min(contour[:, 0].tolist(), key=lambda pixel: pixel[::-1])
        first = self._calibration.to_region(column + 0.5, row + 0.5, height)
        compactness = perimeter * perimeter / area
        return Detection(moments.x, moments.y, holes, orientation, edge, *first, area, perimeter, compactness)

    # ------------------------------------------------------------------ discs

    def _disc(self, patch: ImagePatch, mask: Frame) -> ShapeMoments | None:
        """Moments of a shape of food's size; None for anything else."""
        moments = shape_moments(patch, mask, self._calibration, self._settings.food_height)
        if moments is None or not _AREA[0] <= moments.area / (math.pi * self._radius**2) <= _AREA[1]:
            return None
        if moments.area < _MIN_FILL * 4 * math.pi * moments.major * moments.minor:
            return None
        # The standard deviation of a disc along any axis is half its radius.
        ratios = (deviation * 2 / self._radius for deviation in (moments.major, moments.minor))
        return moments if all(abs(ratio - 1) <= self._settings.tolerance for ratio in ratios) else None

    def _trouble(self, patch: ImagePatch, food: ShapeMoments) -> str:
        """Why a disc may be a reflection on the floor: a key of `TROUBLES`; empty if it is none.

        A reflection that is as large as food has a softer border than the lens's blur makes, or it is brighter than
        white.
        """
        if 0 < self._white * patch.floor < _NOT_SATURATED:
            unit = self._calibration.jacobian(food.u, food.v, self._settings.food_height).area
            saturated = np.count_nonzero((patch.grey == 255) & (patch.filled > 0)) * unit
            if saturated > _SATURATED * math.pi * self._radius**2:
                return "bright food"
        _, softness = white_and_blur(patch.grey, patch.filled > 0, max(patch.floor, 1))
        return "reflection" if softness > _SOFTNESS * self._blur + _SPREAD else ""

    def _split(self, patch: ImagePatch) -> Iterator[tuple[ShapeMoments, Frame]]:
        """The touching food objects in a patch, each with its own mask."""
        # The darker border pixels lower this mean, which helps to separate the discs.
        cores = patch.filled & (patch.grey > cv2.mean(patch.grey, patch.filled)[0])
        for _ in range(_MAX_EROSIONS):
            count, labels = cv2.connectedComponents(cores)
            if count > 2:
                break
            cores = cv2.erode(cores, _CROSS)  # type: ignore[assignment]
        else:
            return
        # Each pixel belongs to the nearest core: the border between two touching discs is then straight.
        distances = [
            cv2.distanceTransform((labels != i).astype(np.uint8), cv2.DIST_L2, 5) for i in range(1, count)
        ]
        nearest = np.argmin(distances, axis=0)
        for i in range(count - 1):
            mask = np.where(nearest == i, patch.filled, np.uint8(0))
            moments = self._disc(patch, mask)
            if moments is not None:
                yield moments, mask

    def _with_true_centre(self, patch: ImagePatch, moments: ShapeMoments) -> ShapeMoments:
        """The moments of a partly hidden disc with the centre of the whole disc, if enough of the rim is visible.

        What hides a part, such as the black frame of a marker, shifts the centre of the rest. Rays from there find the
        edge of the shape in all directions; the rim is a circle through the edge, without the points that lie inside.
        """
        height = self._settings.food_height
        jacobian = self._calibration.jacobian(moments.u, moments.v, height)
        to_picture = np.linalg.inv(np.array(jacobian).reshape(2, 2))
        along = np.arange(max(0.0, self._radius - _REACH), self._radius + _REACH, _STEP)
        start = np.array((moments.u - patch.column, moments.v - patch.row)) - 0.5
        places = start + (_DIRECTIONS @ to_picture.T)[:, None] * along[:, None]
        columns, rows = np.moveaxis(places.astype(np.float32), 2, 0)
        grey = cv2.remap(
            patch.grey.astype(np.float32), columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
        )
        edges = white_ends(grey.astype(np.float64), along, (moments.level + patch.floor) / 2)[:_RAYS]
        visible = np.isfinite(edges)
        shift = np.zeros(3)
        for _ in range(_REPEATS):
            if visible.sum() < _LEAST_RAYS:
                return moments
            shift = np.linalg.lstsq(_TERMS[visible], edges[visible] - self._radius, rcond=None)[0]
            residuals = edges - self._radius - _TERMS @ shift
            # A quarter of the rays at a time, because the hidden part of the rim has shifted the circle, too.
            worst = np.quantile(residuals[visible], 0.25)
            hidden = visible & (residuals < -_HIDDEN) & (residuals <= worst)
            if not hidden.any():
                break
            visible &= ~hidden
        u, v = (np.array(moments[:2]) + to_picture @ shift[:2]).tolist()
        x, y = self._calibration.to_region(u, v, height)
        return moments._replace(u=u, v=v, x=x, y=y)


def _covers(marker: DetectedMarker, piece: Contour) -> bool:
    """Whether the middle of a piece lies within a marker."""
    middle = piece.mean(axis=(0, 1)) + 0.5
    return cv2.pointPolygonTest(marker.corners.astype(np.float32), middle.tolist(), False) >= 0
