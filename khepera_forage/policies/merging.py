"""Equal experience vectors merged into one with a count: a million of a corridor are some 12,000 different ones."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import NDArray

FEW = 200
"""Rows up to which taking them one by one is faster than sorting them."""
KEYS = 2**62
"""More different rows than this, and they cannot be numbered with 64 bits."""


def merged(rows: NDArray[Any], codes: NDArray[np.intp]) -> Iterable[tuple[list[Any], int, int]]:
    """Each distinct row with each class it has, and how many times.

    Args:
        rows: One vector a row.
        codes: The class of each.

    Returns:
        Row, class and times, in no particular order; a few rows are handed back as they are, once each.
    """
    if len(rows) <= FEW:
        return zip(rows.tolist(), codes.tolist(), [1] * len(rows), strict=True)
    labelled = np.column_stack((rows, codes))
    firsts, times = _distinct(labelled)
    return zip(rows[firsts].tolist(), codes[firsts].tolist(), times.tolist(), strict=True)


def _distinct(rows: NDArray[Any]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Where each distinct row comes first, and how often it comes."""
    axis: int | None = 0
    keys = rows
    if np.issubdtype(rows.dtype, np.integer):
        lows, highs = rows.min(axis=0).tolist(), rows.max(axis=0).tolist()
        spans = [high - low + 1 for low, high in zip(lows, highs, strict=True)]
        if np.prod(spans, dtype=object) < KEYS:  # one number a row: sorting is then fifty times as fast
            axis, keys = None, np.zeros(len(rows), np.int64)
            for column, low, span in zip(rows.T, lows, spans, strict=True):
                keys = keys * span + (column.astype(np.int64) - low)
    _, firsts, times = np.unique(keys, return_index=True, return_counts=True, axis=axis)
    return firsts, times
