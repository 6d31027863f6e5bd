"""Who is nearest, what they vote for, and the draw (sections 4.6.1 and 4.6.2): each rule once.

Python runs these functions over lists, kernels compile them over arrays (`rollouts.compiled.nearest_neighbour`).
"""

from bisect import bisect_left
from collections.abc import MutableSequence, Sequence
from typing import Any

from numpy.typing import NDArray

from khepera_forage.policies.nearest_neighbour.distance import PIXEL, scaled_distance
from khepera_forage.policies.nearest_neighbour.memories import (
    ARMS,
    DISTANCES,
    FOOD_TYPES,
    FlatMemories,
    plane_key,
)

Votes = MutableSequence[int] | NDArray[Any]


def nearest_votes(
    memories: FlatMemories[Any], memory: int, query: Sequence[int], diagonal: int, votes: Votes
) -> tuple[int, int]:
    """Count the votes of all vectors of a memory at exactly the minimum distance from a query (4.6.1).

    Args:
        memories: Of all imitators.
        memory: Number of this imitator's memory; it is not empty.
        query: The state vector perceived.
        diagonal: Of the arena foraged in now, in pixels.
        votes: 0 for each label; gets the votes.

    Returns:
        The minimum distance, scaled as by `scaled_distance`, and the number of votes; equal vectors count one by one.
    """
    presence, home, food_type, arm, food = query
    keys, first, last = memories.keys, memories.planes[memory], memories.planes[memory + 1]
    key = plane_key(presence, food_type, arm)
    category, arm_unit = scaled_distance(1, 0, 0, diagonal), scaled_distance(0, 1, 0, diagonal)
    nearest, total = 2 * category + ARMS * arm_unit + 2 * DISTANCES * PIXEL, 0  # further than any vector
    # Planes of the same presence and food type: from the one with the query's arm outward, as far as the arm allows.
    here = bisect_left(keys, key, first, last)
    for plane in range(here, last):
        arm_difference = keys[plane] - key
        base = arm_difference * arm_unit
        if base > nearest or arm + arm_difference >= ARMS:
            break
        nearest, total = search_plane(memories, plane, base, home, food, nearest, total, votes)
    for plane in range(here - 1, first - 1, -1):
        arm_difference = key - keys[plane]
        base = arm_difference * arm_unit
        if base > nearest or arm_difference > arm:
            break
        nearest, total = search_plane(memories, plane, base, home, food, nearest, total, votes)
    if nearest < category:
        return nearest, total
    # All other planes differ in presence or food type.
    for plane in range(first, last):
        kind, other_arm = keys[plane] // ARMS, keys[plane] % ARMS
        differing = int(kind // FOOD_TYPES != presence) + int(kind % FOOD_TYPES != food_type)
        base = differing * category + abs(other_arm - arm) * arm_unit
        if differing > 0 and base <= nearest:
            nearest, total = search_plane(memories, plane, base, home, food, nearest, total, votes)
    return nearest, total


def search_plane(
    memories: FlatMemories[Any],
    plane: int,
    base: int,
    home: int,
    food: int,
    nearest: int,
    total: int,
    votes: Votes,
) -> tuple[int, int]:
    """Let the vectors of a plane vote, too.

    Columns are searched outward from the query's own, first to larger home distances, then to smaller ones, until a
    column alone is further away than the nearest vector so far. So are the vectors of a column.

    Args:
        memories: Of all imitators.
        plane: Number of the plane.
        base: What the attributes that the plane's vectors share contribute to the distance.
        home: RobotHomeDistance of the query, in pixels.
        food: RobotFoodDistance of the query, in pixels.
        nearest: The minimum distance so far, at least `base`.
        total: The number of votes so far.
        votes: The votes so far.

    Returns:
        The minimum distance and the number of votes now.
    """
    _, _, columns, homes, starts, foods, labels, times = memories
    first, last = columns[plane], columns[plane + 1]
    reach = (nearest - base) // PIXEL  # pixels
    middle = bisect_left(homes, home, first, last)
    for step in (1, -1):
        column = middle if step > 0 else middle - 1
        while first <= column < last:
            across = (homes[column] - home) * step
            if across > reach:
                break
            begin, end = starts[column], starts[column + 1]
            above = vector = bisect_left(foods, food, begin, end)
            while vector < end:
                pixels = across + foods[vector] - food
                if pixels > reach:
                    break
                if base + PIXEL * pixels < nearest:
                    if total > 0:
                        clear(votes)
                    nearest, reach, total = base + PIXEL * pixels, pixels, 0
                count = times[vector]
                votes[labels[vector]] += count
                total += count
                vector += 1
            vector = above - 1
            while vector >= begin:
                pixels = across + food - foods[vector]
                if pixels > reach:
                    break
                if base + PIXEL * pixels < nearest:
                    if total > 0:
                        clear(votes)
                    nearest, reach, total = base + PIXEL * pixels, pixels, 0
                count = times[vector]
                votes[labels[vector]] += count
                total += count
                vector -= 1
            column += step
    return nearest, total


def clear(votes: Votes) -> None:
    """Set the votes of every label to 0."""
    for label in range(len(votes)):
        votes[label] = 0


def draw_label(votes: Sequence[int] | NDArray[Any], total: int, chance: float) -> int:
    """A label, drawn with its share of the votes as probability (4.6.2).

    Args:
        votes: Of each label.
        total: Their sum, above 0.
        chance: A uniform number in 0..1, 1 excluded.
    """
    left = chance * total
    drawn = 0
    for label, count in enumerate(votes):
        if count > 0:
            drawn = label
            left -= count
            if left < 0.0:
                break
    return drawn
