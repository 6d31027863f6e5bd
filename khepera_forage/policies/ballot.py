"""The imitator's vote as plain arithmetic over arrays (section 4.6), for many imitators at once.

It says what `NearestNeighbourImitator` says without a threshold: all experience vectors at exactly the minimum distance
vote, and a behaviour is drawn with its share of the votes. Distances are whole numbers, in units of
1 / (55 * diagonal), so that ties are exact. It runs in Python as it stands, and is compiled as it stands.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.policies.votes import ARM_SPAN
from khepera_forage.task.states import Behaviour

BEHAVIOURS = int(Behaviour.WAIT)
"""How many can be heard; WAIT is silence."""
_ARMS = 256
_BEYOND = 2**62


class Memories(NamedTuple):
    """What many imitators have learned: the distinct vectors of each with each behaviour heard, and how often.

    Vectors of equal ObjectPresence, FoodType and ArmsHeight are a plane, in which only the two distances in pixels are
    left to compare. Planes of a memory are in the order of their keys, vectors of a plane in that of the home distance.

    Attributes:
        planes: Number of each memory's first plane, and of all planes.
        keys: Of each plane, see `plane_key`.
        vectors: Number of each plane's first vector, and of all vectors.
        home: RobotHomeDistance of each vector, pixels.
        food: RobotFoodDistance of each vector, pixels.
        behaviour: Heard with it; a vector heard with two stands there twice.
        times: How often.
    """

    planes: NDArray[np.int64]
    keys: NDArray[np.int32]
    vectors: NDArray[np.int64]
    home: NDArray[np.int16]
    food: NDArray[np.int16]
    behaviour: NDArray[np.int8]
    times: NDArray[np.int32]


def plane_key(presence: int, food_type: int, arm: int) -> int:
    """The three attributes that are no distances in pixels, as one number."""
    return (presence * 4 + food_type) * _ARMS + arm


def vote(
    memories: Memories,
    memory: int,
    vector: tuple[int, int, int, int, int],
    diagonal: int,
    counts: NDArray[np.int64],
) -> int:
    """Let the nearest experience vectors of a memory vote (4.6.1).

    Args:
        memories: Of all imitators.
        memory: Number of this one's.
        vector: What it perceives, in the order of `StateVector`.
        diagonal: Of the arena foraged in now, pixels.
        counts: Gets the votes of each behaviour.

    Returns:
        How many vote; equal vectors count one by one.
    """
    presence, home, food_type, arm, food = vector
    first, last = memories.planes[memory], memories.planes[memory + 1]
    key = plane_key(presence, food_type, arm)
    kind = presence * 4 + food_type
    best, total = _BEYOND, 0
    # Of the planes of the same kind, first the one of the same arm, then outward for as long as the arm alone allows.
    here = first + _below(memories.keys[first:last], key)
    for plane in range(here, last):
        other = int(memories.keys[plane])
        offset = (other - key) * diagonal
        if other // _ARMS != kind or offset > best:
            break
        best, total = _poll(memories, plane, offset, home, food, best, total, counts)
    for plane in range(here - 1, first - 1, -1):
        other = int(memories.keys[plane])
        offset = (key - other) * diagonal
        if other // _ARMS != kind or offset > best:
            break
        best, total = _poll(memories, plane, offset, home, food, best, total, counts)
    if best < ARM_SPAN * diagonal:
        return total
    for plane in range(first, last):
        other = int(memories.keys[plane])
        if other // _ARMS != kind:
            differ = int(other // (4 * _ARMS) != presence) + int(other // _ARMS % 4 != food_type)
            offset = (differ * ARM_SPAN + abs(other % _ARMS - arm)) * diagonal
            if offset <= best:
                best, total = _poll(memories, plane, offset, home, food, best, total, counts)
    return total


def draw(counts: NDArray[np.int64], total: int, chance: float) -> int:
    """A behaviour, with its share of the votes as probability (4.6.2).

    Args:
        counts: Votes of each behaviour.
        total: Their sum, above 0.
        chance: A uniform number in 0..1.
    """
    left = chance * total
    drawn = 0
    for behaviour in range(BEHAVIOURS):
        if counts[behaviour] > 0:
            drawn = behaviour
            left -= counts[behaviour]
            if left < 0.0:
                break
    return drawn


def _poll(
    memories: Memories,
    plane: int,
    offset: int,
    home: int,
    food: int,
    best: int,
    total: int,
    counts: NDArray[np.int64],
) -> tuple[int, int]:
    """Let the vectors of a plane vote too; returns the least distance so far, and how many are that far."""
    first, last = memories.vectors[plane], memories.vectors[plane + 1]
    here = first + _below(memories.home[first:last], home)
    for side in range(2):
        k = here if side == 0 else here - 1
        while first <= k and k < last:
            across = offset + ARM_SPAN * abs(int(memories.home[k]) - home)
            if across > best:
                break
            away = across + ARM_SPAN * abs(int(memories.food[k]) - food)
            if away < best:
                best, total = away, 0
                for behaviour in range(BEHAVIOURS):
                    counts[behaviour] = 0
            if away == best:
                times = int(memories.times[k])
                counts[memories.behaviour[k]] += times
                total += times
            k += 1 if side == 0 else -1
    return best, total


def _below(values: NDArray[np.int16] | NDArray[np.int32], value: int) -> int:
    """How many of some sorted values are smaller; looking at all is faster than halving, several at a time."""
    smaller = 0
    for k in range(len(values)):
        smaller += int(values[k] < value)
    return smaller
