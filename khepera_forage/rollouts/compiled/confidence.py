"""What many imitators say to the same questions, without foraging."""

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation.decorators import entrance
from khepera_forage.policies.ballot import BEHAVIOURS, Memories, vote
from khepera_forage.rollouts.compiled import policy_kernel  # noqa: F401 (makes the vote known to the compiler)


@entrance
def _poll(memories: Memories, vectors: NDArray[np.int64], diagonal: int, counts: NDArray[np.int64]) -> None:
    for memory in range(counts.shape[0]):
        for k in range(vectors.shape[0]):
            v = vectors[k]
            vote(memories, memory, (v[0], v[1], v[2], v[3], v[4]), diagonal, counts[memory, k])


def confidence_levels(memories: Memories, vectors: NDArray[np.int64], diagonal: int) -> NDArray[np.float64]:
    """Confidence levels (4.6.2) of every imitator for every state vector.

    Args:
        memories: From `policies.ballot_box.memories_of`.
        vectors: State vectors in the last axis, of any shape before it.
        diagonal: Of the arena foraged in, pixels.

    Returns:
        Shape (imitators, *shape of vectors without its last axis, 10).
    """
    flat = vectors.reshape(-1, vectors.shape[-1])
    counts = np.zeros((len(memories.planes) - 1, len(flat), BEHAVIOURS), np.int64)
    _poll(memories, flat, diagonal, counts)
    shares: NDArray[np.float64] = counts / counts.sum(axis=-1, keepdims=True)
    return shares.reshape(counts.shape[0], *vectors.shape[:-1], BEHAVIOURS)
