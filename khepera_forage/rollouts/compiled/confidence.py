"""Confidence levels of many imitators for the same state vectors, without foraging."""

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import entrance
from khepera_forage.policies.nearest_neighbour.memories import BEHAVIOURS, Memories
from khepera_forage.rollouts.compiled.nearest_neighbour import nearest_votes


@entrance
def _count_votes(
    memories: Memories,
    vectors: NDArray[np.int64],
    diagonal: int,
    votes: NDArray[np.int64],
    arithmetic: float,
) -> None:
    for memory in range(votes.shape[0]):
        for k in range(vectors.shape[0]):
            v = vectors[k]
            vector = (v[0], v[1], v[2], v[3], v[4])
            nearest_votes(memories, memory, vector, diagonal, votes[memory, k], arithmetic)


def confidence_levels(
    memories: Memories, vectors: NDArray[np.int64], diagonal: int, arithmetic: float
) -> NDArray[np.float64]:
    """Confidence levels (4.6.2) of every imitator for every state vector.

    Args:
        memories: From `policies.nearest_neighbour.memories.memories_of`.
        vectors: State vectors in the last axis, of any shape before it.
        diagonal: Of the arena foraged in, pixels.
        arithmetic: The decision `distance_arithmetic` as a number.

    Returns:
        Shape (imitators, *shape of vectors without its last axis, 10).
    """
    flat = vectors.reshape(-1, vectors.shape[-1])
    votes = np.zeros((len(memories.planes) - 1, len(flat), BEHAVIOURS), np.int64)
    _count_votes(memories, flat, diagonal, votes, arithmetic)
    shares: NDArray[np.float64] = votes / votes.sum(axis=-1, keepdims=True)
    return shares.reshape(votes.shape[0], *vectors.shape[:-1], BEHAVIOURS)
