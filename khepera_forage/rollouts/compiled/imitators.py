"""The imitators' search and vote (section 4.6), compiled from the functions of `policies.memories`."""

from bisect import bisect_left
from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation import entry, overload, rule
from khepera_forage.policies.distance import rounded_distance, scaled_distance
from khepera_forage.policies.memories import Memories, clear, nearest_votes, plane_key, search_plane
from khepera_forage.policies.policy import draw_label
from khepera_forage.task.states import NUM_BEHAVIOURS

__all__ = ["clear", "confidence_levels", "draw_label", "nearest_votes"]

_FEW = 16
"""Values among which looking at one after the other is faster than halving."""

for _rule in (scaled_distance, rounded_distance, plane_key, clear, search_plane, nearest_votes, draw_label):
    rule(_rule)


@overload(bisect_left)  # numba compiles no C functions
def _bisect_left(values: Any, value: Any, first: Any, last: Any) -> Any:
    def search(values: Any, value: Any, first: Any, last: Any) -> Any:
        while last - first > _FEW:
            middle = (first + last) // 2
            if values[middle] < value:
                first = middle + 1
            else:
                last = middle
        while first < last and values[first] < value:
            first += 1
        return first

    return search


def confidence_levels(
    memories: Memories, vectors: NDArray[np.int64], diagonal: int, arithmetic: float
) -> NDArray[np.float64]:
    """Confidence levels (4.6.2) of every imitator for every state vector, without foraging.

    Args:
        memories: From `policies.memories.memories_of`.
        vectors: State vectors in the last axis, of any shape before it.
        diagonal: Of the arena foraged in, pixels.
        arithmetic: The decision `distance_arithmetic` as a number.

    Returns:
        Shape (imitators, ..., 10), with the axes of `vectors` before its last one in the middle.
    """
    flat = vectors.reshape(-1, vectors.shape[-1])
    votes = np.zeros((len(memories.planes) - 1, len(flat), NUM_BEHAVIOURS), np.int64)
    _count_votes(memories, flat, diagonal, votes, arithmetic)
    shares: NDArray[np.float64] = votes / votes.sum(axis=-1, keepdims=True)
    return shares.reshape(votes.shape[0], *vectors.shape[:-1], NUM_BEHAVIOURS)


@entry
def _count_votes(
    memories: Memories, vectors: NDArray[np.int64], diagonal: int, votes: NDArray[np.int64], arithmetic: float
) -> None:
    for memory in range(votes.shape[0]):
        for k in range(vectors.shape[0]):
            v = vectors[k]
            vector = (v[0], v[1], v[2], v[3], v[4])
            nearest_votes(memories, memory, vector, diagonal, votes[memory, k], arithmetic)
