"""Calibration of the overhead camera: lens, homography from picture to floor, and parallax of objects with a height.

Picture coordinates are (u, v): u to the right and v down from the upper left corner of the picture, so that the
middle of the pixel in row r and column c is (c + 0.5, r + 0.5). Region coordinates are those of `scene`: pixels
of 5 mm on the floor, x to the right and y up.
"""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np

from khepera_forage.vision.homography import (
    Matrix,
    Point,
    check_view,
    checked_numbers,
    checked_points,
    homography,
    transformed,
)
from khepera_forage.vision.lens import Lens
from khepera_forage.vision.scene import MM_PER_PIXEL
from khepera_forage.vision.shapes import PICTURE_HEIGHT, PICTURE_WIDTH

_KEYS = ("picture", "floor", "camera", "lens")


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

    Four points of the picture and the same four points on the floor determine a homography, after the lens is
    corrected; `calibration_fit` computes both from more points. The top of an object with a height appears further from
    the point below the camera than it is. With the camera's position and height known, this parallax is corrected:
    p_floor = c + (p - c) * (1 - height / camera height).

    Args:
        picture: Four points (u, v) in pixels.
        floor: The same four points on the floor (x, y) in mm.
        camera: Position x, y and height of the camera above the floor, in mm; None corrects no parallax.
        lens: Distortion of the lens; None corrects none.

    Raises:
        ValueError: Not four points, a value that is not finite, points that coincide, three points on a line, floor
            and picture points that no camera can show (mirrored or crossed), or a camera not above the floor.
    """

    picture: tuple[Point, ...]
    floor: tuple[Point, ...]
    camera: tuple[float, float, float] | None = None
    lens: Lens | None = None
    _to_floor: Matrix = field(init=False, repr=False, compare=False)
    _to_picture: Matrix = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        picture = checked_points("picture", self.picture, "(u, v)")
        floor = checked_points("floor", self.floor, "(x, y)")
        camera = None if self.camera is None else checked_numbers("camera", self.camera, 3, "(x, y, height)")
        if camera is not None and camera[2] <= 0:
            raise ValueError(f"calibration camera is {camera}; allowed: a height above 0 mm")
        check_view(picture, floor)
        straight = picture if self.lens is None else [self.lens.straightened(*point) for point in picture]
        to_floor = homography(straight, [(x / MM_PER_PIXEL, y / MM_PER_PIXEL) for x, y in floor])
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
        if self.lens is not None:
            u, v = self.lens.straightened(u, v)
        x, y = transformed(self._to_floor, u, v)
        if self.camera is None:
            return x, y
        centre_x, centre_y, shrink = self._parallax(height)
        return centre_x + (x - centre_x) * shrink, centre_y + (y - centre_y) * shrink

    def to_picture(self, x: float, y: float, height: float = 0.0) -> Point:
        """Point of the picture (pixels) where an object of that height is seen: the inverse of `to_region`."""
        if self.camera is not None:
            centre_x, centre_y, shrink = self._parallax(height)
            x, y = centre_x + (x - centre_x) / shrink, centre_y + (y - centre_y) / shrink
        u, v = transformed(self._to_picture, x, y)
        return (u, v) if self.lens is None else self.lens.distorted(u, v)

    def jacobian(self, u: float, v: float, height: float = 0.0) -> Jacobian:
        """The Jacobian of `to_region` at a point of the picture."""
        a, b, _, d, e, _, g, h, i = self._to_floor
        uu, uv, vu, vv = 1.0, 0.0, 0.0, 1.0
        if self.lens is not None:
            uu, uv, vu, vv = self.lens.jacobian(u, v)
            u, v = self.lens.straightened(u, v)
        x, y = transformed(self._to_floor, u, v)
        scale = (1.0 if self.camera is None else self._parallax(height)[2]) / (g * u + h * v + i)
        a, b, d, e = (a - x * g) * scale, (b - x * h) * scale, (d - y * g) * scale, (e - y * h) * scale
        return Jacobian(a * uu + b * vu, a * uv + b * vv, d * uu + e * vu, d * uv + e * vv)

    def as_table(self) -> dict[str, list[list[float]] | list[float]]:
        """The points, and the lens if it distorts, as a table for a TOML file."""
        table: dict[str, list[list[float]] | list[float]] = {
            "picture": [list(point) for point in self.picture],
            "floor": [list(point) for point in self.floor],
        }
        if self.camera is not None:
            table["camera"] = list(self.camera)
        if self.lens is not None:
            table["lens"] = [self.lens.k1, self.lens.k2]
        return table

    @classmethod
    def from_table(cls, table: Mapping[str, object]) -> "Calibration":
        """The calibration in a table of a TOML file.

        Raises:
            ValueError: A key that is missing or unknown, or points that `Calibration` refuses.
        """
        unknown = sorted(table.keys() - set(_KEYS))
        if unknown:
            raise ValueError(f"calibration key {unknown[0]!r} is unknown; allowed: {', '.join(_KEYS)}")
        for key in ("picture", "floor"):
            if key not in table:
                raise ValueError(
                    f"calibration has no {key!r}; allowed: four points each for picture and floor"
                )
        numbers = table.get("lens")
        lens = None if numbers is None else Lens(*checked_numbers("lens", numbers, 2, "(k1, k2)"))
        return cls(table["picture"], table["floor"], table.get("camera"), lens)  # type: ignore[arg-type] # checked there

    def save(self, path: str | Path) -> None:
        """Write the points, and the lens if it distorts, to a TOML file."""
        lines = ["# picture: four points in pixels from the upper left corner; floor: the same points in mm."]
        if self.lens is not None:
            lines.append("# lens: k1 and k2 of OpenCV's radial distortion for a focal length of 400 pixels.")
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
