"""The calibration that fits measured points, with the lens if there are enough of them, and its error at other points.

A calibration always fits the points that it was computed from, the better the fewer they are, and four points exactly.
The error elsewhere is therefore measured with each point held out: the calibration is computed from all other points
and applied to this one.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.vision.calibration import (
    DEFAULT_SIZE,
    Calibration,
    Lens,
    Point,
    Size,
    on_a_line,
    shows_every_point_once,
    straightened,
)
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.tags import Corners, middle

Points = NDArray[np.float64]
LENS_POINTS = (8, 14)
"""Points from which k1 of the lens is fitted, and from which k2 is fitted, too."""
_GAIN = 0.9
"""Ratio of held-out errors below which another coefficient of the lens is taken."""
_LARGEST, _STEP = 0.5, 1e-3
"""Greatest coefficient that is tried, and the step of its derivative."""


class CalibrationFit(NamedTuple):
    """A calibration and its errors.

    Attributes:
        calibration: From all points.
        residuals: Distance in mm of each point from the calibration's estimate of it.
        held_out: The same by a calibration from all other points, with the same kind of lens; nan if these determine no
            calibration, and empty for four points.
        held_out_without_lens: The same without a lens.
        coverage: Share of the picture that lies within the points' convex hull.
    """

    calibration: Calibration
    residuals: tuple[float, ...]
    held_out: tuple[float, ...]
    held_out_without_lens: tuple[float, ...]
    coverage: float


def fit_calibration(
    picture: Sequence[Point],
    floor: Sequence[Point],
    camera: tuple[float, float, float] | None = None,
    size: Size = DEFAULT_SIZE,
) -> CalibrationFit:
    """Fit a calibration: exactly to four points, by least squares to more.

    The lens is fitted to at least `LENS_POINTS` points, and used if it is possible and lowers the held-out error.

    Args:
        picture: Four or more points (u, v) in pixels.
        floor: The same points in mm.
        camera: Position x, y and height of the camera in mm; None corrects no parallax.
        size: Width and height of the picture.

    Raises:
        ValueError: The points fit no camera.
        ImportError: OpenCV is not installed.
    """
    import cv2

    points, places = np.array(picture, np.float64), np.array(floor, np.float64)
    hull = cv2.convexHull(points.astype(np.float32))
    coverage = cv2.contourArea(hull) / (size[0] * size[1])
    if len(points) == 4:
        calibration = Calibration(tuple(picture), tuple(floor), camera, size=size)
        return CalibrationFit(calibration, _distances(calibration, picture, floor), (), (), coverage)
    plain = best = _held_out(points, places, 0, size)
    k, matrix = _fitted(points, places, 0, size)
    for count, least in enumerate(LENS_POINTS, start=1):
        errors = _held_out(points, places, count, size) if len(points) >= least else ()
        if root_mean_square(errors) < _GAIN * root_mean_square(best):
            k_of_lens, matrix_of_lens = _fitted(points, places, count, size)
            # Errors of clicks can make a distortion fit best that no lens has.
            if shows_every_point_once(*k_of_lens.tolist()):
                best, k, matrix = errors, k_of_lens, matrix_of_lens
    corners = Calibration.identity(size=size).picture
    on_floor = _mapped(np.array(corners), k, matrix, size).tolist()
    lens = Lens(float(k[0]), float(k[1]), size) if k.any() else None
    calibration = Calibration(corners, tuple(map(tuple, on_floor)), camera, lens, size)
    return CalibrationFit(calibration, _distances(calibration, picture, floor), best, plain, coverage)


def fit_to_tags(
    tags: Mapping[int, Corners],
    places: Mapping[int, Point],
    side: float,
    camera: tuple[float, float, float] | None = None,
    size: Size = DEFAULT_SIZE,
) -> CalibrationFit:
    """Fit a calibration to tags that lie on the floor, turned as you like; it remembers the tags' pixels.

    Residuals are those of the tags' middles, and held-out errors those of a fit to the middles alone.

    Args:
        tags: Corners in the picture, by id.
        places: Middle on the floor in mm, by id; tags without a place are ignored.
        side: Of a tag in mm.
        camera: As for `fit_calibration`.
        size: Width and height of the picture.

    Raises:
        ValueError: Fewer than four of the tags are seen, or they fit no camera.
    """
    seen = sorted(set(tags) & set(places))
    if len(seen) < 4:
        missing = ", ".join(map(str, sorted(set(places) - set(tags))))
        raise ValueError(
            f"{len(seen)} of {len(places)} floor tags are seen, without {missing}; allowed: at least four"
        )
    middles = [middle(tags[tag]) for tag in seen]
    floor = [places[tag] for tag in seen]
    by_middles = fit_calibration(middles, floor, camera, size)
    first = by_middles.calibration
    points, corners = list[Point](), list[Point]()
    for tag in seen:
        # With the turn of a tag known, its corners are points, too.
        pixels = [(u, v) for u, v in tags[tag].tolist()]
        (ax, ay), (bx, by), (cx, cy), (dx, dy) = (first.to_region(u, v) for u, v in pixels)
        turn = math.atan2(by - ay + cy - dy, bx - ax + cx - dx)
        cos, sin = math.cos(turn) * side / 2, math.sin(turn) * side / 2
        x, y = places[tag]
        points += pixels
        corners += [
            (x + right * cos - ahead * sin, y + right * sin + ahead * cos)
            for right, ahead in ((-1, 1), (1, 1), (1, -1), (-1, -1))
        ]
    fit = fit_calibration(points, corners, camera, size)
    calibration = replace(fit.calibration, tags=dict(zip(seen, middles, strict=True)))
    return fit._replace(
        calibration=calibration,
        residuals=_distances(calibration, middles, floor),
        held_out=by_middles.held_out,
        held_out_without_lens=by_middles.held_out_without_lens,
    )


def root_mean_square(errors: Sequence[float]) -> float:
    """Root of the mean square of the errors that are known; nan without any."""
    known = [error for error in errors if not math.isnan(error)]
    return math.sqrt(sum(error * error for error in known) / len(known)) if known else math.nan


def _distances(
    calibration: Calibration, picture: Sequence[Point], floor: Sequence[Point]
) -> tuple[float, ...]:
    """Distance in mm of each place from where the calibration maps its point of the picture."""
    return tuple(
        math.dist([MM_PER_PIXEL * c for c in calibration.to_region(u, v)], place)
        for (u, v), place in zip(picture, floor, strict=True)
    )


def _held_out(points: Points, places: Points, coefficients: int, size: Size) -> tuple[float, ...]:
    """Distance in mm of each place from the estimate by a fit to all others; nan if they determine none."""
    errors = []
    for i in range(len(points)):
        others = np.delete(points, i, axis=0)
        error = math.nan
        if _determine_homography(others):
            k, matrix = _fitted(others, np.delete(places, i, axis=0), coefficients, size)
            error = float(np.hypot(*(_mapped(points[i : i + 1], k, matrix, size) - places[i])[0]))
        errors.append(error)
    return tuple(errors)


def _determine_homography(points: Points) -> bool:
    """Whether points determine a homography: no three of some four lie on a line."""
    return any(
        not any(on_a_line(*three) for three in combinations(four, 3))
        for four in combinations(points.tolist(), 4)
    )


def _fitted(points: Points, places: Points, coefficients: int, size: Size) -> tuple[Points, Points]:
    """The lens's k1 and k2, and the homography to the floor after it is corrected.

    The homography is fitted again for each lens that is tried, so that only the lens is searched.
    """
    from scipy.optimize import least_squares

    def with_lens(k: Points) -> Points:
        return np.concatenate((k, np.zeros(2 - len(k))))

    def misfit(k: Points) -> Points:
        matrix = _homography(points, places, with_lens(k), size)
        return (_mapped(points, with_lens(k), matrix, size) - places).ravel()

    k = np.zeros(coefficients)
    if coefficients:
        k = least_squares(misfit, k, bounds=(-_LARGEST, _LARGEST), diff_step=_STEP, x_scale=_STEP).x
    return with_lens(k), _homography(points, places, with_lens(k), size)


def _homography(points: Points, places: Points, k: Points, size: Size) -> Points:
    import cv2

    matrix, _ = cv2.findHomography(_straightened(points, k, size), places)
    if matrix is None:
        raise ValueError(
            f"calibration points {points.tolist()} fit no camera; allowed: points all over the picture"
        )
    return matrix  # type: ignore[return-value] # float64


def _mapped(points: Points, k: Points, matrix: Points, size: Size) -> Points:
    import cv2

    return cv2.perspectiveTransform(_straightened(points, k, size)[:, None], matrix)[:, 0]  # type: ignore[return-value]


def _straightened(points: Points, k: Points, size: Size) -> Points:
    k1, k2 = k.tolist()
    return np.array([straightened(u, v, k1, k2, size) for u, v in points.tolist()]) if k.any() else points
