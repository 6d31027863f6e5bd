"""An index of experience vectors."""

from collections.abc import Sequence
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.policies.brute_force import DistinctVectors, distinct_vectors
from khepera_forage.policies.distance import ARM_SPAN, STATE_WIDTH, attribute_distances, unit
from khepera_forage.policies.memories import (
    ARMS,
    DISTANCES,
    FOOD_TYPES,
    PRESENCES,
    SIZES,
    FlatMemories,
    ListMemory,
    merged,
)
from khepera_forage.policies.votes import nearest_votes
from khepera_forage.task.decisions import EXACT
from khepera_forage.task.states import StateVector

_LARGEST_REACH = 2**1000


class NearestNeighbourIndex:
    """Experience vectors with their labels; finds the votes of the nearest ones.

    State vectors within `memories.SIZES` are kept in a memory, which `nearest_votes` searches. If there is any other
    vector, every query is compared with all vectors, in floats; so is a query outside `SIZES`, or one with a threshold.

    Args:
        rows: One vector a row.
        labels: The label of each vector, from 0.
        classes: How many labels there are.

    Attributes:
        rows: See above.
        labels: See above.
    """

    def __init__(self, rows: NDArray[np.float64], labels: NDArray[np.intp], classes: int) -> None:
        self.rows, self.labels, self.classes = rows, labels, classes

    @cached_property
    def memory(self) -> ListMemory | None:
        """The vectors, sorted; None if they are no state vectors."""
        rows = self.rows
        if rows.shape[1] != STATE_WIDTH or not ((rows >= 0) & (rows < SIZES) & (rows % 1 == 0)).all():
            return None
        return FlatMemories(*(values.tolist() for values in merged(rows.astype(np.int64), self.labels)))

    @cached_property
    def distinct(self) -> DistinctVectors:
        """The vectors, to be compared one by one."""
        return distinct_vectors(self.rows, self.labels, self.classes)

    def votes(
        self, query: Sequence[float], diagonal: int, threshold: Fraction, arithmetic: float = EXACT
    ) -> tuple[float, int, list[int]]:
        """The votes of all vectors within the minimum distance plus a threshold; there must be a vector.

        Args:
            query: A vector.
            diagonal: Of the arena foraged in now, in pixels.
            threshold: At least 0.
            arithmetic: Of the distance between state vectors, as for `nearest_votes`.

        Returns:
            The minimum distance, the number of votes, and the votes of each label.
        """
        vector = whole_state_vector(query)
        if self.memory is None or vector is None or threshold:
            return self._votes_of_all(query, diagonal, threshold, whole=vector is not None)
        votes = [0] * self.classes
        nearest, total = nearest_votes(self.memory, 0, vector, diagonal, votes, arithmetic)
        return nearest / (ARM_SPAN * diagonal), total, votes

    def _votes_of_all(
        self, query: Sequence[float], diagonal: int, threshold: Fraction, *, whole: bool
    ) -> tuple[float, int, list[int]]:
        vectors = self.distinct
        distances = attribute_distances(vectors.rows, query, diagonal).sum(axis=1)
        nearest, units = float(distances.min()), unit(self.rows.shape[1], diagonal)
        reach = min(threshold * units, Fraction(_LARGEST_REACH))
        if self.memory is not None and whole:
            reach = Fraction(int(reach))  # no distance lies between two whole numbers
        votes: list[int] = vectors.votes[distances <= nearest + float(reach)].sum(axis=0).tolist()
        return nearest / units, sum(votes), votes

    def __getstate__(self) -> dict[str, Any]:
        return {name: self.__dict__[name] for name in ("rows", "labels", "classes")}


def whole_state_vector(values: Sequence[float]) -> StateVector | None:
    """The state vector that numbers are, if they are one that a memory can hold."""
    if len(values) != STATE_WIDTH:
        return None
    presence, home, food_type, arm, food = values
    if not (
        0 <= home < DISTANCES
        and 0 <= food < DISTANCES
        and 0 <= presence < PRESENCES
        and 0 <= food_type < FOOD_TYPES
        and 0 <= arm < ARMS
    ):
        return None
    if type(values) is StateVector:
        return values
    whole = StateVector(int(presence), int(home), int(food_type), int(arm), int(food))
    return whole if whole == tuple(values) else None
