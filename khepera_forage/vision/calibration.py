"""From the picture of an overhead camera to the arena plane: four points, and parallax for what stands above it.

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


class Stretch(NamedTuple):
    """How region coordinates change with picture coordinates around a point: the Jacobian of the calibration.

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
        """Square region pixels in a square pixel of the picture."""
        return abs(self.xu * self.yv - self.xv * self.yu)


@dataclass(frozen=True, slots=True)
class Calibration:
    """Where on the floor a point of the picture is.

    Four points of the picture and the places on the floor that they show fix a homography. It knows no bend of
    straight lines: correct a wide lens before. A thing with a height is seen further from the point below the camera
    than it stands; with the camera's own place and height known, that is corrected too:
    p_floor = c + (p - c) * (1 - height / camera height).

    Args:
        picture: Four points (u, v) in pixels.
        floor: The same four points on the floor (x, y) in mm.
        camera: Its place x, y on the floor plan and its height above the floor, in mm; None corrects no parallax.

    Raises:
        ValueError: Not four points, a value that is not finite, points that coincide, three on a line, floor and
            picture that cannot show each other (mirrored or crossed), or a camera that is not above the floor.
    """

    picture: tuple[Point, ...]
    floor: tuple[Point, ...]
    camera: tuple[float, float, float] | None = None
    _forth: _Matrix = field(init=False, repr=False, compare=False)
    _back: _Matrix = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        picture, floor = _points("picture", self.picture, "(u, v)"), _points("floor", self.floor, "(x, y)")
        camera = None if self.camera is None else _numbers("camera", self.camera, 3, "(x, y, height)")
        if camera is not None and camera[2] <= 0:
            raise ValueError(f"calibration camera is {camera}; allowed: a height above 0 mm")
        forth = _homography(picture, [(x / MM_PER_PIXEL, y / MM_PER_PIXEL) for x, y in floor])
        # The picture's v grows downwards: without a mirror, a turn that is left on the floor is right in (u, v).
        turned = [
            _cross(*(floor[i] for i in three)) * _cross(*(picture[i] for i in three)) < 0
            for three in combinations(range(4), 3)
        ]
        if not all(turned):
            how = "crossed" if any(turned) else "mirrored"
            raise ValueError(
                f"calibration points are {how}: picture {picture} cannot be a view from above of floor {floor}; "
                "allowed: both in the same order"
            )
        for name, value in (("picture", picture), ("floor", floor), ("camera", camera)):
            object.__setattr__(self, name, value)
        object.__setattr__(self, "_forth", tuple(forth.ravel().tolist()))
        object.__setattr__(self, "_back", tuple(np.linalg.inv(forth).ravel().tolist()))

    @classmethod
    def identity(cls, camera: tuple[float, float, float] | None = None) -> "Calibration":
        """An undistorted 640 x 480 picture with 5 mm a pixel, its lower left corner at (0, 0) mm."""
        corners = ((0.0, 0.0), (PICTURE_WIDTH, 0.0), (PICTURE_WIDTH, PICTURE_HEIGHT), (0.0, PICTURE_HEIGHT))
        floor = tuple((u * MM_PER_PIXEL, (PICTURE_HEIGHT - v) * MM_PER_PIXEL) for u, v in corners)
        return cls(corners, floor, camera)

    def to_region(self, u: float, v: float, height: float = 0.0) -> Point:
        """Where the thing stands that is seen at a point of the picture, in region coordinates.

        Args:
            u: In pixels.
            v: In pixels.
            height: Of what is seen above the floor in mm.
        """
        x, y = _mapped(self._forth, u, v)
        if self.camera is None:
            return x, y
        over_x, over_y, near = self._below(height)
        return over_x + (x - over_x) * near, over_y + (y - over_y) * near

    def to_picture(self, x: float, y: float, height: float = 0.0) -> Point:
        """The point of the picture (pixels) at which a thing of that height is seen: the inverse of `to_region`."""
        if self.camera is not None:
            over_x, over_y, near = self._below(height)
            x, y = over_x + (x - over_x) / near, over_y + (y - over_y) / near
        return _mapped(self._back, x, y)

    def stretch(self, u: float, v: float, height: float = 0.0) -> Stretch:
        """The Jacobian of `to_region` at a point of the picture."""
        a, b, _, d, e, _, g, h, i = self._forth
        x, y = _mapped(self._forth, u, v)
        scale = (1.0 if self.camera is None else self._below(height)[2]) / (g * u + h * v + i)
        return Stretch((a - x * g) * scale, (b - x * h) * scale, (d - y * g) * scale, (e - y * h) * scale)

    def as_table(self) -> dict[str, list[list[float]] | list[float]]:
        """The points as they stand in a TOML file."""
        table: dict[str, list[list[float]] | list[float]] = {
            "picture": [list(point) for point in self.picture],
            "floor": [list(point) for point in self.floor],
        }
        if self.camera is not None:
            table["camera"] = list(self.camera)
        return table

    @classmethod
    def from_table(cls, table: Mapping[str, object]) -> "Calibration":
        """The calibration that a table of a TOML file tells.

        Raises:
            ValueError: A key that is missing or unknown, or points of which `Calibration` can make nothing.
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
        """Read what `save` wrote.

        Raises:
            OSError: The file cannot be read.
            ValueError: It is no TOML, or `from_table` refuses it; the message names the file.
        """
        try:
            return cls.from_table(tomllib.loads(Path(path).read_text(encoding="utf-8")))
        except ValueError as error:  # a TOMLDecodeError is one
            raise ValueError(f"{path}: {error}") from error

    def _below(self, height: float) -> tuple[float, float, float]:
        """The point below the camera (region coordinates), and how much nearer to it a thing is than it seems."""
        assert self.camera is not None
        x, y, above = self.camera
        if not height < above:
            raise ValueError(
                f"height is {height!r} mm; allowed: below the camera, which hangs {above} mm high"
            )
        return x / MM_PER_PIXEL, y / MM_PER_PIXEL, 1.0 - height / above


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
                "allowed: no three of the four on one"
            )
    return points


def _cross(p: Sequence[float], q: Sequence[float], r: Sequence[float]) -> float:
    """Twice the area of a triangle, positive when it turns from x towards y."""
    return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])


def _homography(picture: ArrayLike, floor: ArrayLike) -> NDArray[np.float64]:
    """The 3 x 3 matrix that takes four points to four others."""
    rows, places = [], []
    for (u, v), (x, y) in zip(np.asarray(picture).tolist(), np.asarray(floor).tolist(), strict=True):
        rows += [[u, v, 1, 0, 0, 0, -x * u, -x * v], [0, 0, 0, u, v, 1, -y * u, -y * v]]
        places += [x, y]
    return np.append(np.linalg.solve(rows, places), 1.0).reshape(3, 3)


def _mapped(matrix: _Matrix, p: float, q: float) -> Point:
    a, b, c, d, e, f, g, h, i = matrix
    w = g * p + h * q + i
    return (a * p + b * q + c) / w, (d * p + e * q + f) / w
