"""Memories: the experience of many imitators in arrays, and the search that kernels compile (section 4.6.1).

Python's own imitator, `policies.imitator`, compares a query with all vectors; kernels have no time for that.
"""

from bisect import bisect_left
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from khepera_forage.policies.distance import PIXEL, rounded_distance, scaled_distance
from khepera_forage.task.decisions import EXACT
from khepera_forage.task.states import NUM_BEHAVIOURS, FoodType, StateVector

FOOD_TYPES = len(FoodType)
ARMS = 256
"""Values of ArmsHeight, from 0."""
DISTANCES = 8192
"""Values of the two distances, from 0: more than any arena has pixels."""
SIZES = StateVector(2, DISTANCES, FOOD_TYPES, ARMS, DISTANCES)
"""How many values a memory can hold of each attribute, from 0."""
MAX_MEMORIES = 2**22
_DISTANCE_BITS, _KEY_BITS, _LABEL_BITS = 13, 11, 4


class Memories(NamedTuple):
    """The experience vectors of many imitators, in flat arrays of whole numbers.

    Vectors of equal ObjectPresence, FoodType and ArmsHeight are a plane of points: only the two distances in pixels are
    left to compare. The planes of a memory are sorted by their keys, the vectors of a plane by their home distances.

    Attributes:
        planes: Number of each memory's first plane; in the end that of all planes.
        keys: ObjectPresence, FoodType and ArmsHeight of each plane as one number, see `plane_key`.
        vectors: Number of each plane's first vector; in the end that of all vectors.
        home: RobotHomeDistance of each vector, pixels.
        food: RobotFoodDistance of each vector, pixels.
        label: The behaviour heard with each vector. A vector heard with two behaviours stands there twice.
        times: How often each vector was heard with its behaviour.
    """

    planes: NDArray[np.int64]
    keys: NDArray[np.int32]
    vectors: NDArray[np.int32]
    home: NDArray[np.int32]
    food: NDArray[np.int16]
    label: NDArray[np.int8]
    times: NDArray[np.int32]


def plane_key(presence: Any, food_type: Any, arm: Any) -> Any:
    """ObjectPresence, FoodType and ArmsHeight as one number; it also works on arrays."""
    return (presence * FOOD_TYPES + food_type) * ARMS + arm


def memories_of(experiences: Iterable[tuple[ArrayLike, ArrayLike]]) -> Memories:
    """One memory for each experience: what an imitator fitted to it would know.

    Args:
        experiences: State vectors, shape (n, 5), and the behaviour heard with each, shape (n,), as `Experience.arrays`
            gives them; n is at least 1.
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
    vectors = np.concatenate([vectors for vectors, _ in parts])
    heard = np.concatenate([heard for _, heard in parts])
    columns = zip((*StateVector._fields, "behaviour"), (*vectors.T, heard), (*SIZES, NUM_BEHAVIOURS), strict=True)
    for name, values, size in columns:
        if values.dtype.kind not in "iu":
            raise ValueError(f"experience is of type {values.dtype}; allowed: whole numbers")
        for value in (int(values.min()), int(values.max())):
            if not 0 <= value < size:
                raise ValueError(f"{name} is {value}; allowed: 0 to {size - 1}")
    memory = np.repeat(np.arange(len(parts)), [len(heard) for _, heard in parts])
    return _merged(vectors.astype(np.int64), heard.astype(np.int64), memory, len(parts))


def _merged(vectors: NDArray[np.int64], heard: NDArray[np.int64], memory: NDArray[np.int64], memories: int) -> Memories:
    """Memories of state vectors, given the number of the memory of each; equal ones become one."""
    presence, home, food_type, arm, food = vectors.T
    # One number a vector, so that all are sorted at once.
    numbers = (memory << _KEY_BITS) + plane_key(presence, food_type, arm)
    numbers = (numbers << _DISTANCE_BITS) + home
    numbers = (numbers << _DISTANCE_BITS) + food
    numbers, times = np.unique((numbers << _LABEL_BITS) + heard, return_counts=True)
    foods = numbers >> _LABEL_BITS
    homes = foods >> _DISTANCE_BITS
    planes, starts = np.unique(homes >> _DISTANCE_BITS, return_index=True)
    return Memories(
        planes=np.searchsorted(planes >> _KEY_BITS, np.arange(memories + 1)).astype(np.int64),
        keys=_last_bits(planes, _KEY_BITS).astype(np.int32),
        vectors=np.append(starts, len(numbers)).astype(np.int32),
        home=_last_bits(homes, _DISTANCE_BITS).astype(np.int32),
        food=_last_bits(foods, _DISTANCE_BITS).astype(np.int16),
        label=_last_bits(numbers, _LABEL_BITS).astype(np.int8),
        times=times.astype(np.int32),
    )


def _last_bits(numbers: NDArray[np.int64], bits: int) -> NDArray[np.int64]:
    return numbers & (1 << bits) - 1


NO_MEMORIES = _merged(np.zeros((0, 5), np.int64), np.zeros(0, np.int64), np.zeros(0, np.int64), 0)
"""The memories of no imitators."""


def nearest_votes(
    memories: Memories,
    memory: int,
    query: Sequence[int],
    diagonal: int,
    votes: NDArray[np.int64],
    arithmetic: float = EXACT,
) -> tuple[int, int]:
    """Count the votes of all vectors of a memory at exactly the minimum distance from a query (4.6.1).

    Args:
        memories: Of all imitators.
        memory: Number of this imitator's memory; it is not empty.
        query: The state vector perceived.
        diagonal: Of the arena foraged in now, in pixels.
        votes: 0 for each label; gets the votes.
        arithmetic: The decision `distance_arithmetic` as a number. With floats, only vectors vote whose distance is
            the least as a sum of floats too.

    Returns:
        The minimum distance, exact and scaled as by `scaled_distance`, and the number of votes. Equal vectors count one
        by one.
    """
    presence, home, food_type, arm, food = query
    keys, first, last = memories.keys, memories.planes[memory], memories.planes[memory + 1]
    key = plane_key(presence, food_type, arm)
    category, arm_unit = scaled_distance(1, 0, 0, diagonal), scaled_distance(0, 1, 0, diagonal)
    sought = (home, food, diagonal, arithmetic)
    best = (2 * category + ARMS * arm_unit + 2 * DISTANCES * PIXEL, 0, 0.0)  # further than any vector
    # Planes of the same presence and food type: from the one with the query's arm outward, as far as the arm allows.
    here = bisect_left(keys, key, first, last)
    for plane in range(here, last):
        arm_difference = keys[plane] - key
        if arm_difference * arm_unit > best[0] or arm + arm_difference >= ARMS:
            break
        best = search_plane(memories, plane, 0, arm_difference, sought, best, votes)
    for plane in range(here - 1, first - 1, -1):
        arm_difference = key - keys[plane]
        if arm_difference * arm_unit > best[0] or arm_difference > arm:
            break
        best = search_plane(memories, plane, 0, arm_difference, sought, best, votes)
    if best[0] < category:
        return best[0], best[1]
    # All other planes differ in presence or food type.
    for plane in range(first, last):
        kind, other_arm = keys[plane] // ARMS, keys[plane] % ARMS
        differing = int(kind // FOOD_TYPES != presence) + int(kind % FOOD_TYPES != food_type)
        arm_difference = abs(other_arm - arm)
        if differing > 0 and differing * category + arm_difference * arm_unit <= best[0]:
            best = search_plane(memories, plane, differing, arm_difference, sought, best, votes)
    return best[0], best[1]


def search_plane(
    memories: Memories,
    plane: int,
    differing: int,
    arm_difference: int,
    sought: tuple[int, int, int, float],
    best: tuple[int, int, float],
    votes: NDArray[np.int64],
) -> tuple[int, int, float]:
    """Let the vectors of a plane vote, too; returns `best` now.

    They are searched outward from the query's home distance, first to larger ones, then to smaller ones, until the home
    distance alone is further away than the nearest vector so far. `differing` is how many of ObjectPresence and
    FoodType differ, and `sought` what else is known of the query: its RobotHomeDistance and RobotFoodDistance, the
    diagonal, and the arithmetic. `best` is the minimum distance so far, exact; the number of votes so far; and the
    minimum distance as a sum of floats, which means nothing with `EXACT`, or without votes.
    """
    home, food, diagonal, arithmetic = sought
    nearest, total, rounded = best
    _, _, vectors, homes, foods, labels, times = memories
    first, last = vectors[plane], vectors[plane + 1]
    base = scaled_distance(differing, arm_difference, 0, diagonal)
    reach = (nearest - base) // PIXEL  # pixels
    middle = bisect_left(homes, home, first, last)
    for step in (1, -1):
        vector = middle if step > 0 else middle - 1
        while first <= vector < last:
            across = abs(homes[vector] - home)
            along = abs(foods[vector] - food)
            if across > reach:
                break
            if across + along <= reach:
                distance = base + PIXEL * (across + along)
                if distance < nearest:
                    if total > 0:
                        clear(votes)
                    nearest, reach, total = distance, across + along, 0
                counts = True
                if arithmetic != EXACT:
                    own = rounded_distance(differing, arm_difference, across, along, diagonal, arithmetic)
                    counts = total == 0 or own <= rounded
                    if total > 0 and own < rounded:
                        clear(votes)
                        total = 0
                    rounded = own if counts else rounded
                if counts:
                    votes[labels[vector]] += times[vector]
                    total += times[vector]
            vector += step
    return nearest, total, rounded


def clear(votes: NDArray[np.int64]) -> None:
    """Set the votes of every label to 0."""
    for label in range(len(votes)):
        votes[label] = 0
