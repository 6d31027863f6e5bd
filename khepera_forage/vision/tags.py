"""ArUco tags on robots, food and the floor: found by OpenCV at the full resolution of the picture."""

import math
from collections import deque
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from functools import cache

import cv2
import numpy as np
from numpy.typing import NDArray

from khepera_forage.vision.association import Detection
from khepera_forage.vision.calibration import (
    DEFAULT_SIZE,
    Calibration,
    CalibrationFit,
    Point,
    Size,
    distances,
    fit_calibration,
)
from khepera_forage.vision.scene import MM_PER_PIXEL, place_text
from khepera_forage.vision.tracker_settings import MARKER_NUMBERS, TrackerSettings
from khepera_forage.vision.video import Frame

_DICTIONARY = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
"""Tags of 4 x 4 cells within a black border of one cell, ids 0 to 49."""
CELLS = 6
"""Cells across a tag, with its border."""
_SIDES = (60.0, 30.0, 15.0)
"""Sides in pixels of floor tags that are searched before the picture is calibrated."""
_LEAST_PIXELS = 13.0
"""Side in pixels of the smallest tag that is read."""
_CABLE, _BLUR = 6.0, 2.5
"""Width in mm of the cables that the second pass removes, and pixels that blur adds."""
_SIZE_TOLERANCE = 0.2
"""Relative difference from its size at which a tag is refused."""
_ALONE, _WINDOW = 7, 0.85
"""Cells that differ between ids at most; and the window of OpenCV's adaptive threshold, in sides of a tag."""
_MOVED = 3.0
"""mm of the floor by which tags appear elsewhere when the camera was moved."""
_ROUND = 4
"""Floor tags that are checked in each frame."""
_NEAR = 1.5
"""Sides of a tag around its middle in which it is searched."""

Corners = NDArray[np.float64]
"""4 x 2: u and v of the upper left, upper right, lower right and lower left corner of a tag."""


def white_cells(tag: int) -> list[list[int]]:
    """Row and column of each white cell of a tag."""
    cells: list[list[int]] = np.argwhere(cv2.aruco.generateImageMarker(_DICTIONARY, tag, CELLS)).tolist()
    return cells


@cache
def _dictionary(ids: tuple[int, ...]) -> cv2.aruco.Dictionary:
    """OpenCV's dictionary of some ids: the fewer there are, the more wrong cells can be corrected."""
    used, distance = _DICTIONARY.bytesList[list(ids)], _DICTIONARY.getDistanceToId
    bits = [_DICTIONARY.getBitsFromByteList(used[i : i + 1], 4) for i in range(len(ids))]
    least = min((distance(one, i) for one, j in zip(bits, ids, strict=True) for i in ids if i < j), default=_ALONE)
    return cv2.aruco.Dictionary(used, _DICTIONARY.markerSize, max(0, (min(least, _ALONE) - 1) // 2))


def find_tags(grey: Frame, ids: Sequence[int], side: float) -> list[tuple[int, Corners]]:
    """Id and corners of each tag in a picture, in pixels; the middle of the upper left pixel is (0.5, 0.5).

    Args:
        grey: The picture.
        ids: Those in use; any other is ignored.
        side: Of the tags in pixels.
    """
    parameters = cv2.aruco.DetectorParameters()
    parameters.cornerRefinementMethod = cv2.aruco.CORNER_REFINE_CONTOUR
    parameters.minMarkerPerimeterRate = 0.6 * 4 * side / max(grey.shape)
    parameters.minDistanceToBorder = 1
    parameters.errorCorrectionRate = 1.0
    # One window of almost a tag.
    window = max(3, round(_WINDOW * side) // 2 * 2 + 1)
    parameters.adaptiveThreshWinSizeMin = parameters.adaptiveThreshWinSizeMax = window
    corners, found, _ = cv2.aruco.ArucoDetector(_dictionary(tuple(ids)), parameters).detectMarkers(grey)
    if found is None:
        return []
    return [
        (ids[int(i)], c.reshape(4, 2).astype(np.float64) + 0.5) for i, c in zip(found.ravel(), corners, strict=True)
    ]


class TagDetector:
    """Detects the tags of robots and food, and watches those on the floor: they move if the camera was moved.

    Raises:
        ValueError: The tags are too small for the camera.
    """

    def __init__(self, settings: TrackerSettings, calibration: Calibration) -> None:
        self._settings, self._calibration = settings, calibration
        scale = 1 / calibration.mm_per_pixel()
        self._kinds: list[tuple[tuple[int, ...], float, NDArray[np.uint8]]] = []
        for ids, size in (
            (settings.numbers if settings.markers == "tags" else (), settings.tag_size),
            (settings.food_tags, settings.food_tag_size),
        ):
            if not ids:
                continue
            if size * scale < _LEAST_PIXELS:
                raise ValueError(
                    f"tags of {size:g} mm are {size * scale:.0f} pixels wide in the picture; allowed: at least "
                    f"{_LEAST_PIXELS:g} pixels, here {math.ceil(_LEAST_PIXELS / scale)} mm: use larger tags, or a "
                    "higher resolution"
                )
            # To close cables: wider than these, no wider than a cell, and odd: an even kernel shifts the picture.
            width = math.ceil(_CABLE * scale + _BLUR) // 2 * 2 + 1
            while width > max(size * scale / CELLS, 3):
                width -= 2
            kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (width, width))
            self._kinds.append((ids, size * scale, kernel))  # type: ignore[arg-type] # uint8
        self._never_seen = set(settings.tag_ids)
        # Region pixels around a tag's middle within which white belongs to the tag.
        self.reach = (0.75 * settings.tag_size + 12) / MM_PER_PIXEL
        self._floor_ids, self._floor_side = tuple(sorted(calibration.tags)), calibration.tag_side * scale
        self._turns = deque(self._floor_ids)

    def detect(self, grey: Frame) -> tuple[list[Detection], dict[str, str]]:
        """The tags in a frame, and warnings by the name of their cause."""
        found = dict[int, list[Corners]]()

        def search(picture: Frame, ids: Sequence[int], side: float, wanted: Collection[int]) -> None:
            for tag, corners in find_tags(picture, ids, side):
                if tag in wanted:
                    found.setdefault(tag, []).append(corners)

        for ids, side, kernel in self._kinds:
            search(grey, ids, side, ids)
            missing = set(ids) - found.keys()
            if missing:
                # Closing removes dark cables that cross a tag.
                closed = cv2.morphologyEx(grey, cv2.MORPH_CLOSE, kernel)
                search(closed, ids, side, missing)  # type: ignore[arg-type] # uint8
        self._never_seen -= found.keys()
        if self._never_seen:
            # Tags far smaller than the settings say, which the search above leaves out.
            search(grey, MARKER_NUMBERS["tags"], _LEAST_PIXELS, self._never_seen)
        warnings, detections = {}, []
        for tag, places in found.items():
            food = tag in self._settings.food_tags
            size = self._settings.food_tag_size if food else self._settings.tag_size
            seen = [self._detection(tag, corners) for corners in places]
            # What else looks like a tag, such as food beside one, seldom has its size.
            right = [one for one in seen if abs(one[1] / size - 1) <= _SIZE_TOLERANCE]
            if len(right) == 1:
                detections.append(right[0][0])
                continue
            texts = [place_text(detection.x, detection.y) for detection, _ in seen]
            if len(seen) > 1:
                where = " and ".join(texts)
                warnings["tag twice"] = f"tag {tag} is seen twice, at {where}: use each id once"
            else:
                warnings["tag size"] = (
                    f"tag {tag} at {texts[0]} measures {seen[0][1]:.0f} mm instead of {size:g} mm: print it at 100 %, "
                    "or change its size in the settings"
                )
        return detections, warnings | self._moved(grey)

    def _detection(self, tag: int, corners: Corners) -> tuple[Detection, float]:
        """The detection of a tag, and its side in mm."""
        food = tag in self._settings.food_tags
        height = self._settings.food_height if food else self._settings.marker_height
        floor = np.array([self._calibration.to_region(u, v, height) for u, v in corners.tolist()])
        x, y = floor.mean(axis=0).tolist()
        ahead = floor[:2].mean(axis=0) - floor[2:].mean(axis=0)
        orientation = 0 if food else round(math.degrees(math.atan2(ahead[1], ahead[0]))) % 360
        sides = np.hypot(*(np.roll(floor, 1, axis=0) - floor).T)
        edge = bool(corners.min() < 2 or (corners > np.array(self._calibration.size) - 2).any())
        first_x, first_y = floor[int(np.lexsort((floor[:, 0], -floor[:, 1]))[0])].tolist()
        perimeter, side = float(sides.sum()), float(sides.mean())
        holes, area = 0 if food else tag, side * side
        return Detection(x, y, holes, orientation, edge, first_x, first_y, area, perimeter), side * MM_PER_PIXEL

    def _moved(self, grey: Frame) -> dict[str, str]:
        """A warning if the tags on the floor have moved; each frame searches a few, and all if these have moved."""
        if not self._floor_ids:
            return {}
        chosen = [self._turns[i] for i in range(min(_ROUND, len(self._turns)))]
        self._turns.rotate(-len(chosen))
        shifts = [self._shift(tag, corners) for tag in chosen for corners in self._near(grey, tag)]
        all_stay = len(shifts) == len(chosen) and max(shifts) < _MOVED
        if all_stay or (len(shifts) > 1 and float(np.median(shifts)) < _MOVED):  # some may be hidden
            return {}
        found = dict(find_tags(grey, self._floor_ids, self._floor_side))
        shifts = list(map(self._shift, found, found.values()))
        if not shifts:
            return {"floor tags": "no floor tag is in sight: the camera was moved, or something hides them all"}
        if float(np.median(shifts)) < _MOVED:
            return {}
        return {
            "camera moved": f"the camera has moved since its calibration: floor tags appear {np.median(shifts):.0f} mm "
            "from their places; calibrate it again"
        }

    def _near(self, grey: Frame, tag: int) -> list[Corners]:
        """Corners of a floor tag that is seen near its place; none otherwise."""
        u, v = self._calibration.tags[tag]
        reach = math.ceil(_NEAR * self._calibration.tag_side / MM_PER_PIXEL / self._calibration.scale(u, v))
        left, top = max(0, math.floor(u) - reach), max(0, math.floor(v) - reach)
        part = np.ascontiguousarray(grey[top : math.floor(v) + reach, left : math.floor(u) + reach])
        found = find_tags(part, self._floor_ids, self._floor_side)
        return [corners + np.array((left, top)) for i, corners in found if i == tag][:1]

    def _shift(self, tag: int, corners: Corners) -> float:
        places = (self._calibration.to_region(*pixel) for pixel in (middle(corners), self._calibration.tags[tag]))
        return MM_PER_PIXEL * math.dist(*places)


def find_floor_tags(grey: Frame, ids: Sequence[int]) -> dict[int, Corners]:
    """Corners of the tags on the floor, of any size in the picture.

    Raises:
        ValueError: A tag is seen twice.
    """
    found: dict[int, Corners] = {}
    for side in _SIDES:
        seen = find_tags(grey, ids, side)
        for tag, corners in seen:
            if sum(other == tag for other, _ in seen) > 1:
                raise ValueError(f"tag {tag} is seen twice; allowed: each id once on the floor")
            found.setdefault(tag, corners)
    return found


def fit_to_tags(
    tags: Mapping[int, Corners],
    places: Mapping[int, Point],
    camera: tuple[float, float, float] | None = None,
    size: Size = DEFAULT_SIZE,
) -> CalibrationFit:
    """Fit a calibration to tags that lie on the floor, turned as you like; it remembers the tags' pixels.

    The tags are of one size, which the calibration measures: a print may be scaled, and the unit of the places may be
    that of another robot's plan. Residuals are those of the tags' middles, and held-out errors those of a fit to the
    middles alone.

    Args:
        tags: Corners in the picture, by id.
        places: Middle on the floor in mm, by id; tags without a place are ignored.
        camera: As for `fit_calibration`.
        size: Width and height of the picture.

    Raises:
        ValueError: Fewer than four of the tags are seen, or they fit no camera.
    """
    seen = sorted(set(tags) & set(places))
    if len(seen) < 4:
        missing = ", ".join(map(str, sorted(set(places) - set(tags))))
        raise ValueError(f"{len(seen)} of {len(places)} floor tags are seen, without {missing}; allowed: at least four")
    middles = [middle(tags[tag]) for tag in seen]
    floor = [places[tag] for tag in seen]
    by_middles = fit_calibration(middles, floor, camera, size)
    first = by_middles.calibration
    on_floor = {tag: [first.to_region(u, v) for u, v in tags[tag].tolist()] for tag in seen}
    diagonals = [math.dist(four[i], four[i + 2]) for four in on_floor.values() for i in (0, 1)]
    side = MM_PER_PIXEL * float(np.mean(diagonals)) / math.sqrt(2)
    points, corners = list[Point](), list[Point]()
    for tag in seen:
        # With the turn of a tag known, its corners are points, too.
        (ax, ay), (bx, by), (cx, cy), (dx, dy) = on_floor[tag]
        turn = math.atan2(by - ay + cy - dy, bx - ax + cx - dx)
        cos, sin = math.cos(turn) * side / 2, math.sin(turn) * side / 2
        x, y = places[tag]
        points += [(u, v) for u, v in tags[tag].tolist()]
        corners += [
            (x + right * cos - ahead * sin, y + right * sin + ahead * cos)
            for right, ahead in ((-1, 1), (1, 1), (1, -1), (-1, -1))
        ]
    fit = fit_calibration(points, corners, camera, size)
    calibration = replace(fit.calibration, tags=dict(zip(seen, middles, strict=True)), tag_side=side)
    residuals = distances(calibration, middles, floor)
    return by_middles._replace(calibration=calibration, residuals=residuals, coverage=fit.coverage)


def middle(corners: Corners) -> tuple[float, float]:
    """The middle of a tag: where its diagonals cross."""
    a, b, c, d = corners
    share, _ = np.linalg.solve(np.column_stack((c - a, b - d)), b - a)
    u, v = (a + share * (c - a)).tolist()
    return u, v
