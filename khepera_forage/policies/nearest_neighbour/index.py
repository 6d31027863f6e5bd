"""An index of experience vectors that grows vector by vector."""

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from khepera_forage.policies.nearest_neighbour.brute_force import DistinctVectors, distinct_vectors
from khepera_forage.policies.nearest_neighbour.distance import (
    ARM_SPAN,
    STATE_WIDTH,
    attribute_distances,
    unit,
)
from khepera_forage.policies.nearest_neighbour.growth import empty_memory, insert
from khepera_forage.policies.nearest_neighbour.memories import (
    ARMS,
    DISTANCES,
    FOOD_TYPES,
    PRESENCES,
    SIZES,
    FlatMemories,
    ListMemory,
    merged,
    unpacked,
)
from khepera_forage.policies.nearest_neighbour.votes import nearest_votes
from khepera_forage.task.decisions import EXACT
from khepera_forage.task.states import StateVector

FEW = 200
"""Rows up to which inserting them one by one is faster than merging them first."""
_LARGEST_REACH = 2**1000


class NearestNeighbourIndex:
    """Experience vectors with their labels; finds the votes of the nearest ones.

    State vectors within `memories.SIZES` are kept in a memory, which `nearest_votes` searches. Once any other vector is
    added, every query is compared with all vectors, in floats; so is a query outside `SIZES`, or one with a threshold.

    Args:
        width: Columns of a vector.
        classes: How many labels there are.
    """

    def __init__(self, width: int, classes: int) -> None:
        self.width, self.classes = width, classes
        self.memory: ListMemory | None = None
        self._distinct: DistinctVectors | None = None
        if width == STATE_WIDTH:
            self.memory = empty_memory()
        else:
            self._distinct = DistinctVectors(np.zeros((0, width)), np.zeros((0, classes), np.int64))

    def add(self, rows: NDArray[Any], labels: NDArray[np.int64]) -> None:
        """Add vectors.

        Args:
            rows: One vector a row.
            labels: The label of each vector, from 0.
        """
        if self.memory is None or not are_state_vectors(rows):
            known, known_labels, times = self.distinct_vectors().unpacked()
            self.memory = None
            self._distinct = distinct_vectors(
                np.concatenate((known, rows)),
                np.concatenate((known_labels, labels)),
                self.classes,
                np.concatenate((times, np.ones(len(rows), np.int64))),
            )
            return
        self._distinct = None
        rows = rows.astype(np.int64)
        if not self.memory.food:
            self.memory = FlatMemories(*(values.tolist() for values in merged(rows, labels)))
            return
        times = np.ones(len(rows), np.int64)
        if len(rows) > FEW:
            rows, labels, times = unpacked(merged(rows, labels))
        for row, label, count in zip(rows.tolist(), labels.tolist(), times.tolist(), strict=True):
            insert(self.memory, row, label, count)

    def relabel(self, labels: Sequence[int], classes: int) -> None:
        """Change the number of labels to `classes`; label `i` becomes `labels[i]`, in the same order."""
        self.classes = classes
        if self.memory is not None:
            self.memory.label[:] = [labels[label] for label in self.memory.label]
            self._distinct = None
        else:
            rows, known = self.distinct_vectors()
            votes = np.zeros((len(rows), classes), np.int64)
            votes[:, labels] = known
            self._distinct = DistinctVectors(rows, votes)

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

    def distinct_vectors(self) -> DistinctVectors:
        """The vectors, to be compared one by one."""
        if self._distinct is None:
            assert self.memory is not None
            rows, labels, times = unpacked(self.memory)
            self._distinct = distinct_vectors(rows, labels, self.classes, times)
        return self._distinct

    def _votes_of_all(
        self, query: Sequence[float], diagonal: int, threshold: Fraction, *, whole: bool
    ) -> tuple[float, int, list[int]]:
        vectors = self.distinct_vectors()
        distances = attribute_distances(vectors.rows, query, diagonal).sum(axis=1)
        nearest, units = float(distances.min()), unit(self.width, diagonal)
        reach = min(threshold * units, Fraction(_LARGEST_REACH))
        if self.memory is not None and whole:
            reach = Fraction(int(reach))  # no distance lies between two whole numbers
        votes: list[int] = vectors.votes[distances <= nearest + float(reach)].sum(axis=0).tolist()
        return nearest / units, sum(votes), votes

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ if self.memory is None else {**self.__dict__, "_distinct": None}


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


def are_state_vectors(rows: NDArray[Any]) -> bool:
    """Whether every row is a state vector that a memory can hold."""
    return rows.shape[1] == STATE_WIDTH and bool(((rows >= 0) & (rows < SIZES) & (rows % 1 == 0)).all())
