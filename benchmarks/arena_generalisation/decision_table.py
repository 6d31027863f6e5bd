"""What many classifiers decide in many state vectors, each computed once."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.policies.nearest_neighbour.memories import ARMS, DISTANCES, FOOD_TYPES, PRESENCES
from khepera_forage.task.states import NUM_BEHAVIOURS, StateVector

_SIZES = StateVector(PRESENCES, DISTANCES, FOOD_TYPES, ARMS, DISTANCES)


class Decider(NamedTuple):
    """A classifier that decides in recalls.

    Attributes:
        classifier: Fitted, with `classes_` and `predict_proba`.
        sample: Whether behaviours are drawn with their probabilities; if not, the most probable one is executed.
        hold: Rounds that a behaviour holds.
    """

    classifier: Any
    sample: bool
    hold: int = 1

    def levels(self, vectors: NDArray[np.int64]) -> NDArray[np.float64]:
        """The probability of each of the ten behaviours in each state vector."""
        found = np.asarray(self.classifier.predict_proba(vectors), np.float64)
        levels = np.zeros((len(vectors), NUM_BEHAVIOURS))
        if self.sample:
            levels[:, self.classifier.classes_] = found
        else:
            levels[np.arange(len(vectors)), self.classifier.classes_[found.argmax(axis=1)]] = 1.0
        return levels


class DecisionTable:
    """The probabilities of behaviours, one row for each decider and state vector that has occurred.

    Args:
        deciders: They learn no further.
    """

    def __init__(self, deciders: Sequence[Decider]) -> None:
        self._deciders = deciders
        self.holds = np.array([decider.hold for decider in deciders], np.int64)
        """Rounds that a behaviour of each decider holds."""
        self._row_of: dict[int, int] = {}
        self._levels = np.zeros((1 << 12, NUM_BEHAVIOURS))
        self._visits = np.zeros(len(self._levels), np.int64)

    def decide(
        self, deciders: NDArray[np.int64], vectors: NDArray[np.int64], rng: np.random.Generator
    ) -> NDArray[np.int64]:
        """A behaviour for each world, drawn with its probability.

        Args:
            deciders: Number of each world's decider.
            vectors: State vectors, shape (worlds, 5).
            rng: Draws one number a world.
        """
        keys = _keys(deciders, vectors)
        rows = np.array([self._row_of.get(key, -1) for key in keys.tolist()], np.int64)
        if (rows < 0).any():
            self._add(np.unique(keys[rows < 0]))
            rows = np.array([self._row_of[key] for key in keys.tolist()], np.int64)
        np.add.at(self._visits, rows, 1)
        steps = self._levels[rows].cumsum(axis=1)
        drawn: NDArray[np.int64] = (steps <= rng.random((len(rows), 1)) * steps[:, -1:]).sum(axis=1)
        return drawn

    def visited(self, decider: int) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.int64]]:
        """The state vectors in which a decider has decided, its probabilities, and how often."""
        keys = np.array(list(self._row_of), np.int64)
        numbers, vectors = _unpacked(keys)
        own = np.flatnonzero(numbers == decider)  # rows are in the order of the keys
        return vectors[own], self._levels[own], self._visits[own]

    def _add(self, keys: NDArray[np.int64]) -> None:
        numbers, vectors = _unpacked(keys)
        first, last = len(self._row_of), len(self._row_of) + len(keys)
        while last > len(self._levels):
            self._levels = np.concatenate((self._levels, np.zeros_like(self._levels)))
            self._visits = np.concatenate((self._visits, np.zeros_like(self._visits)))
        self._row_of.update(zip(keys.tolist(), range(first, last), strict=True))
        for number in np.unique(numbers).tolist():
            own = numbers == number
            self._levels[first:last][own] = self._deciders[number].levels(vectors[own])


def _keys(numbers: NDArray[np.int64], vectors: NDArray[np.int64]) -> NDArray[np.int64]:
    """Decider and state vector as one number."""
    keys = numbers.copy()
    for column, size in enumerate(_SIZES):
        keys = keys * size + vectors[:, column]
    return keys


def _unpacked(keys: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The deciders and state vectors of keys."""
    columns = []
    for size in reversed(_SIZES):
        keys, column = np.divmod(keys, size)
        columns.append(column)
    return keys, np.stack(columns[::-1], axis=1)
