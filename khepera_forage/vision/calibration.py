"""Calibration of the overhead camera: a homography from picture to floor, and parallax of objects with a height.

Picture coordinates are (u, v): u to the right and v down from the upper left corner of the picture, so that the
middle of the pixel in row r and column c is (c + 0.5, r + 0.5). Region coordinates are those of `scene`: pixels
of 5 mm on the floor, x to the right and y up.
"""

import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from itertools import combinations
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.shapes import PICTURE_HEIGHT, PICTURE_WIDTH

Point = tuple[float, float]
_Matrix = tuple[float, ...]
"""The nine numbers of a homography, row by row."""

_FLAT = 0.01
"""Three points are taken for collinear when the triangle's height is less than this share of its longest side."""


class Jacobian(NamedTuple):
    """Jacobian of the calibration at a point: how region coordinates change with picture coordinates.

    Attributes:
        xu: Change of x with u.
        xv: Change of x with v.
        yu: Change of y with u.
        yv: Change of y with v.
    """

    xu: float
    xv: float
    yu: float
    yv: float

    @property
    def area(self) -> float:
        """Square region pixels per square pixel of the picture."""
        return abs(self.xu * self.yv - self.xv * self.yu)


@dataclass(frozen=True, slots=True)
class Calibration:
    """Maps points of the picture to points on the floor, and back.

    Four points of the picture and the same four points on the floor determine a homography. It does not model lens
    distortion: correct the frames of a wide lens first. The top of an object with a height appears further from the
    point below the camera than it is. With the camera's position and height known, this parallax is corrected:
    p_floor = c + (p - c) * (1 - height / camera height).

    Args:
        picture: Four points (u, v) in pixels.
        floor: The same four points on the floor (x, y) in mm.
        camera: Position x, y and height of the camera above the floor, in mm; None corrects no parallax.

    Raises:
        ValueError: Not four points, a value that is not finite, points that coincide, three points on a line, floor
            and picture points that no camera can show (mirrored or crossed), or a camera not above the floor.
    """

    picture: tuple[Point, ...]
    floor: tuple[Point, ...]
    camera: tuple[float, float, float] | None = None
    _to_floor: _Matrix = field(init=False, repr=False, compare=False)
    _to_picture: _Matrix = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        picture, floor = _points("picture", self.picture, "(u, v)"), _points("floor", self.floor, "(x, y)")
        camera = None if self.camera is None else _numbers("camera", self.camera, 3, "(x, y, height)")
        if camera is not None and camera[2] <= 0:
            raise ValueError(f"calibration camera is {camera}; allowed: a height above 0 mm")
        to_floor = _homography(picture, [(x / MM_PER_PIXEL, y / MM_PER_PIXEL) for x, y in floor])
        # The picture's v grows downwards: in a picture that is not mirrored, a left turn on the floor is a right turn.
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
        for name, value in (("picture", picture), ("floor", floor), ("camera", camera)):
            object.__setattr__(self, name, value)
        object.__setattr__(self, "_to_floor", tuple(to_floor.ravel().tolist()))
        object.__setattr__(self, "_to_picture", tuple(np.linalg.inv(to_floor).ravel().tolist()))

    @classmethod
    def identity(cls, camera: tuple[float, float, float] | None = None) -> "Calibration":
        """An undistorted 640 x 480 picture with 5 mm a pixel, its lower left corner at (0, 0) mm."""
        corners = ((0.0, 0.0), (PICTURE_WIDTH, 0.0), (PICTURE_WIDTH, PICTURE_HEIGHT), (0.0, PICTURE_HEIGHT))
        floor = tuple((u * MM_PER_PIXEL, (PICTURE_HEIGHT - v) * MM_PER_PIXEL) for u, v in corners)
        return cls(corners, floor, camera)

    def to_region(self, u: float, v: float, height: float = 0.0) -> Point:
        """Position on the floor, in region coordinates, of an object seen at a point of the picture.

        Args:
            u: In pixels.
            v: In pixels.
            height: Height in mm above the floor of the point seen.

        Raises:
            ValueError: A height not below the camera.
        """
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
        return _transformed(self._to_picture, x, y)

    def jacobian(self, u: float, v: float, height: float = 0.0) -> Jacobian:
        """The Jacobian of `to_region` at a point of the picture."""
        a, b, _, d, e, _, g, h, i = self._to_floor
        x, y = _transformed(self._to_floor, u, v)
        scale = (1.0 if self.camera is None else self._parallax(height)[2]) / (g * u + h * v + i)
        return Jacobian((a - x * g) * scale, (b - x * h) * scale, (d - y * g) * scale, (e - y * h) * scale)

    def as_table(self) -> dict[str, list[list[float]] | list[float]]:
        """The points as a table for a TOML file."""
        table: dict[str, list[list[float]] | list[float]] = {
            "picture": [list(point) for point in self.picture],
            "floor": [list(point) for point in self.floor],
        }
        if self.camera is not None:
            table["camera"] = list(self.camera)
        return table

    @classmethod
    def from_table(cls, table: Mapping[str, object]) -> "Calibration":
        """The calibration in a table of a TOML file.

        Raises:
            ValueError: A key that is missing or unknown, or points that `Calibration` refuses.
        """
        unknown = sorted(table.keys() - {"picture", "floor", "camera"})
        if unknown:
            raise ValueError(f"calibration key {unknown[0]!r} is unknown; allowed: picture, floor, camera")
        for key in ("picture", "floor"):
            if key not in table:
                raise ValueError(
                    f"calibration has no {key!r}; allowed: four points each for picture and floor"
                )
        return cls(table["picture"], table["floor"], table.get("camera"))  # type: ignore[arg-type] # checked there

    def save(self, path: str | Path) -> None:
        """Write the points to a TOML file."""
        lines = ["# picture: four points in pixels from the upper left corner; floor: the same points in mm."]
        lines += [f"{key} = {value}" for key, value in self.as_table().items()]
        Path(path).write_text("\n".join(lines) + "\n", encoding="utf-8")

    @classmethod
    def load(cls, path: str | Path) -> "Calibration":
        """Read a file written by `save`.

        Raises:
            OSError: The file cannot be read.
            ValueError: The file is not TOML, or `from_table` refuses it; the message names the file.
        """
        try:
            return cls.from_table(tomllib.loads(Path(path).read_text(encoding="utf-8")))
        except ValueError as error:  # includes TOMLDecodeError
            raise ValueError(f"{path}: {error}") from error

    def _parallax(self, height: float) -> tuple[float, float, float]:
        """The point below the camera (region coordinates), and the ratio of true to apparent distance from it."""
        assert self.camera is not None
        x, y, camera_height = self.camera
        if not height < camera_height:
            raise ValueError(
                f"height is {height!r} mm; allowed: below the camera, which is {camera_height} mm high"
            )
        return x / MM_PER_PIXEL, y / MM_PER_PIXEL, 1.0 - height / camera_height


def _numbers(name: str, value: object, count: int, form: str) -> tuple[float, ...]:
    if (
        not isinstance(value, Sequence | np.ndarray)
        or len(value) != count
        or not all(isinstance(n, int | float) and math.isfinite(n) for n in value)
    ):
        raise ValueError(f"calibration {name} is {value!r}; allowed: {count} finite numbers {form}")
    return tuple(float(n) for n in value)


def _points(name: str, value: object, form: str) -> tuple[tuple[float, ...], ...]:
    if not isinstance(value, Sequence | np.ndarray) or len(value) != 4:
        raise ValueError(f"calibration {name} is {value!r}; allowed: four points {form}")
    points = tuple(_numbers(f"{name} point", point, 2, form) for point in value)
    for one, other in combinations(points, 2):
        if one == other:
            raise ValueError(f"calibration {name} has the point {one} twice; allowed: four different points")
    for three in combinations(points, 3):
        longest = max(math.dist(p, q) for p, q in combinations(three, 2))
        if abs(_cross(*three)) < _FLAT * longest * longest:
            raise ValueError(
                f"calibration {name} points {', '.join(map(str, three))} lie on a line; "
                "allowed: no three points on one line"
            )
    return points


def _cross(p: Sequence[float], q: Sequence[float], r: Sequence[float]) -> float:
    """Twice the signed area of a triangle, positive when its corners turn from x towards y."""
    return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])


def _homography(picture: ArrayLike, floor: ArrayLike) -> NDArray[np.float64]:
    """The 3 x 3 matrix that maps four points to four others."""
    rows, targets = [], []
    for (u, v), (x, y) in zip(np.asarray(picture).tolist(), np.asarray(floor).tolist(), strict=True):
        rows += [[u, v, 1, 0, 0, 0, -x * u, -x * v], [0, 0, 0, u, v, 1, -y * u, -y * v]]
        targets += [x, y]
    return np.append(np.linalg.solve(rows, targets), 1.0).reshape(3, 3)


def _transformed(matrix: _Matrix, p: float, q: float) -> Point:
    a, b, c, d, e, f, g, h, i = matrix
    w = g * p + h * q + i
    return (a * p + b * q + c) / w, (d * p + e * q + f) / w
