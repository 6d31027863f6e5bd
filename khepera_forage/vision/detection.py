"""From a frame to detections: tags, markers, food, food beside a marker, and shapes split by a cable."""

import math
from collections.abc import Iterator, Sequence

import cv2
import numpy as np

from khepera_forage.robots.khepera import MARKER_LENGTH, MARKER_WIDTH
from khepera_forage.vision.association import Detection
from khepera_forage.vision.calibration import Calibration
from khepera_forage.vision.image_quality import BLUR_LIMIT, white_and_blur
from khepera_forage.vision.markers import DetectedMarker, MarkerDetector, Reading, white_ends
from khepera_forage.vision.scene import MM_PER_PIXEL, place_text
from khepera_forage.vision.segmentation import (
    Contour,
    ImagePatch,
    ShapeMoments,
    cut_patch,
    filled_area,
    outer_contours,
    segment,
    shape_moments,
)
from khepera_forage.vision.shapes import Plate, under_plate
from khepera_forage.vision.tags import TagDetector
from khepera_forage.vision.tracker_settings import TrackerSettings
from khepera_forage.vision.video import Frame

_NATIVE = (0.8, 1.25)
"""Region pixels per pixel of a frame between which the frame is used as it is; others are resized to 5 mm a pixel."""
_LEAST_SCALE = 0.55
"""Pixels of a frame per region pixel below which markers with holes cannot be read."""
_LEAST_VIEW = 400.0
"""Least width in mm that a picture shows: an arena is longer, and with places in cm the usual 3200 mm would be 320."""
_NEAR, _DARK, _MOST_DARK = 1.5, 0.6, 0.5
"""Radii of food where floor is expected, the share of the floor's brightness below which a place is dark, and the
least share of dark places around a white part of a tag."""
_CIRCLE = [(math.cos(k * math.pi / 8), math.sin(k * math.pi / 8)) for k in range(16)]
_FLOOR_TAG = 0.75
"""Sides of a floor tag around its middle in which nothing is food, and nothing is reported."""
_CLEARANCE = 13.0
"""Least distance in mm between the disc of food and a marker: the marker's black frame (8 mm), and a pixel of error."""
_FLOOR_TOLERANCE = 0.25
"""Share of the floor's brightness by which a pixel of floor may differ from it: noise, dirt, shade."""
_MIN_FLOOR_SHARE = 0.6
"""Least share of the disc's pixels that look like floor: a cable across the disc hides less, a robot's body more."""
_MAX_BRIGHT_SHARE = 0.1
"""Greatest share of bright pixels in the disc: more may be food, or a marker's rim over it."""
_MIN_FOOD_AREA, _MIN_PIECE_AREA = 0.4, 0.15
"""Shares of food's area below which a bright shape is not taken for food, and not for a piece of anything."""
_GAP = 20.0
"""Width in mm of the gaps that are closed between the pieces of a shape split by a cable (12 mm wide, blurred)."""
_MARKER_AREA = (0.5, 3.0)
"""Least and greatest area of a marker, holes filled, as shares of its true area: smaller shapes are at most food,
larger ones are walls or sheets of paper."""
_MEASURE_INTERVAL, _NEWEST, _LEAST_BLUR = 5, 0.3, 0.5
"""Markers from one measurement of white to the next, the weight of the newest, and the least blur in pixels."""
_PART = 0.35
"""Share of a marker's area from which a shape that is no marker is reported."""
_WIDE, _ALL_BRIGHT = 0.85, 0.95
"""Least width of a shape that may hide food, as a share of the side of a square of food's area; and least share of it
that is bright: tags have black cells."""

_CROSSED, _DARK_STRIP = (0.7, 1.2), 0.8
"""Length of what may be food under a cable, in diameters of food; and the share of the floor's brightness below which
something beside it is a cable."""
_MIN_FILL = 0.7
"""Least share of the ellipse with the same moments that food fills; the end of a kinked cable fills less."""
_AREA = (0.8, 1.7)
"""Least and greatest area of a whole disc, as shares of food's true area: a half hidden disc has no known centre, and
overexposed white grows."""
_DEPTH, _RING, _AROUND = (0.75, 1.4), 1.35, 0.5
"""Of a disc that touches another shape, in radii: how far its middle is from the nearest border, and the ring around
it; and the least share of that ring that is not bright."""
_SOFTNESS, _SPREAD = 1.25, 0.25
"""Greatest blur of food's border in pixels: this times that of markers' borders, and a spread."""
_NOT_SATURATED, _SATURATED = 240.0, 0.1
"""Grey level of white below which it is not saturated; and the share of a shape that is saturated in a reflection."""
_SQUARE = np.ones((3, 3), np.uint8)
_NEAR_FLOOR, _BRIGHT_AREA = np.ones((7, 7), np.uint8), 0.95
"""Squares of 8 x 8 pixels, over which light varies little, whose darkest is the floor beside a bright area; and the
area's least brightness as a multiple of this floor's, as a share of `TrackerSettings.contrast`."""
_ROUND = 0.98
"""Ratio of the axes from which a shape is taken for a whole disc: at most 1 % of it is then hidden."""
_STEP, _REACH = 0.25, 2.0
"""Region pixels from one sample of a ray to the next, and between the radius and either end of a ray."""
_HIDDEN, _JOINED, _GROWTH = 0.12, 0.4, 0.9
"""Region pixels by which the shape ends before the disc's rim where something hides it; the weight of those by which it
ends beyond the rim, where something joins it; and by how many blur and exposure change the radius at most."""
_RAYS, _LEAST_RAYS, _REPEATS = 36, 15, 8
"""Rays, and rays to the visible rim from which the centre is known."""
_ANGLES = 2 * math.pi * np.arange(_RAYS) / _RAYS
_DIRECTIONS = np.stack((np.cos(_ANGLES), np.sin(_ANGLES)), axis=1)
_TERMS = np.column_stack((_DIRECTIONS, np.ones(_RAYS)))
"""How the edge along each ray changes with a shift of the centre, to first order, and with the radius, which blur and
brightness change a little."""

TROUBLES = {
    "glare": "a reflection lies over the marker at {place}: move the lamp, or print on matt paper",
    "cover": "the white of the marker at {place} is not where it should be: something covers a part of it, the hard "
    "edge of a shadow lies over it, or it is a reflection",
    "pale holes": "the holes of the marker at {place} are too pale: print them black, or move the lamp if it is a "
    "reflection",
    "cables": "cables hide the holes of the marker at {place}: lead them elsewhere",
    "holes": "the holes of the marker at {place} are those of no marker in use, or a reflection hides some",
    "reflection": "the bright spot at {place} has no sharp border: it is no food, but a reflection, or out of focus",
    "bright area": "the area around {place} is much brighter than the floor beside it, and so wide that food on it or "
    "touching it may not be seen: cover it, or light the floor evenly",
    "bright shape": "the bright shape at {place} is neither food nor a marker, and food in it is not seen: move the "
    "lamp if it is a reflection, or take it away",
    "crossed food": "the bright spot at {place} may be food, not seen because a cable hides a part of it: lead the "
    "cable elsewhere",
    "bright food": "the bright spot at {place} is brighter than white paper: a reflection",
}
"""What makes a shape uncertain, with its remedy."""


def check_view(calibration: Calibration, settings: TrackerSettings) -> None:
    """Complain about a camera that is not above markers and food, or that shows less floor than a robot needs."""
    width, height = calibration.size
    for z in (settings.marker_height, settings.food_height):
        calibration.to_region(width / 2, height / 2, z)  # raises an error for heights above the camera
    if calibration.mm_per_pixel() < (least := _LEAST_VIEW / max(width, height)):
        raise ValueError(
            f"a pixel in the middle of the picture shows {calibration.mm_per_pixel():.2g} mm of the floor; "
            f"allowed: at least {least:.2g} mm: give places in mm"
        )


class Detector:
    """Detects tags, markers and food in frames of one calibration.

    Raises:
        ValueError: As for `Tracker`.

    Attributes:
        warnings: What the last frame does not show for certain, by the name of the cause.
    """

    def __init__(self, settings: TrackerSettings, calibration: Calibration) -> None:
        check_view(calibration, settings)
        width, height = calibration.size
        scale = MM_PER_PIXEL / calibration.mm_per_pixel()
        self._tags = TagDetector(settings, calibration)
        if settings.markers != "tags" and scale < _LEAST_SCALE:
            raise ValueError(
                f"a pixel in the middle of the picture shows {calibration.mm_per_pixel():.1f} mm of the floor; "
                f"allowed: up to {MM_PER_PIXEL / _LEAST_SCALE:.1f} mm: use a higher resolution, or a lower camera"
            )
        if not _NATIVE[0] <= scale <= _NATIVE[1]:
            calibration = calibration.for_size(max(16, round(width / scale)), max(16, round(height / scale)))
        self.warnings: dict[str, str] = {}
        self._settings, self._calibration = settings, calibration
        self._markers = MarkerDetector(settings, calibration)
        self._radius = settings.food_radius / MM_PER_PIXEL
        scale = 1 / calibration.mm_per_pixel()
        self._gap_kernel = np.ones((max(1, math.ceil(_GAP * scale)) + 1,) * 2, np.uint8)
        # In pixels of the picture.
        self._food_area = math.pi * settings.food_radius**2 * scale**2
        self._diameter = 2 * settings.food_radius * scale
        self._marker_area = MARKER_LENGTH * MARKER_WIDTH * scale**2
        self._diagonal = math.hypot(MARKER_LENGTH, MARKER_WIDTH) * scale
        self._least, self._most = (share * self._marker_area for share in _MARKER_AREA)
        self._white, self._blur, self._until_measured = 0.0, 0.0, 0
        # Region coordinates.
        self._floor_tags = [calibration.to_region(*middle) for middle in calibration.tags.values()]
        self._floor_reach = _FLOOR_TAG * calibration.tag_side / MM_PER_PIXEL

    def reduced(self, grey: Frame) -> Frame:
        """A frame of about 5 mm a pixel."""
        size = self._calibration.size
        if size == grey.shape[::-1]:
            return grey
        way = cv2.INTER_AREA if size[0] < grey.shape[1] else cv2.INTER_CUBIC
        return cv2.resize(grey, size, interpolation=way)  # type: ignore[return-value] # uint8

    def detect(self, grey: Frame, tracked: Sequence[tuple[float, float]]) -> list[Detection]:
        """All tags and food in a frame of the calibration's size, and markers with holes unless robots carry tags.

        `tracked` are last places of robots: the white parts of a tag that is not seen look like food, too.
        """
        self._picture = segment(self.reduced(grey), self._settings.contrast)
        tags, warnings = self._tags.detect(grey)
        places = [(tag.x, tag.y) for tag in tags]
        self.warnings = {}
        if self._settings.markers == "tags":
            places += tracked
        found = self._shapes(places)
        if self._settings.tag_ids:
            found = [d for d in found if d.holes or (self._is_clear(d.x, d.y, places) and self._is_on_floor(d))]
        self.warnings |= warnings
        return tags + [d for d in found if d.holes or not self._is_floor_tag(d.x, d.y)]

    def shows_floor(self, plates: list[Plate], x: float, y: float) -> bool:
        """Whether the disc of food at a place (region coordinates) shows the floor."""
        radius, food_height = self._settings.food_radius, self._settings.food_height
        place = x * MM_PER_PIXEL, y * MM_PER_PIXEL
        if self._settings.markers == "tags":
            if any(math.dist(place, plate[:2]) <= self._tags.reach * MM_PER_PIXEL for plate in plates):
                return False
        elif under_plate(*place, radius + _CLEARANCE, plates):
            return False
        u, v = self._calibration.to_picture(x, y, food_height)
        reach = radius / MM_PER_PIXEL / self._calibration.scale(u, v, food_height)
        rows, columns = self._picture.frame.shape
        if not (reach <= u <= columns - reach and reach <= v <= rows - reach):
            return False
        left, right = math.floor(u - reach), math.ceil(u + reach)
        top, bottom = math.floor(v - reach), math.ceil(v + reach)
        across, down = np.arange(left, right) + 0.5 - u, np.arange(top, bottom)[:, None] + 0.5 - v
        disc = across**2 + down**2 <= reach * reach
        grey = self._picture.frame[top:bottom, left:right][disc].astype(np.float64)
        bright = self._picture.mask[top:bottom, left:right][disc] > 0
        floor = self._picture.floor_at(math.floor(u), math.floor(v))
        like_floor = np.abs(grey - floor) <= _FLOOR_TOLERANCE * floor
        return bool(like_floor.mean() >= _MIN_FLOOR_SHARE and bright.mean() <= _MAX_BRIGHT_SHARE)

    def _shapes(self, tags: Sequence[tuple[float, float]]) -> list[Detection]:
        """Food, and markers with holes unless robots carry tags; small shapes at these are parts of them."""
        markers = self._settings.markers != "tags"
        self._report_bright_area()
        least = _MIN_PIECE_AREA * self._food_area
        # The contour's length bounds the area from above and is cheap: most shapes are specks.
        contours = [c for c in outer_contours(self._picture.mask) if len(c) ** 2 >= least]
        pieces = [c for c in contours if filled_area(c) >= least]
        if not markers:
            pieces = [c for c in pieces if filled_area(c) > self._most or self._is_clear(*self._middle(c), tags)]
        seen: list[DetectedMarker] = []
        found: list[Detection] = []
        if markers:
            found, pieces = self._markers_among(pieces, seen, joined=False)
        small = [piece for piece in pieces if filled_area(piece) <= self._most]
        if markers and sum(map(filled_area, small)) >= self._least:
            # A cable cuts a marker in pieces, or cuts notches into its border.
            found += self._markers_among(self._joined(small), seen, joined=True)[0]
        rest = [piece for piece in pieces if not any(_covers(marker, piece) for marker in seen)]
        foods, rest = self._foods_among(rest)
        found += foods
        rest = [piece for piece in rest if filled_area(piece) <= self._most]
        if len(rest) > 1:
            foods, rest = self._foods_among(self._joined(rest))
            found += foods
        for piece in rest:
            self._report_unknown(piece, seen)
        return found

    def _middle(self, piece: Contour) -> tuple[float, float]:
        """Of a piece of a marker, in region coordinates."""
        u, v = (piece.mean(axis=(0, 1)) + 0.5).tolist()
        return self._calibration.to_region(u, v, self._settings.marker_height)

    def _is_clear(self, x: float, y: float, tags: Sequence[tuple[float, float]]) -> bool:
        """Whether a place is no part of a tag."""
        return all(math.dist((x, y), tag) > self._tags.reach for tag in tags)

    def _is_on_floor(self, food: Detection) -> bool:
        """Whether food has floor around it, and not the black of a tag."""
        reach = _NEAR * self._settings.food_radius / MM_PER_PIXEL
        rows, columns = self._picture.frame.shape
        dark = 0
        for x, y in _CIRCLE:
            u, v = self._calibration.to_picture(food.x + reach * x, food.y + reach * y, self._settings.food_height)
            column, row = min(max(int(u), 0), columns - 1), min(max(int(v), 0), rows - 1)
            dark += self._picture.frame[row, column] < _DARK * self._picture.floor_at(column, row)
        return dark < _MOST_DARK * len(_CIRCLE)

    def _markers_among(
        self, pieces: list[Contour], markers: list[DetectedMarker], joined: bool
    ) -> tuple[list[Detection], list[Contour]]:
        """Detections of the markers among some pieces, and the other pieces.

        All markers are added to `markers`, even those whose number is uncertain. Food whose contour has merged with a
        marker's is detected, too, unless the pieces result from joining: pieces of food are joined on their own.
        """
        found: list[Detection] = []
        rest = []
        for piece in pieces:
            area, marker = filled_area(piece), None
            if self._least <= area <= self._most:
                patch = cut_patch(self._picture, piece)
                marker = self._markers.detect(self._picture.frame, patch, joined)
            if marker is None:
                rest.append(piece)
                continue
            markers.append(marker)
            # While white is unknown, the border of a saturated shape tells: that of a reflection is soft.
            is_glare = self._is_saturated(patch, area) and (
                self._knows_white(patch) or self._softness(patch) > BLUR_LIMIT
            )
            trouble = marker.reading.trouble or ("glare" if is_glare else "")
            if not trouble:
                self._measure_white(patch)
                found.append(self._detection(piece, patch.edge, marker.moments, marker.reading))
            else:
                self._report(trouble, *marker.moments[:2], self._settings.marker_height)
            if not joined and area > self._marker_area + 0.5 * self._food_area:
                # Food whose contour has merged with the marker's.
                mask = np.zeros_like(patch.filled)
                corners = np.rint((marker.corners - 0.5 - (patch.column, patch.row)) * 16).astype(np.int32)
                cv2.fillConvexPoly(mask, corners, 255, cv2.LINE_8, 4)
                mask = cv2.dilate(mask, _SQUARE)  # type: ignore[assignment] # uint8
                beside = patch.filled & patch.white & ~mask
                others = outer_contours(beside, (patch.column, patch.row))
                found += self._foods_among(others)[0]
        return found, rest

    def _foods_among(self, pieces: list[Contour]) -> tuple[list[Detection], list[Contour]]:
        """Detections of the food among some pieces, and the other pieces; reflections are reported."""
        found, rest = list[Detection](), list[Contour]()
        for piece in pieces:
            area, discs = filled_area(piece) / self._food_area, list[tuple[Contour, ShapeMoments]]()
            if area >= _MIN_FOOD_AREA:
                patch = cut_patch(self._picture, piece)
                whole = self._disc(patch)
                if whole is not None:
                    discs = [(piece, whole)]
                elif area >= _AREA[0]:  # discs may touch each other, or a bright wall
                    discs = list(self._touching_discs(patch, piece))
            for contour, food in discs:
                trouble = self._trouble(cut_patch(self._picture, contour), food)
                if trouble:
                    self._report(trouble, food.u, food.v, self._settings.food_height)
                else:
                    found.append(self._detection(contour, patch.edge, food))
            if not discs:
                rest.append(piece)
        return found, rest

    def _joined(self, pieces: list[Contour]) -> list[Contour]:
        """The shapes that result when the gaps between pieces, and their notches, are closed."""
        mask = np.zeros_like(self._picture.mask)
        cv2.drawContours(mask, pieces, -1, 255, cv2.FILLED)
        return outer_contours(cv2.morphologyEx(mask, cv2.MORPH_CLOSE, self._gap_kernel))  # type: ignore[arg-type] # uint8

    def _measure_white(self, patch: ImagePatch) -> None:
        """Measure, now and then, what the white of a marker looks like: food looks the same."""
        self._until_measured -= 1
        if self._until_measured < 0:
            self._until_measured = _MEASURE_INTERVAL
            white, blur = white_and_blur(patch.grey, patch.filled > 0, max(patch.floor, 1))
            if white * patch.floor < _NOT_SATURATED:  # otherwise it is brighter than it seems
                self._white += (_NEWEST if self._white else 1.0) * (white - self._white)
            self._blur += (_NEWEST if self._blur else 1.0) * (max(blur, _LEAST_BLUR) - self._blur)

    def _report_unknown(self, piece: Contour, markers: Sequence[DetectedMarker]) -> None:
        """Report a shape that is neither food nor a marker, if it may be a part of a marker, or hide food."""
        (u, v), size, _ = cv2.minAreaRect(piece)
        place = u + 0.5, v + 0.5
        is_part = filled_area(piece) >= _PART * self._marker_area and math.hypot(*size) <= 1.2 * self._diagonal
        as_long = _CROSSED[0] < max(size) / self._diameter < _CROSSED[1]
        as_wide = min(size) >= _WIDE * math.sqrt(self._food_area)
        if is_part and self._settings.markers != "tags":
            self._report("cover", *place, self._settings.marker_height)
        elif as_long or as_wide:
            patch = cut_patch(self._picture, piece)
            is_apart = all(_distance(marker, place) >= self._diameter for marker in markers)  # a marker hides food, too
            if as_long and is_apart and patch.grey.min() < _DARK_STRIP * patch.floor:
                self._report("crossed food", *place, self._settings.food_height)
            elif as_wide and patch.white[patch.filled > 0].mean() >= _ALL_BRIGHT * 255:  # no tag
                self._report("bright shape", *place, self._settings.food_height)

    def _report_bright_area(self) -> None:
        """Report a bright wall or sheet that is wide enough to be taken for floor."""
        floor = self._picture.floor
        contrast = floor / np.maximum(cv2.erode(floor, _NEAR_FLOOR), 1)
        row, column = np.unravel_index(contrast.argmax(), floor.shape)
        if contrast[row, column] > _BRIGHT_AREA * self._settings.contrast:
            self._report("bright area", 8.0 * column + 4, 8.0 * row + 4)

    def _report(self, trouble: str, u: float, v: float, height: float = 0.0) -> None:
        place = self._calibration.to_region(u, v, height)
        if not self._is_floor_tag(*place):
            self.warnings[trouble] = TROUBLES[trouble].format(place=place_text(*place))

    def _is_floor_tag(self, x: float, y: float) -> bool:
        """Whether a floor tag lies at a place: its cells look like food, and all of it like a damaged marker."""
        return any(math.dist((x, y), tag) <= self._floor_reach for tag in self._floor_tags)

    def _detection(
        self, contour: Contour, edge: bool, moments: ShapeMoments, marker: Reading | None = None
    ) -> Detection:
        """The detection of food, or of a marker."""
        height = self._settings.food_height if marker is None else self._settings.marker_height
        scale = self._calibration.scale(moments.u, moments.v, height)
        area = filled_area(contour) * scale**2
        holes = orientation = 0
        if marker is not None:
            holes, orientation = marker.number, round(math.degrees(moments.axis)) % 360
            area -= marker.area
        # The contour runs through the middles of the border pixels; the outline around them is longer by pi.
        perimeter = (cv2.arcLength(contour, True) + math.pi) * scale
        column, row = min(contour[:, 0].tolist(), key=lambda pixel: pixel[::-1])
        first = self._calibration.to_region(column + 0.5, row + 0.5, height)
        x, y = self._calibration.to_region(moments.u, moments.v, height)
        return Detection(x, y, holes, orientation, edge, *first, area, perimeter)

    # ------------------------------------------------------------------ discs

    def _disc(self, patch: ImagePatch) -> ShapeMoments | None:
        """Moments of the one disc in a patch; None for anything else, or for a part of a disc."""
        moments = shape_moments(patch, patch.filled, self._calibration, self._settings.food_height)
        if moments is None or not _AREA[0] <= moments.area / (math.pi * self._radius**2) <= _AREA[1]:
            return None
        if moments.area < _MIN_FILL * 4 * math.pi * moments.major * moments.minor:
            return None
        # The standard deviation of a disc along any axis is half its radius.
        ratios = (deviation * 2 / self._radius for deviation in (moments.major, moments.minor))
        if any(abs(ratio - 1) > self._settings.tolerance for ratio in ratios):
            return None
        if moments.minor < _ROUND * moments.major:
            # What hides a part, such as the black frame of a marker, shifts the centre of the rest.
            rim = self._rim(moments.u, moments.v, moments.level)
            if rim is not None:
                return moments._replace(u=rim[0], v=rim[1])
        return moments

    def _touching_discs(self, patch: ImagePatch, piece: Contour) -> Iterator[tuple[Contour, ShapeMoments]]:
        """The discs in a shape: places as deep in it as the middle of a disc, with mostly floor around."""
        _, labels = cv2.connectedComponents(patch.filled & patch.white)
        column, row = (piece[0, 0] - (patch.column, patch.row)).tolist()
        mask = patch.filled
        if label := labels[row, column]:
            mask = np.where(labels == label, np.uint8(255), np.uint8(0))
        depth = cv2.distanceTransform(mask, cv2.DIST_L2, 5)
        radius = self._radius * MM_PER_PIXEL / self._calibration.mm_per_pixel()
        at_depth = (depth > _DEPTH[0] * radius) & (depth < _DEPTH[1] * radius)
        places = np.argwhere(at_depth & (depth >= cv2.dilate(depth, _SQUARE)))
        if not len(places):
            return
        ring = np.rint(places[:, None] + _RING * radius * _DIRECTIONS).astype(int)
        rows, columns = (ring[..., i].clip(0, mask.shape[i] - 1) for i in (0, 1))
        around = (mask[rows, columns] == 0).mean(axis=1)
        taken: list[tuple[float, float]] = []
        for i in np.argsort(-around).tolist():
            if around[i] < _AROUND:
                break
            row, column = places[i].tolist()
            u, v = column + patch.column + 0.5, row + patch.row + 0.5
            if any(math.dist((u, v), other) < radius for other in taken):
                continue
            level = float(patch.grey[max(0, row - 1) : row + 2, max(0, column - 1) : column + 2].mean())
            rim = self._rim(u, v, level)
            if rim is None or abs(rim[2]) > _GROWTH or rim[3] < _AROUND * _RAYS:
                continue
            u, v, growth, _ = rim
            taken.append((u, v))
            deviation = (self._radius + growth) / 2
            contour = np.rint((u, v) + radius * _DIRECTIONS - 0.5).astype(np.int32)[:, None]
            yield contour, ShapeMoments(u, v, deviation, deviation, 0.0, 4 * math.pi * deviation**2, level)

    def _trouble(self, patch: ImagePatch, food: ShapeMoments) -> str:
        """Why a disc may be a reflection, with a soft border or brighter than white: a key of `TROUBLES`."""
        scale = self._calibration.scale(food.u, food.v, self._settings.food_height)
        if self._knows_white(patch) and self._is_saturated(patch, math.pi * self._radius**2 / scale**2):
            return "bright food"
        return "reflection" if self._softness(patch) > _SOFTNESS * (self._blur or BLUR_LIMIT) + _SPREAD else ""

    def _knows_white(self, patch: ImagePatch) -> bool:
        """Whether white was measured, and is not saturated where a shape is: saturated pixels are then brighter."""
        return 0 < self._white * patch.floor < _NOT_SATURATED

    def _is_saturated(self, patch: ImagePatch, area: float) -> bool:
        """Whether more than a few pixels of a shape are saturated."""
        return bool(np.count_nonzero((patch.grey == 255) & (patch.filled > 0)) > _SATURATED * area)

    def _softness(self, patch: ImagePatch) -> float:
        """Blur in pixels of a shape's border with the floor."""
        # Whatever is darker than the floor, such as a cable, has borders of its own.
        bright = np.maximum(patch.grey, patch.floor)
        return white_and_blur(bright, patch.filled > 0, max(patch.floor, 1))[1]

    def _rim(self, u: float, v: float, level: float) -> tuple[float, float, float, int] | None:
        """The centre of the disc around a place in the picture, growth of its radius, and number of rays to its rim.

        Rays find the edge of the shape in all directions; the rim is a circle through the edges, without those that do
        not fit. None if too little of it is visible. `level` is the grey level of the disc.
        """
        jacobian = self._calibration.jacobian(u, v, self._settings.food_height)
        to_picture = np.linalg.inv(jacobian)
        along = np.arange(max(0.0, self._radius - _REACH), self._radius + _REACH, _STEP)
        places = np.array((u, v)) - 0.5 + (_DIRECTIONS @ to_picture.T)[:, None] * along[:, None]
        columns, rows = np.moveaxis(places.astype(np.float32), 2, 0)
        frame, floor = self._picture.frame, self._picture.floor_at(int(u), int(v))
        grey = cv2.remap(frame, columns, rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        edges = white_ends(grey.astype(np.float64), along, (level + floor) / 2)[:_RAYS] - self._radius
        visible = np.isfinite(edges)
        for _ in range(_REPEATS):
            if visible.sum() < _LEAST_RAYS:
                return None
            terms = _TERMS[visible]
            shift = np.linalg.solve(terms.T @ terms, terms.T @ edges[visible])
            residuals = edges - _TERMS @ shift
            residuals = np.maximum(-residuals, _JOINED * residuals)
            # A quarter of the rays at a time, because the other edges have shifted the circle, too.
            worst = np.sort(residuals[visible])[3 * len(terms) // 4]
            hidden = visible & (residuals > _HIDDEN) & (residuals >= worst)
            if not hidden.any():
                break
            visible &= ~hidden
        du, dv = (to_picture @ shift[:2]).tolist()
        return u + du, v + dv, float(shift[2]), int(visible.sum())


def _covers(marker: DetectedMarker, piece: Contour) -> bool:
    """Whether the middle of a piece lies within a marker."""
    return _distance(marker, (piece.mean(axis=(0, 1)) + 0.5).tolist()) <= 0


def _distance(marker: DetectedMarker, place: Sequence[float]) -> float:
    """Pixels from a marker to a place in the picture, negative within it."""
    return -cv2.pointPolygonTest(marker.corners.astype(np.float32), place, True)
