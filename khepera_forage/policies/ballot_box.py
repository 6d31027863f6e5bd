"""The memories of many imitators, put together from experience: thousands of them in a second."""

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from khepera_forage.policies.ballot import BEHAVIOURS, Memories, plane_key
from khepera_forage.task.states import StateVector

LARGEST = {"object_presence": 1, "robot_home_distance": 8191, "food_type": 3, "arms_height": 255}
"""What a memory can hold of each attribute; the least is 0."""
LARGEST["robot_food_distance"] = LARGEST["robot_home_distance"]
MOST_MEMORIES = 2**22
_DISTANCE, _BEHAVIOUR, _PLANE, _MEMORY = 13, 4, 11, 22
"""Bits that each takes in the number of a vector."""
NO_MEMORIES = Memories(
    np.zeros(1, np.int64),
    np.zeros(0, np.int32),
    np.zeros(1, np.int64),
    np.zeros(0, np.int16),
    np.zeros(0, np.int16),
    np.zeros(0, np.int8),
    np.zeros(0, np.int32),
)
"""Of no imitators."""


def memories_of(experiences: Iterable[tuple[ArrayLike, ArrayLike]]) -> Memories:
    """One memory each of some experiences: what an imitator fitted to it would know.

    Args:
        experiences: State vectors, shape (n, 5), and the behaviour heard with each, shape (n,), as `Experience.arrays`
            gives them; n is at least 1.

    Raises:
        ValueError: No vectors, or numbers that are no state vectors or behaviours.
    """
    parts = [(np.asarray(vectors), np.asarray(heard)) for vectors, heard in experiences]
    if not 1 <= len(parts) <= MOST_MEMORIES:
        raise ValueError(f"{len(parts)} experiences; allowed: 1 to {MOST_MEMORIES:,}")
    for number, (vectors, heard) in enumerate(parts):
        if vectors.ndim != 2 or vectors.shape[1] != 5 or heard.shape != vectors.shape[:1] or not len(heard):
            raise ValueError(
                f"experience {number} has vectors of shape {vectors.shape} and behaviours of shape {heard.shape}; "
                "allowed: (n, 5) and (n,), n at least 1"
            )
    sizes = np.array([len(heard) for _, heard in parts])
    vectors = _whole(np.concatenate([vectors for vectors, _ in parts]))
    heard = _whole(np.concatenate([heard for _, heard in parts]))
    _check(vectors, heard)
    return _merged(np.repeat(np.arange(len(parts)), sizes), vectors, heard, len(parts))


def _whole(values: NDArray[np.generic]) -> NDArray[np.int64]:
    if values.dtype.kind not in "iu":
        raise ValueError(f"experience is of type {values.dtype}; allowed: whole numbers")
    return values.astype(np.int64)


def _check(vectors: NDArray[np.int64], heard: NDArray[np.int64]) -> None:
    columns: Sequence[tuple[str, NDArray[np.int64], int]] = [
        *((name, vectors[:, k], LARGEST[name]) for k, name in enumerate(StateVector._fields)),
        ("behaviour", heard, BEHAVIOURS - 1),
    ]
    for name, values, largest in columns:
        for value in (int(values.min()), int(values.max())):
            if not 0 <= value <= largest:
                raise ValueError(f"{name} is {value}; allowed: 0 to {largest}")


def _merged(
    memory: NDArray[np.int64], vectors: NDArray[np.int64], heard: NDArray[np.int64], memories: int
) -> Memories:
    """Equal vectors with equal behaviours become one, in the order of `Memories`."""
    presence, home, food_type, arm, food = vectors.T
    numbers = memory
    # The order of these is the order in which they are sorted.
    for values, bits in (
        (plane_key(presence, food_type, arm), _PLANE),
        (home, _DISTANCE),
        (food, _DISTANCE),
        (heard, _BEHAVIOUR),
    ):
        numbers = (numbers << bits) + values
    numbers, counts = np.unique(numbers, return_counts=True)
    below = 2 * _DISTANCE + _BEHAVIOUR
    planes, vectors_first = np.unique(numbers >> below, return_index=True)
    return Memories(
        planes=np.searchsorted(planes >> _PLANE, np.arange(memories + 1)).astype(np.int64),
        keys=(planes & (1 << _PLANE) - 1).astype(np.int32),
        vectors=np.append(vectors_first, len(numbers)).astype(np.int64),
        home=(numbers >> _DISTANCE + _BEHAVIOUR & (1 << _DISTANCE) - 1).astype(np.int16),
        food=(numbers >> _BEHAVIOUR & (1 << _DISTANCE) - 1).astype(np.int16),
        behaviour=(numbers & (1 << _BEHAVIOUR) - 1).astype(np.int8),
        times=counts.astype(np.int32),
    )
