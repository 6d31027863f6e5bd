"""The distance of section 4.6.1 from one vector to many, attribute by attribute, with weights."""

from collections.abc import Sequence
from numbers import Integral
from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.policies.votes import ARM_SPAN

STATE_VECTOR = 5
"""Columns of a state vector."""
CODED = 9
"""Columns of a coded state vector."""
FOOD_TYPES = 4


def apart(rows: NDArray[Any], query: NDArray[Any], diagonal: int) -> NDArray[np.float64]:
    """How far each row is from a query in each column, in whole units of 1 / (55 * diagonal).

    The distance is the sum over the columns, with or without weights. Sums of whole numbers are exact in floats up
    to 2**53, so that ties are ties.

    Args:
        rows: State vectors, one a row. Rows of other than five columns are no state vectors: there the unit is 1.
        query: One of the same width.
        diagonal: Of the arena foraged in now, in pixels.

    Returns:
        Of the shape of `rows`.
    """
    away: NDArray[np.float64] = np.abs(rows - query).astype(np.float64, copy=False)
    if rows.shape[1] == STATE_VECTOR:
        presence_or_type = away[:, [0, 2]] != 0
        away *= (1.0, ARM_SPAN, 1.0, diagonal, ARM_SPAN)
        away[:, [0, 2]] = presence_or_type * float(ARM_SPAN * diagonal)
    return away


def checked_diagonal(diagonal: Any) -> int:
    """A diagonal in range.

    Raises:
        ValueError: Any other.
    """
    if not isinstance(diagonal, Integral) or isinstance(diagonal, bool) or diagonal < 1:
        raise ValueError(f"diagonal is {diagonal!r}; allowed: an integer above 0, in pixels")
    return int(diagonal)


def coded(vectors: NDArray[Any] | Sequence[Any], diagonal: int) -> NDArray[np.float64]:
    """State vectors for learners that calculate: categories one-hot at half weight, numbers scaled.

    Between coded vectors the Manhattan distance is that of section 4.6.1.

    Args:
        vectors: Of shape (n, 5).
        diagonal: What the two distances are divided by, in pixels.

    Returns:
        Of shape (n, 9): two columns for ObjectPresence, four for FoodType (0 or 0.5 each), then ArmsHeight by 55,
        RobotHomeDistance and RobotFoodDistance by the diagonal.

    Raises:
        ValueError: Not five columns.
    """
    rows = np.asarray(vectors, np.float64)
    if rows.ndim != 2 or rows.shape[1] != STATE_VECTOR:
        raise ValueError(f"vectors have shape {rows.shape}; allowed: (n, {STATE_VECTOR})")
    presence, home, food_type, arm, food = rows.T
    out = np.empty((len(rows), CODED))
    out[:, :2] = 0.5 * (presence[:, None] == np.arange(2))
    out[:, 2:6] = 0.5 * (food_type[:, None] == np.arange(FOOD_TYPES))
    out[:, 6] = (arm - 215) / ARM_SPAN
    out[:, 7] = home / diagonal
    out[:, 8] = food / diagonal
    return out
