"""Calibration of the overhead camera: lens, homography from picture to floor, and parallax of objects with a height.

Picture coordinates are (u, v): u to the right and v down from the upper left corner of the picture, so that the
middle of the pixel in row r and column c is (c + 0.5, r + 0.5). Region coordinates are those of `scene`: pixels
of 5 mm on the floor, x to the right and y up.
"""

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import combinations
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.files import replacing
from khepera_forage.toml_table import Reader, anything, content_of, list_of, naming, number, numbers, table, text_of
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.shapes import PICTURE_HEIGHT, PICTURE_WIDTH

Point = tuple[float, float]
Size = tuple[int, int]
"""Width and height of a picture in pixels."""
Matrix = tuple[float, ...]
"""The nine numbers of a homography, row by row."""

DEFAULT_SIZE: Size = (int(PICTURE_WIDTH), int(PICTURE_HEIGHT))
"""Of the thesis's camera (3.4)."""
FLOOR_SIDE = 100.0
"""Side in mm of a tag on the floor, as printed."""
_REPEATS, _CONVERGED = 20, 1e-12
_LEAST_SLOPE = 0.05
"""Least distance by which a point moves outwards in the picture, as a share of how far it would move without the
distortion."""
_STEP = 0.01
"""Pixels over which the Jacobian is measured."""
LENS_POINTS = (8, 14)
"""Points from which k1 of the lens is fitted, and from which k2 is fitted, too."""
_GAIN = 0.9
"""Ratio of held-out errors below which another coefficient of the lens is taken."""
_FLAT = 0.01
"""Three points are taken for collinear when the triangle's height is less than this share of its longest side."""


@dataclass(frozen=True, slots=True)
class Lens:
    """A lens that shows a point at the distance r from the middle of the picture at r (1 + k1 r^2 + k2 r^4).

    The unit of r is the distance d of a corner from the middle: a k1 of -0.03 moves the corners by 3 % towards the
    middle. This is OpenCV's model with a focal length of d pixels, which is 400 in a picture of 640 x 480; multiply
    OpenCV's k1 for a focal length of f pixels by (d/f)^2, and its k2 by (d/f)^4.

    Args:
        k1: Negative for a barrel, positive for a pincushion.
        k2: The same, further from the middle.
        size: Width and height of the picture.

    Raises:
        ValueError: A value that is not finite, or so far from 0 that several points would appear at the same place.
    """

    k1: float
    k2: float = 0.0
    size: Size = DEFAULT_SIZE

    @property
    def unit(self) -> float:
        """Pixels from the middle of the picture to a corner."""
        return math.hypot(*self.size) / 2

    def __post_init__(self) -> None:
        k, r = (self.k1, self.k2), 0.0
        if not all(map(math.isfinite, k)):
            raise ValueError(f"calibration lens is {k}; allowed: two finite numbers")
        while r * self._ratio(r * r) < 1.0:
            r += 0.01
            if self._slope(r) <= _LEAST_SLOPE or r > 3:
                raise ValueError(
                    f"calibration lens is {k}; allowed: a distortion that shows every point once "
                    "(k1 above -0.14 if k2 is 0)"
                )

    def straightened(self, u: float, v: float) -> Point:
        """Where a lens without distortion would show what this one shows at (u, v), in pixels."""
        x, y = self.size[0] / 2, self.size[1] / 2
        r = shown = math.hypot(u - x, v - y) / self.unit
        if shown == 0:
            return u, v
        for _ in range(_REPEATS):  # Newton's method
            step = (r * self._ratio(r * r) - shown) / max(self._slope(r), _LEAST_SLOPE)
            r -= step
            if abs(step) < _CONVERGED:
                break
        return x + (u - x) * r / shown, y + (v - y) * r / shown

    def distorted(self, u: float, v: float) -> Point:
        """Where this lens shows what a lens without distortion would show at (u, v): the inverse of `straightened`."""
        x, y = self.size[0] / 2, self.size[1] / 2
        ratio = self._ratio(((u - x) ** 2 + (v - y) ** 2) / self.unit**2)
        return x + (u - x) * ratio, y + (v - y) * ratio

    def _ratio(self, r_squared: float) -> float:
        """Apparent distance from the middle as a multiple of the distance r."""
        return 1 + r_squared * (self.k1 + r_squared * self.k2)

    def _slope(self, r: float) -> float:
        return 1 + r * r * (3 * self.k1 + 5 * self.k2 * r * r)


@dataclass(frozen=True, slots=True)
class Calibration:
    """Maps points of the picture to points on the floor, and back.

    Four points of the picture and the same four points on the floor determine a homography, after the lens is
    corrected; `fit_calibration` computes both from more points. The top of an object with a height appears further from
    the point below the camera than it is. With the camera's position and height known, this parallax is corrected:
    p_floor = c + (p - c) * (1 - height / camera height).

    Args:
        picture: Four points (u, v) in pixels.
        floor: The same four points on the floor (x, y) in mm.
        camera: Position x, y and height of the camera above the floor, in mm; None corrects no parallax.
        lens: Distortion of the lens; None corrects none.
        size: Width and height in pixels of the picture that was calibrated.
        tags: Where the picture shows the middle (u, v) of each floor tag, by its id: they reveal a camera that was
            moved.
        tag_side: Side of the floor tags in mm.

    Raises:
        ValueError: Not four points, a value that is not finite, three points on a line, floor
            and picture points that no camera can show (mirrored or crossed), or a camera not above the floor.
    """

    picture: tuple[Point, ...]
    floor: tuple[Point, ...]
    camera: tuple[float, float, float] | None = None
    lens: Lens | None = None
    size: Size = DEFAULT_SIZE
    tags: Mapping[int, Point] = field(default_factory=dict, hash=False)
    tag_side: float = FLOOR_SIDE
    _to_floor: Matrix = field(init=False, repr=False, compare=False)
    _to_picture: Matrix = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        picture = _checked_points("picture", self.picture, "(u, v)")
        floor = _checked_points("floor", self.floor, "(x, y)")
        camera = None if self.camera is None else _checked_numbers("camera", self.camera, 3, "(x, y, height)")
        if camera is not None and camera[2] <= 0:
            raise ValueError(f"calibration camera is {camera}; allowed: a height above 0 mm")
        # The picture's v grows downwards: seen from above, a left turn on the floor is a right turn.
        reversed_turns = [
            _cross(*(floor[i] for i in three)) * _cross(*(picture[i] for i in three)) < 0
            for three in combinations(range(4), 3)
        ]
        if not all(reversed_turns):
            how = "crossed" if any(reversed_turns) else "mirrored"
            raise ValueError(
                f"calibration points are {how}: picture {picture} cannot be a view from above of floor {floor}; "
                "allowed: both in the same order"
            )
        size, lens = tuple(self.size), self.lens
        if len(size) != 2 or not all(type(n) is int and n >= 16 for n in size):
            raise ValueError(f"calibration size is {size!r}; allowed: width and height in pixels, at least 16")
        if lens is not None:
            lens = replace(lens, size=size)
        straight = picture if lens is None else [lens.straightened(*point) for point in picture]
        to_floor = _homography(straight, [(x / MM_PER_PIXEL, y / MM_PER_PIXEL) for x, y in floor])
        for name, value in {
            "picture": picture,
            "floor": floor,
            "camera": camera,
            "size": size,
            "lens": lens,
            "_to_floor": tuple(to_floor.ravel().tolist()),
            "_to_picture": tuple(np.linalg.inv(to_floor).ravel().tolist()),
        }.items():
            object.__setattr__(self, name, value)

    @classmethod
    def identity(cls, camera: tuple[float, float, float] | None = None, size: Size = DEFAULT_SIZE) -> "Calibration":
        """An undistorted picture that is 3200 mm wide on the floor, its lower left corner at (0, 0) mm.

        A picture of 640 x 480 has 5 mm a pixel then.
        """
        width, height = size
        mm = DEFAULT_SIZE[0] * MM_PER_PIXEL / width
        corners = ((0.0, 0.0), (float(width), 0.0), (float(width), float(height)), (0.0, float(height)))
        return cls(corners, tuple((u * mm, (height - v) * mm) for u, v in corners), camera, size=size)

    def for_size(self, width: int, height: int) -> "Calibration":
        """The calibration of the same picture, enlarged or reduced."""
        across, down = width / self.size[0], height / self.size[1]
        picture = tuple((u * across, v * down) for u, v in self.picture)
        tags = {tag: (u * across, v * down) for tag, (u, v) in self.tags.items()}
        return replace(self, picture=picture, size=(width, height), tags=tags)

    def scale(self, u: float, v: float, height: float = 0.0) -> float:
        """Region pixels across a pixel of the picture."""
        (xu, xv), (yu, yv) = self.jacobian(u, v, height).tolist()
        return math.sqrt(abs(xu * yv - xv * yu))

    def mm_per_pixel(self) -> float:
        """Mm of the floor that a pixel in the middle of the picture shows."""
        return round(MM_PER_PIXEL * self.scale(self.size[0] / 2, self.size[1] / 2), 6)

    def to_region(self, u: float, v: float, height: float = 0.0) -> Point:
        """Position on the floor, in region coordinates, of an object seen at a point of the picture.

        Args:
            u: In pixels.
            v: In pixels.
            height: Height in mm above the floor of the point seen.

        Raises:
            ValueError: A height not below the camera.
        """
        if self.lens is not None:
            u, v = self.lens.straightened(u, v)
        x, y = _transformed(self._to_floor, u, v)
        if self.camera is None:
            return x, y
        centre_x, centre_y, shrink = self._parallax(height)
        return centre_x + (x - centre_x) * shrink, centre_y + (y - centre_y) * shrink

    def to_picture(self, x: float, y: float, height: float = 0.0) -> Point:
        """Point of the picture (pixels) where an object of that height is seen: the inverse of `to_region`."""
        if self.camera is not None:
            centre_x, centre_y, shrink = self._parallax(height)
            x, y = centre_x + (x - centre_x) / shrink, centre_y + (y - centre_y) / shrink
        u, v = _transformed(self._to_picture, x, y)
        return (u, v) if self.lens is None else self.lens.distorted(u, v)

    def jacobian(self, u: float, v: float, height: float = 0.0) -> NDArray[np.float64]:
        """2 x 2: how `to_region` (rows: x, y) changes with the point of the picture (columns: u, v)."""
        (x1, y1), (x2, y2) = (self.to_region(u + step, v, height) for step in (-_STEP, _STEP))
        (x3, y3), (x4, y4) = (self.to_region(u, v + step, height) for step in (-_STEP, _STEP))
        return np.array(((x2 - x1, x4 - x3), (y2 - y1, y4 - y3))) / (2 * _STEP)

    def save(self, path: str | Path) -> None:
        """Write the points, and what else is known, to a TOML file."""
        values: dict[str, object] = {"size": self.size, "picture": self.picture, "floor": self.floor}
        lines = ["# picture: four points in pixels from the upper left corner; floor: the same points in mm."]
        if self.camera is not None:
            values["camera"] = self.camera
        if self.lens is not None:
            values["lens"] = (self.lens.k1, self.lens.k2)
            lines.append(
                f"# lens: k1 and k2 of OpenCV's radial distortion for a focal length of {self.lens.unit:.0f} pixels."
            )
        if self.tags:
            values["tags"] = [(tag, *pixel) for tag, pixel in sorted(self.tags.items())]
            values["tag_side"] = self.tag_side
            lines.append("# tags: id of each floor tag, and the pixel of its middle; tag_side: their side in mm.")
        lines += [f"{key} = {json.dumps(value)}" for key, value in values.items()]
        with replacing(Path(path)) as file:
            file.write_text("\n".join(lines) + "\n", encoding="utf-8")

    @classmethod
    def load(cls, path: str | Path) -> "Calibration":
        """Read a file written by `save`.

        Raises:
            OSError: The file cannot be read.
            ValueError: The file is not TOML, a key is missing or unknown, or a value is not allowed.
        """
        with naming(path):
            given = table("calibration", content_of(text_of(Path(path))), _KEYS, ("picture", "floor"))
            if "lens" in given:
                given["lens"] = Lens(*given["lens"])
            return cls(**given)

    def _parallax(self, height: float) -> tuple[float, float, float]:
        """The point below the camera (region coordinates), and the ratio of true to apparent distance from it."""
        assert self.camera is not None
        x, y, camera_height = self.camera
        if not height < camera_height:
            raise ValueError(f"height is {height!r} mm; allowed: below the camera, which is {camera_height} mm high")
        return x / MM_PER_PIXEL, y / MM_PER_PIXEL, 1.0 - height / camera_height


def _homography(picture: Iterable[Sequence[float]], floor: Iterable[Point]) -> NDArray[np.float64]:
    """The 3 x 3 matrix that maps four points to four others."""
    rows, targets = [], []
    for (u, v), (x, y) in zip(picture, floor, strict=True):
        rows += [[u, v, 1, 0, 0, 0, -x * u, -x * v], [0, 0, 0, u, v, 1, -y * u, -y * v]]
        targets += [x, y]
    return np.append(np.linalg.solve(rows, targets), 1.0).reshape(3, 3)


def _transformed(matrix: Matrix, p: float, q: float) -> Point:
    """The point to which a homography maps (p, q)."""
    a, b, c, d, e, f, g, h, i = matrix
    w = g * p + h * q + i
    return (a * p + b * q + c) / w, (d * p + e * q + f) / w


def _checked_numbers(name: str, value: object, count: int, form: str) -> tuple[float, ...]:
    """A sequence of finite numbers as floats; anything else is refused."""
    if (
        not isinstance(value, Sequence | np.ndarray)
        or len(value) != count
        or not all(isinstance(n, int | float) and math.isfinite(n) for n in value)
    ):
        raise ValueError(f"calibration {name} is {value!r}; allowed: {count} finite numbers {form}")
    return tuple(float(n) for n in value)


def _checked_points(name: str, value: object, form: str) -> tuple[tuple[float, ...], ...]:
    """Four points of which no three lie on a line; anything else is refused."""
    if not isinstance(value, Sequence | np.ndarray) or len(value) != 4:
        raise ValueError(f"calibration {name} is {value!r}; allowed: four points {form}")
    points = tuple(_checked_numbers(f"{name} point", point, 2, form) for point in value)
    for one, other in combinations(points, 2):
        if one == other:
            raise ValueError(f"calibration {name} has the point {one} twice; allowed: four different points")
    for three in combinations(points, 3):
        if _on_a_line(*three):
            raise ValueError(
                f"calibration {name} points {', '.join(map(str, three))} lie on a line; "
                "allowed: no three points on one line"
            )
    return points


def _on_a_line(p: Sequence[float], q: Sequence[float], r: Sequence[float]) -> bool:
    """Whether three points lie on a line, or nearly."""
    longest = max(math.dist(p, q), math.dist(q, r), math.dist(r, p))
    return abs(_cross(p, q, r)) <= _FLAT * longest * longest


def _cross(p: Sequence[float], q: Sequence[float], r: Sequence[float]) -> float:
    """Twice the signed area of a triangle, positive when its corners turn from x towards y."""
    return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])


class CalibrationFit(NamedTuple):
    """A calibration and its errors.

    A calibration fits the points that it was computed from, the better the fewer they are. The error elsewhere is
    therefore measured with each point held out: by the calibration from all others, with the same kind of lens.

    Attributes:
        calibration: From all points.
        residuals: Distance in mm of each point from the calibration's estimate of it.
        held_out: The same of held-out points; nan if the others determine no calibration, and empty for four points.
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

    hull = cv2.convexHull(np.array(picture, np.float32))
    coverage = cv2.contourArea(hull) / (size[0] * size[1])
    if len(picture) == 4:
        calibration = Calibration(tuple(picture), tuple(floor), camera, size=size)
        return CalibrationFit(calibration, distances(calibration, picture, floor), (), (), coverage)
    calibration = _fitted(picture, floor, 0, size)
    plain = best = _held_out(picture, floor, 0, size)
    for coefficients, least in enumerate(LENS_POINTS, start=1):
        if len(picture) < least:
            break
        with suppress(ValueError):  # errors of clicks can make a distortion fit best that no lens has
            with_lens = _fitted(picture, floor, coefficients, size)
            errors = _held_out(picture, floor, coefficients, size)
            if root_mean_square(errors) < _GAIN * root_mean_square(best):
                calibration, best = with_lens, errors
    calibration = replace(calibration, camera=camera)
    return CalibrationFit(calibration, distances(calibration, picture, floor), best, plain, coverage)


def distances(calibration: Calibration, picture: Sequence[Point], floor: Sequence[Point]) -> tuple[float, ...]:
    """Distance in mm of each place on the floor from where the calibration maps its point of the picture."""
    return tuple(
        math.dist([MM_PER_PIXEL * c for c in calibration.to_region(u, v)], place)
        for (u, v), place in zip(picture, floor, strict=True)
    )


def root_mean_square(errors: Sequence[float]) -> float:
    """Root of the mean square of the errors that are known; nan without any."""
    known = [error for error in errors if not math.isnan(error)]
    return math.sqrt(sum(error * error for error in known) / len(known)) if known else math.nan


def _fitted(picture: Sequence[Point], floor: Sequence[Point], coefficients: int, size: Size) -> Calibration:
    """The calibration that fits points best, with some coefficients of the lens."""
    import cv2

    # Some four of them must have no three on a line.
    if all(any(_on_a_line(*three) for three in combinations(four, 3)) for four in combinations(picture, 4)):
        raise ValueError(f"calibration points {list(picture)} fit no camera; allowed: points all over the picture")
    corners = Calibration.identity(size=size).picture
    lens = _lens(picture, floor, coefficients, size) if coefficients else None
    points, ends = (
        np.array(group if lens is None else [lens.straightened(u, v) for u, v in group]) for group in (picture, corners)
    )
    # A homography fits better than OpenCV's pose: pixels need not be square, nor measured places exact.
    matrix, _ = cv2.findHomography(points, np.array(floor))
    places = cv2.perspectiveTransform(ends[None], matrix)[0].tolist()
    return Calibration(corners, tuple(map(tuple, places)), None, lens, size)


def _lens(picture: Sequence[Point], floor: Sequence[Point], coefficients: int, size: Size) -> Lens:
    """The lens that fits points best; an error if no lens is like that."""
    import cv2

    unit = math.hypot(*size) / 2
    matrix = np.array([[unit, 0, size[0] / 2], [0, unit, size[1] / 2], [0, 0, 1]])
    places = np.zeros((1, len(floor), 3), np.float32)
    places[0, :, :2] = (np.array(floor) - np.mean(floor, axis=0)) / 1000
    flags = cv2.CALIB_USE_INTRINSIC_GUESS | cv2.CALIB_FIX_PRINCIPAL_POINT | cv2.CALIB_ZERO_TANGENT_DIST
    flags |= cv2.CALIB_FIX_K3 | (cv2.CALIB_FIX_K2 if coefficients == 1 else 0)
    points = np.array([picture], np.float32)
    # Its arguments are typed as lists of pictures.
    _, matrix, k, *_ = cv2.calibrateCamera(places, points, size, matrix, np.zeros(5), flags=flags)  # type: ignore[call-overload]
    ratio = unit * unit / float(matrix[0, 0] * matrix[1, 1])
    k1, k2, *_ = k.ravel().tolist()
    return Lens(k1 * ratio, k2 * ratio * ratio, size)


def _held_out(picture: Sequence[Point], floor: Sequence[Point], coefficients: int, size: Size) -> tuple[float, ...]:
    """Distance in mm of each place from the estimate by a fit to all others; nan if they determine none."""
    errors: list[float] = []
    for i in range(len(picture)):
        points, places = ([*group[:i], *group[i + 1 :]] for group in (picture, floor))
        try:
            calibration = _fitted(points, places, coefficients, size)
            errors += distances(calibration, picture[i : i + 1], floor[i : i + 1])
        except ValueError:
            if coefficients:
                raise
            errors.append(math.nan)
    return tuple(errors)


_KEYS: dict[str, Reader] = {
    "picture": anything,  # `Calibration` checks these three, and the size
    "floor": anything,
    "camera": anything,
    "lens": numbers("[k1, k2]"),
    "size": list_of(anything, 0),
    "tag_side": number(1.0, 1000.0, "mm"),
    "tags": lambda key, value: {int(tag): (u, v) for tag, u, v in list_of(numbers("[id, u, v]"), 0)(key, value)},
}
"""Of a calibration file."""
