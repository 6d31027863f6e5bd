"""Who is nearest, what they vote for, and the draw (sections 4.6.1 and 4.6.2): each rule once.

Python runs these functions over lists, kernels compile them over arrays (`rollouts.compiled.imitators`).
"""

from bisect import bisect_left
from collections.abc import MutableSequence, Sequence
from typing import Any, NamedTuple, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from khepera_forage.policies.distance import PIXEL, rounded_distance, scaled_distance
from khepera_forage.policies.memories import ARMS, DISTANCES, FOOD_TYPES, FlatMemories, plane_key
from khepera_forage.policies.policy import Observation
from khepera_forage.task.decisions import EXACT
from khepera_forage.task.states import Behaviour

Votes = MutableSequence[int] | NDArray[Any]


def nearest_votes(
    memories: FlatMemories[Any],
    memory: int,
    query: Sequence[int],
    diagonal: int,
    votes: Votes,
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
    memories: FlatMemories[Any],
    plane: int,
    differing: int,
    arm_difference: int,
    sought: tuple[int, int, int, float],
    best: tuple[int, int, float],
    votes: Votes,
) -> tuple[int, int, float]:
    """Let the vectors of a plane vote, too.

    Columns are searched outward from the query's own, first to larger home distances, then to smaller ones, until a
    column alone is further away than the nearest vector so far. So are the vectors of a column.

    Args:
        memories: Of all imitators.
        plane: Number of the plane.
        differing: How many of ObjectPresence and FoodType differ between the plane and the query.
        arm_difference: The difference of ArmsHeight between them.
        sought: RobotHomeDistance and RobotFoodDistance of the query, the diagonal, and the arithmetic.
        best: The minimum distance so far, exact; the number of votes so far; and the minimum distance as a sum of
            floats, which means nothing with `EXACT`, or without votes.
        votes: The votes so far.

    Returns:
        `best` now.
    """
    home, food, diagonal, arithmetic = sought
    nearest, total, rounded = best
    _, _, columns, homes, starts, foods, labels, times = memories
    first, last = columns[plane], columns[plane + 1]
    base = scaled_distance(differing, arm_difference, 0, diagonal)
    reach = (nearest - base) // PIXEL  # pixels
    middle = bisect_left(homes, home, first, last)
    for step in (1, -1):
        column = middle if step > 0 else middle - 1
        while first <= column < last:
            across = (homes[column] - home) * step
            if across > reach:
                break
            begin, end = starts[column], starts[column + 1]
            above = bisect_left(foods, food, begin, end)
            for side in (1, -1):
                vector = above if side > 0 else above - 1
                while begin <= vector < end:
                    along = (foods[vector] - food) * side
                    if across + along > reach:
                        break
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
                    vector += side
            column += step
    return nearest, total, rounded


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


class Neighbours(NamedTuple):
    """The experience vectors at the minimum distance from a state vector (with a threshold: near it).

    Attributes:
        behaviours: The behaviours heard with them, in increasing order.
        counts: How many of the vectors vote for each of these behaviours, above 0.
        tied: How many vectors vote; equal vectors count one by one.
        distance: The minimum distance of section 4.6.1.
    """

    behaviours: tuple[Behaviour, ...]
    counts: tuple[int, ...]
    tied: int
    distance: float

    @property
    def votes(self) -> tuple[tuple[Behaviour, int], ...]:
        """Each behaviour with the number of its votes."""
        return tuple(zip(self.behaviours, self.counts, strict=True))

    @property
    def tie(self) -> bool:
        """Whether more than one experience vector votes."""
        return self.tied > 1

    @property
    def conflict(self) -> bool:
        """Whether they vote for more than one behaviour."""
        return len(self.behaviours) > 1

    def confidence_levels(self) -> dict[Behaviour, float]:
        """The share of each behaviour in the votes; the shares sum to 1."""
        return {behaviour: count / self.tied for behaviour, count in self.votes}

    def draw(self, rng: np.random.Generator) -> Behaviour:
        """A behaviour, with its confidence level as probability. Draws exactly one number from `rng`."""
        return self.behaviours[draw_label(self.counts, self.tied, rng.random())]


@runtime_checkable
class HasNeighbours(Protocol):
    """A policy that draws its behaviours from the votes of neighbours, such as `NearestNeighbourImitator`."""

    def neighbours(self, observation: Observation) -> Neighbours:
        """The experience vectors that vote on an observation."""
        ...
