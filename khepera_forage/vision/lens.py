"""Radial distortion of the camera's lens, in OpenCV's model."""

import math
from dataclasses import dataclass

from khepera_forage.vision.shapes import PICTURE_HEIGHT, PICTURE_WIDTH

Point = tuple[float, float]
Size = tuple[int, int]
"""Width and height of a picture in pixels."""

DEFAULT_SIZE: Size = (int(PICTURE_WIDTH), int(PICTURE_HEIGHT))
"""Of the thesis's camera (3.4)."""
_REPEATS = 20
_CONVERGED = 1e-12
_LEAST_SLOPE = 0.05
"""Least distance by which a point moves outwards in the picture, as a share of how far it would move without the
distortion."""


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
        if not (math.isfinite(self.k1) and math.isfinite(self.k2)):
            raise ValueError(f"calibration lens is {(self.k1, self.k2)}; allowed: two finite numbers")
        if not shows_every_point_once(self.k1, self.k2):
            raise ValueError(
                f"calibration lens is {(self.k1, self.k2)}; allowed: a distortion that shows every point once "
                "(k1 above -0.14 if k2 is 0)"
            )

    def straightened(self, u: float, v: float) -> Point:
        """Where a lens without distortion would show what this one shows at (u, v), in pixels."""
        du, dv = self._offset(u, v)
        r = shown = math.hypot(du, dv)
        for _ in range(_REPEATS):  # Newton's method
            slope = max(_slope(r, self.k1, self.k2), _LEAST_SLOPE)
            step = (r * _ratio(r * r, self.k1, self.k2) - shown) / slope
            r -= step
            if abs(step) < _CONVERGED:
                break
        return self._point(du, dv, r / shown if shown > 0 else 1.0)

    def distorted(self, u: float, v: float) -> Point:
        """Where this lens shows what a lens without distortion would show at (u, v): the inverse of `straightened`."""
        du, dv = self._offset(u, v)
        return self._point(du, dv, _ratio(du * du + dv * dv, self.k1, self.k2))

    def jacobian(self, u: float, v: float) -> tuple[float, float, float, float]:
        """Jacobian of `straightened` at (u, v): change of u with u, of u with v, of v with u, of v with v."""
        du, dv = self._offset(*self.straightened(u, v))
        r_squared = du * du + dv * dv
        ratio, growth = _ratio(r_squared, self.k1, self.k2), 2 * self.k1 + 4 * self.k2 * r_squared
        uu, uv, vv = ratio + growth * du * du, growth * du * dv, ratio + growth * dv * dv
        determinant = uu * vv - uv * uv
        return vv / determinant, -uv / determinant, -uv / determinant, uu / determinant

    def _offset(self, u: float, v: float) -> Point:
        return (u - self.size[0] / 2) / self.unit, (v - self.size[1] / 2) / self.unit

    def _point(self, du: float, dv: float, ratio: float) -> Point:
        return self.size[0] / 2 + du * ratio * self.unit, self.size[1] / 2 + dv * ratio * self.unit


def shows_every_point_once(k1: float, k2: float) -> bool:
    """Whether a lens, anywhere in the picture, shows a point further out if it lies further out; see `Lens`."""
    r = 0.0
    while r * _ratio(r * r, k1, k2) < 1.0:
        r += 0.01
        if _slope(r, k1, k2) <= _LEAST_SLOPE or r > 3:
            return False
    return True


def _ratio(r_squared: float, k1: float, k2: float) -> float:
    """Apparent distance from the middle as a multiple of the distance r."""
    return 1 + r_squared * (k1 + r_squared * k2)


def _slope(r: float, k1: float, k2: float) -> float:
    return 1 + r * r * (3 * k1 + 5 * k2 * r * r)
