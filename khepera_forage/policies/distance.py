"""The distance between two state vectors (section 4.6.1)."""

from collections.abc import Sequence
from fractions import Fraction
from numbers import Integral
from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.task.decisions import FLOATS_32, FLOATS_64
from khepera_forage.task.states import StateVector

STATE_WIDTH = len(StateVector._fields)
ARM_SPAN = 55
"""Xmax of equation 4.2: the thesis's maximum difference of ArmsHeight, larger than the 40 really used."""


def scaled_distance(differing: Any, arm: Any, pixels: Any, diagonal: Any) -> Any:
    """The distance of section 4.6.1 times 55 * diagonal: a whole number, so that equal distances are equal exactly.

    Kernels compile this function. It also works element by element on arrays.

    Args:
        differing: How many of ObjectPresence and FoodType differ.
        arm: Difference of ArmsHeight.
        pixels: Differences of RobotHomeDistance and RobotFoodDistance, added up.
        diagonal: Of the arena foraged in now, in pixels.
    """
    return (ARM_SPAN * differing + arm) * diagonal + ARM_SPAN * pixels


def rounded_distance(differing: Any, arm: Any, home: Any, food: Any, diagonal: int, arithmetic: float) -> Any:
    """The distance of section 4.6.1 as a sum of floats, in the order of that section.

    Sums of floats may differ in the last bit where the exact distances are equal. Where exact distances differ, they
    differ by more than rounding. Kernels compile this function, too.

    Args:
        differing: How many of ObjectPresence and FoodType differ.
        arm: Difference of ArmsHeight.
        home: Difference of RobotHomeDistance, pixels.
        food: Difference of RobotFoodDistance, pixels.
        diagonal: Of the arena foraged in now, in pixels.
        arithmetic: `FLOATS_32` or `FLOATS_64` of `task.decisions`; the result is 0.0 with `EXACT`.
    """
    if arithmetic == FLOATS_32:
        span, whole = np.float32(ARM_SPAN), np.float32(diagonal)
        total = np.float32(differing) + np.float32(arm) / span
        total = total + np.float32(food) / whole
        return total + np.float32(home) / whole
    if arithmetic == FLOATS_64:
        return differing + arm / ARM_SPAN + food / diagonal + home / diagonal
    return 0.0


CORRIDOR_DIAGONAL = 138
"""Of the thesis's corridor, in pixels."""
PIXEL: int = scaled_distance(0, 0, 1, 0)
"""What a pixel of either distance contributes to a scaled distance."""


def distance(a: StateVector, b: StateVector, diagonal: int) -> Fraction:
    """The distance between two state vectors (section 4.6.1), exactly.

    Args:
        a: A state vector; distances in pixels.
        b: Another one.
        diagonal: Of the arena foraged in now, in pixels; above 0.
    """
    differing = (a.object_presence != b.object_presence) + (a.food_type != b.food_type)
    arm = abs(a.arms_height - b.arms_height)
    home = abs(a.robot_home_distance - b.robot_home_distance)
    food = abs(a.robot_food_distance - b.robot_food_distance)
    return Fraction(scaled_distance(differing, arm, home + food, diagonal), ARM_SPAN * diagonal)


def attribute_distances(
    rows: NDArray[Any], query: NDArray[Any] | Sequence[float], diagonal: int
) -> NDArray[np.float64]:
    """What each attribute contributes to the distance between each row and a query.

    Floats hold sums of whole numbers exactly up to 2**53, so that equal distances of state vectors are equal here too.

    Args:
        rows: State vectors, one a row. Rows of any other width are taken for distances in pixels.
        query: One vector of the same width.
        diagonal: Of the arena foraged in now, in pixels.

    Returns:
        Of the shape of `rows`, in units of 1 / `unit(width, diagonal)`.
    """
    differences: NDArray[np.float64] = np.abs(rows - query).astype(np.float64, copy=False)
    if rows.shape[1] == STATE_WIDTH:
        category = scaled_distance(1, 0, 0, diagonal)
        arm = scaled_distance(0, 1, 0, diagonal)
        np.sign(differences[:, :3:2], out=differences[:, :3:2])  # the two categories
        differences *= (category, PIXEL, category, arm, PIXEL)
    return differences


def unit(width: int, diagonal: int) -> int:
    """How many units of `attribute_distances` make up a distance of 1, for rows of this width."""
    return ARM_SPAN * diagonal if width == STATE_WIDTH else diagonal


def checked_diagonal(diagonal: Any) -> int:
    """The diagonal, which must be an integer above 0."""
    if not isinstance(diagonal, Integral) or isinstance(diagonal, bool) or diagonal < 1:
        raise ValueError(f"diagonal is {diagonal!r}; allowed: an integer above 0, in pixels")
    return int(diagonal)
