"""Homographies between four points of the picture and four points on the floor, and checks of such points."""

import math
from collections.abc import Sequence
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Point = tuple[float, float]
Matrix = tuple[float, ...]
"""The nine numbers of a homography, row by row."""

_FLAT = 0.01
"""Three points are taken for collinear when the triangle's height is less than this share of its longest side."""


def homography(picture: ArrayLike, floor: ArrayLike) -> NDArray[np.float64]:
    """The 3 x 3 matrix that maps four points to four others."""
    rows, targets = [], []
    for (u, v), (x, y) in zip(np.asarray(picture).tolist(), np.asarray(floor).tolist(), strict=True):
        rows += [[u, v, 1, 0, 0, 0, -x * u, -x * v], [0, 0, 0, u, v, 1, -y * u, -y * v]]
        targets += [x, y]
    return np.append(np.linalg.solve(rows, targets), 1.0).reshape(3, 3)


def transformed(matrix: Matrix, p: float, q: float) -> Point:
    """The point to which a homography maps (p, q)."""
    a, b, c, d, e, f, g, h, i = matrix
    w = g * p + h * q + i
    return (a * p + b * q + c) / w, (d * p + e * q + f) / w


def check_view(picture: Sequence[Sequence[float]], floor: Sequence[Sequence[float]]) -> None:
    """Check that four points of the picture can be a view from above of four points on the floor.

    Raises:
        ValueError: They are mirrored or crossed.
    """
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


def checked_numbers(name: str, value: object, count: int, form: str) -> tuple[float, ...]:
    """A sequence of finite numbers as floats.

    Raises:
        ValueError: Anything else.
    """
    if (
        not isinstance(value, Sequence | np.ndarray)
        or len(value) != count
        or not all(isinstance(n, int | float) and math.isfinite(n) for n in value)
    ):
        raise ValueError(f"calibration {name} is {value!r}; allowed: {count} finite numbers {form}")
    return tuple(float(n) for n in value)


def checked_points(name: str, value: object, form: str) -> tuple[tuple[float, ...], ...]:
    """Four different points of which no three lie on a line.

    Raises:
        ValueError: Anything else.
    """
    if not isinstance(value, Sequence | np.ndarray) or len(value) != 4:
        raise ValueError(f"calibration {name} is {value!r}; allowed: four points {form}")
    points = tuple(checked_numbers(f"{name} point", point, 2, form) for point in value)
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
