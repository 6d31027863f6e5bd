"""Memories: the experience of imitators, sorted for the search of `nearest_votes`."""

from collections.abc import Iterable, Sequence
from typing import Any, Generic, NamedTuple, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from khepera_forage.task.states import Behaviour, FoodType, StateVector

BEHAVIOURS = int(Behaviour.WAIT)
"""How many behaviours can be heard; WAIT is silence."""
PRESENCES = 2
FOOD_TYPES = len(FoodType)
ARMS = 256
"""Values of ArmsHeight, from 0."""
DISTANCES = 8192
"""Values of the two distances, from 0: more than any arena has pixels."""
SIZES = StateVector(PRESENCES, DISTANCES, FOOD_TYPES, ARMS, DISTANCES)
"""How many values a memory can hold of each attribute, from 0."""
MAX_MEMORIES = 2**22
_DISTANCE_BITS, _KEY_BITS = 13, 11
_Numbers = TypeVar("_Numbers")


class FlatMemories(NamedTuple, Generic[_Numbers]):
    """The experience vectors of one imitator or of many, in flat lists or arrays of whole numbers.

    Vectors of equal ObjectPresence, FoodType and ArmsHeight are a plane of points: only the two distances in pixels are
    left to compare. Those of equal RobotHomeDistance are a column of the plane. Everything is sorted in increasing
    order: the planes of a memory, the columns of a plane, the vectors of a column.

    Attributes:
        planes: Number of each memory's first plane; in the end that of all planes.
        keys: ObjectPresence, FoodType and ArmsHeight of each plane as one number, see `plane_key`.
        columns: Number of each plane's first column; in the end that of all columns.
        home: RobotHomeDistance of each column, pixels.
        vectors: Number of each column's first vector; in the end that of all vectors.
        food: RobotFoodDistance of each vector, pixels.
        label: The behaviour heard with each vector. A vector heard with two behaviours stands there twice.
        times: How often each vector was heard with its behaviour.
    """

    planes: _Numbers
    keys: _Numbers
    columns: _Numbers
    home: _Numbers
    vectors: _Numbers
    food: _Numbers
    label: _Numbers
    times: _Numbers


Memories: TypeAlias = FlatMemories[NDArray[np.integer[Any]]]
"""Memories of many imitators, in arrays, as kernels take them."""
ListMemory: TypeAlias = FlatMemories[list[int]]
"""The memory of one imitator, in lists, which Python reads faster."""


def plane_key(presence: Any, food_type: Any, arm: Any) -> Any:
    """ObjectPresence, FoodType and ArmsHeight as one number; it also works on arrays."""
    return (presence * FOOD_TYPES + food_type) * ARMS + arm


def memories_of(experiences: Iterable[tuple[ArrayLike, ArrayLike]]) -> Memories:
    """One memory for each experience: what an imitator fitted to it would know.

    Args:
        experiences: State vectors, shape (n, 5), and the behaviour heard with each, shape (n,), as `Experience.arrays`
            gives them; n is at least 1.

    Raises:
        ValueError: There are no vectors, or numbers that are no state vectors or behaviours.
    """
    parts = [(np.asarray(vectors), np.asarray(heard)) for vectors, heard in experiences]
    if not 1 <= len(parts) <= MAX_MEMORIES:
        raise ValueError(f"{len(parts)} experiences; allowed: 1 to {MAX_MEMORIES:,}")
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
    return _of_behaviours(merged(vectors, heard, np.repeat(np.arange(len(parts)), sizes), len(parts)))


def merged(
    vectors: NDArray[np.int64],
    labels: NDArray[np.int64],
    memory: NDArray[np.int64] | int = 0,
    memories: int = 1,
) -> Memories:
    """Memories of state vectors; equal vectors with equal labels become one.

    Args:
        vectors: Of shape (n, 5), within `SIZES`.
        labels: The label of each vector, from 0; at most 16 different ones for the most memories.
        memory: The memory that each vector belongs to.
        memories: How many memories there are.
    """
    presence, home, food_type, arm, food = vectors.T
    label_bits = int(labels.max(initial=0)).bit_length()
    # One number a vector, so that all are sorted at once.
    numbers = (memory << _KEY_BITS) + plane_key(presence, food_type, arm)
    numbers = (numbers << _DISTANCE_BITS) + home
    numbers = (numbers << _DISTANCE_BITS) + food
    numbers, times = np.unique((numbers << label_bits) + labels, return_counts=True)
    points = numbers >> label_bits
    columns, starts = np.unique(points >> _DISTANCE_BITS, return_index=True)
    planes, first_columns = np.unique(columns >> _DISTANCE_BITS, return_index=True)
    return FlatMemories(
        planes=np.searchsorted(planes >> _KEY_BITS, np.arange(memories + 1)).astype(np.int64),
        keys=_last_bits(planes, _KEY_BITS).astype(np.int32),
        columns=np.append(first_columns, len(columns)).astype(np.int32),
        home=_last_bits(columns, _DISTANCE_BITS).astype(np.int32),
        vectors=np.append(starts, len(numbers)).astype(np.int32),
        food=_last_bits(points, _DISTANCE_BITS).astype(np.int16),
        label=_last_bits(numbers, label_bits).astype(np.int32),
        times=times.astype(np.int32),
    )


def _last_bits(numbers: NDArray[np.int64], bits: int) -> NDArray[np.int64]:
    return numbers & (1 << bits) - 1


def _of_behaviours(memories: Memories) -> Memories:
    """Labels that are behaviours take a byte each."""
    return memories._replace(label=memories.label.astype(np.int8))


def _whole(values: NDArray[np.generic]) -> NDArray[np.int64]:
    if values.dtype.kind not in "iu":
        raise ValueError(f"experience is of type {values.dtype}; allowed: whole numbers")
    return values.astype(np.int64)


def _check(vectors: NDArray[np.int64], heard: NDArray[np.int64]) -> None:
    columns: Sequence[tuple[str, NDArray[np.int64], int]] = [
        *((name, vectors[:, k], SIZES[k]) for k, name in enumerate(StateVector._fields)),
        ("behaviour", heard, BEHAVIOURS),
    ]
    for name, values, size in columns:
        for value in (int(values.min()), int(values.max())):
            if not 0 <= value < size:
                raise ValueError(f"{name} is {value}; allowed: 0 to {size - 1}")


NO_MEMORIES = _of_behaviours(merged(np.zeros((0, 5), np.int64), np.zeros(0, np.int64), memories=0))
"""The memories of no imitators."""
