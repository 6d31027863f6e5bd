"""The learner of the recall phase: nearest neighbour with confidence levels (section 4.6)."""

import math
from fractions import Fraction
from itertools import compress
from numbers import Real
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike, NDArray
from sklearn.utils.validation import check_is_fitted, validate_data

from khepera_forage.policies.brute_force import ConfidenceClassifier, checked_classes
from khepera_forage.policies.distance import CORRIDOR_DIAGONAL, checked_diagonal
from khepera_forage.policies.index import NearestNeighbourIndex
from khepera_forage.policies.policy import Observation, state_vector_of
from khepera_forage.policies.votes import Neighbours
from khepera_forage.task.decisions import DEFAULT_DECISIONS, EXACT, FIELDS
from khepera_forage.task.states import Behaviour, StateVector

CACHE_SIZE = 32768
"""State vectors whose neighbours are cached, some 15 MB. A policy sees a few thousand distinct ones in a corridor."""


class _Cache(NamedTuple):
    """The neighbours of state vectors, and the parameters for which they hold."""

    diagonal: int | None
    threshold: float
    arithmetic: str
    parameters: tuple[int, Fraction, float]
    behaviours: list[Behaviour]
    found: dict[StateVector, Neighbours]


class NearestNeighbourImitator(ConfidenceClassifier):
    """Does what the teacher did in the most similar situation on record.

    The distance between two state vectors is the sum of five attribute distances (4.6.1): 1 each if ObjectPresence or
    FoodType differ, the difference of ArmsHeight by 55, those of RobotHomeDistance and RobotFoodDistance by the
    diagonal. All experience vectors at exactly the minimum distance vote; the share of a behaviour in the votes is its
    confidence level (4.6.2). `predict_proba` gives the confidence levels, `predict` the behaviour with the highest (of
    equals the first in `classes_`), and `act` draws a behaviour with its confidence level as probability, as the
    thesis's learner did.

    Distances between state vectors (whole numbers from 0; distances up to 8191 pixels) are compared as whole numbers,
    so that ties are exact. Anything else is compared in floats, vector by vector, which is slower. Rows of other than
    five columns are no state vectors: each of their columns counts as a distance in pixels. Equal experience vectors
    are merged into counts.

    The neighbours of single state vectors are cached, up to `CACHE_SIZE` of them. They follow from experience,
    parameters and state vector alone. The cache is emptied when experience or a parameter changes, and never pickled.

    Args:
        diagonal: Of the arena foraged in now, in pixels of 5 mm: an integer above 0; 138 in the corridor, 177
            in the rectangle. By default `recall` takes that of its environment, and everything else the corridor's. It
            can be changed after `fit`, with `set_params`.
        threshold: At least 0. Above 0 it is the variant that section 4.6.1 tried "with poor results": every
            vector within the minimum distance plus `threshold` votes. It is taken for the decimal number it
            is written as: 0.1 is one tenth. The thesis's wording allows another reading, in which vectors are
            appended to the list while the best is still being sought; its outcome depends on the order of the
            file, this one's does not.
        arithmetic: Of the distance between state vectors: "exact", "32-bit floats" or "64-bit floats", see the decision
            `distance_arithmetic`, whose default it has. A threshold needs "exact".

    Attributes:
        classes_: The labels seen, sorted.
        n_features_in_: Number of columns seen.
    """

    _index: NearestNeighbourIndex
    _cache: _Cache | None = None

    def __init__(
        self,
        diagonal: int | None = None,
        threshold: float = 0.0,
        arithmetic: str = DEFAULT_DECISIONS.distance_arithmetic,
    ) -> None:
        self.diagonal = diagonal
        self.threshold = threshold
        self.arithmetic = arithmetic

    def fit(self, X: ArrayLike, y: ArrayLike) -> Self:  # noqa: N803 - scikit-learn's name
        """Learn from experience vectors, forgetting earlier ones.

        Args:
            X: State vectors, one a row, attributes in the order of `StateVector`.
            y: The behaviour heard with each.

        Raises:
            ValueError: Parameters out of range, or data that is no classification problem.
        """
        return self._learn(X, y, None, forget=True)

    def partial_fit(
        self,
        X: ArrayLike,  # noqa: N803 - scikit-learn's name
        y: ArrayLike,
        classes: ArrayLike | None = None,
    ) -> Self:
        """Learn from further experience vectors: equal to `fit` on all of them together, in whatever order.

        Args:
            X: As for `fit`.
            y: As for `fit`.
            classes: All labels that may come. Unlike elsewhere in scikit-learn it need not be given:
                `classes_` grows by the labels that do come.

        Raises:
            ValueError: As for `fit`; or a label that is not among `classes`.
        """
        return self._learn(X, y, classes, forget=not hasattr(self, "classes_"))

    def predict_proba(self, X: ArrayLike) -> NDArray[np.float64]:  # noqa: N803
        """The confidence level of each class of `classes_`, one row for each row of `X`."""
        check_is_fitted(self)
        parameters = self._parameters()
        rows = validate_data(self, X, reset=False).tolist()
        votes = np.array([self._index.votes(row, *parameters)[2] for row in rows], np.float64)
        levels: NDArray[np.float64] = votes / votes.sum(axis=1, keepdims=True)
        return levels

    def act(self, observation: Observation, rng: Generator | None = None) -> Behaviour:
        """A behaviour, drawn with its confidence level as probability.

        Args:
            observation: What the robot perceives; see `policies.policy.state_vector_of`.
            rng: Must be given. One number is drawn at every call, conflict or not.

        Raises:
            TypeError: `rng` is not a NumPy generator.
            ValueError: The observation holds no state vector, or what was learned are not behaviours.
        """
        if not isinstance(rng, Generator):
            raise TypeError(f"rng is {rng!r}; allowed: a numpy.random.Generator to draw from (4.6.2)")
        return self.neighbours(observation).draw(rng)

    def confidence_levels(self, observation: Observation) -> dict[Behaviour, float]:
        """The confidence level of each behaviour that has one above 0 (4.6.2); they sum to 1."""
        return self.neighbours(observation).confidence_levels()

    def neighbours(self, observation: Observation) -> Neighbours:
        """Which experience votes on an observation: what `act` draws from, and where ties and conflicts show.

        Args:
            observation: What the robot perceives; see `policies.policy.state_vector_of`.

        Raises:
            ValueError: As for `act`.
        """
        cache = self._cache
        if cache is None or (cache.diagonal, cache.threshold, cache.arithmetic) != (
            self.diagonal,
            self.threshold,
            self.arithmetic,
        ):
            cache = self._cache = self._empty_cache()
        vector = state_vector_of(observation)
        found = cache.found.get(vector)
        if found is None:
            distance, total, votes = self._index.votes(vector, *cache.parameters)
            behaviours, counts = tuple(compress(cache.behaviours, votes)), tuple(filter(None, votes))
            found = Neighbours(behaviours, counts, total, distance)
            if len(cache.found) >= CACHE_SIZE:
                cache.found.clear()
            cache.found[vector] = found
        return found

    def _empty_cache(self) -> _Cache:
        check_is_fitted(self)
        if self.n_features_in_ != 5:
            raise ValueError(f"learned from rows of {self.n_features_in_} columns; allowed: 5, state vectors")
        try:
            behaviours = [Behaviour(label) for label in self.classes_.tolist()]
        except ValueError:
            raise ValueError(
                f"labels learned are {self.classes_.tolist()}; allowed: behaviours, 0 to {max(Behaviour):d}"
            ) from None
        return _Cache(self.diagonal, self.threshold, self.arithmetic, self._parameters(), behaviours, {})

    def _learn(self, X: ArrayLike, y: ArrayLike, classes: ArrayLike | None, *, forget: bool) -> Self:  # noqa: N803
        self._parameters()
        rows, labels = validate_data(self, X, y, reset=forget)
        allowed = checked_classes(labels, classes)
        self._cache = None
        if not forget:
            rows = np.concatenate((self._index.rows, rows))
            labels = np.concatenate((self.classes_[self._index.labels], labels))
            allowed = np.union1d(self.classes_, allowed)
        self.classes_ = allowed
        self._index = NearestNeighbourIndex(rows, np.searchsorted(allowed, labels), len(allowed))
        return self

    def _parameters(self) -> tuple[int, Fraction, float]:
        """The diagonal, the exact threshold and the arithmetic as a number, once they are found to be in range."""
        diagonal = checked_diagonal(CORRIDOR_DIAGONAL if self.diagonal is None else self.diagonal)
        threshold = self.threshold
        if not isinstance(threshold, Real) or not 0 <= threshold < math.inf:
            raise ValueError(f"threshold is {threshold!r}; allowed: a finite number, at least 0")
        decision = FIELDS["distance_arithmetic"]
        if self.arithmetic not in decision.choices:
            raise ValueError(f"arithmetic is {self.arithmetic!r}; allowed: {decision.allowed}")
        arithmetic = decision.as_number(self.arithmetic)
        if threshold and arithmetic != EXACT:
            raise ValueError(
                f"threshold is {threshold!r} with {self.arithmetic}; allowed: 0, or exact arithmetic"
            )
        return diagonal, Fraction(str(threshold)), arithmetic

    def __getstate__(self) -> dict[str, Any]:
        return {**super().__getstate__(), "_cache": None}
