"""The learner of the recall phase, nearest neighbour with confidence levels (section 4.6), and two variants of it."""

import math
from collections.abc import Sequence
from fractions import Fraction
from numbers import Integral, Real
from typing import Any, Self

import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, ClassifierMixin
from sklearn.utils import check_random_state
from sklearn.utils.multiclass import check_classification_targets
from sklearn.utils.validation import check_is_fitted, validate_data

from khepera_forage.policies.distance import (
    CORRIDOR_DIAGONAL,
    STATE_WIDTH,
    attribute_distances,
    checked_diagonal,
    rounded_distance,
    unit,
)
from khepera_forage.policies.policy import (
    Neighbours,
    Observation,
    behaviours_of,
    checked_generator,
    remembered,
    state_vector_of,
)
from khepera_forage.task.decisions import DEFAULT_DECISIONS, EXACT, FIELDS
from khepera_forage.task.states import Behaviour


class ConfidenceClassifier(ClassifierMixin, BaseEstimator):  # type: ignore[misc]  # scikit-learn is untyped
    """A classifier whose vectors vote, and whose `predict_proba` gives confidence levels (4.6.2).

    It compares a query with every distinct vector of its experience; a subclass says which of them vote.
    """

    classes_: NDArray[Any]
    n_features_in_: int
    _rows: NDArray[np.float64]
    votes_: NDArray[np.int64]
    """How often each of the rows was heard with each class."""
    diagonal: int | None

    def fit(self, X: ArrayLike, y: ArrayLike) -> Self:
        """Learn from experience vectors, forgetting earlier ones.

        Args:
            X: State vectors, one a row, attributes in the order of `StateVector`.
            y: The behaviour heard with each.

        Raises:
            ValueError: Parameters out of range, or data that is no classification problem.
        """
        self._learn(X, y)
        return self

    def predict_proba(self, X: ArrayLike) -> NDArray[np.float64]:
        """The confidence level of each class of `classes_`, one row for each row of `X`."""
        check_is_fitted(self)
        self._check()
        queries = validate_data(self, X, reset=False, dtype=np.float64)
        shares = np.array([self._shares(query) for query in queries])
        levels: NDArray[np.float64] = shares / shares.sum(axis=1, keepdims=True)
        return levels

    def predict(self, X: ArrayLike) -> NDArray[Any]:
        """The class with the highest confidence level, for each row of `X`; of equals the first."""
        best = self.predict_proba(X).argmax(axis=1)
        labels: NDArray[Any] = self.classes_[best]
        return labels

    def _learn(
        self, X: ArrayLike, y: ArrayLike, classes: ArrayLike | None = None, *, forget: bool = True
    ) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
        """Check the data and add them; returns the rows, and the code of the class of each."""
        self._check()
        rows, labels = validate_data(self, X, y, reset=forget, dtype=np.float64)
        check_classification_targets(labels)
        seen = np.unique(labels)
        allowed = seen if classes is None else np.unique(classes)
        if not np.isin(seen, allowed).all():
            raise ValueError(f"labels are {seen.tolist()}; allowed: those among classes, {allowed.tolist()}")
        if forget:
            self.classes_ = allowed
            self.votes_ = np.zeros((0, len(allowed)), np.int64)
        else:
            known, self.classes_ = self.classes_, np.union1d(self.classes_, allowed)
            votes = np.zeros((len(self.votes_), len(self.classes_)), np.int64)
            votes[:, np.searchsorted(self.classes_, known)] = self.votes_
            self.votes_ = votes
        codes = np.searchsorted(self.classes_, labels)
        self._add(rows, codes)
        return rows, codes

    def _check(self) -> None:
        """Check the parameters."""
        checked_diagonal(self._diagonal)

    @property
    def _diagonal(self) -> int:
        return CORRIDOR_DIAGONAL if self.diagonal is None else self.diagonal

    def _shares(self, query: NDArray[np.float64]) -> NDArray[Any]:
        """The share of each class in the votes on a query, in any unit."""
        raise NotImplementedError

    def _add(self, rows: NDArray[np.float64], codes: NDArray[np.intp]) -> None:
        if len(self.votes_):
            rows = np.concatenate((self._rows, rows))
        votes = np.concatenate((self.votes_, np.eye(len(self.classes_), dtype=np.int64)[codes]))
        self._rows, places = np.unique(rows, axis=0, return_inverse=True)
        self.votes_ = np.zeros((len(self._rows), len(self.classes_)), np.int64)
        np.add.at(self.votes_, places.ravel(), votes)

    def _distances(self, query: Any) -> NDArray[np.float64]:
        """What each attribute contributes to the distance of each vector from a query."""
        return attribute_distances(self._rows, query, self._diagonal)


class NearestNeighbourImitator(ConfidenceClassifier):
    """Does what the teacher did in the most similar situation on record.

    The distance between two state vectors is the sum of five attribute distances (4.6.1): 1 each if ObjectPresence or
    FoodType differ, the difference of ArmsHeight by 55, those of RobotHomeDistance and RobotFoodDistance by the
    diagonal. All experience vectors at exactly the minimum distance vote; the share of a behaviour in the votes is its
    confidence level (4.6.2). `predict_proba` gives the confidence levels, `predict` the behaviour with the highest (of
    equals the first in `classes_`), and `act` draws a behaviour with its confidence level as probability, as the
    thesis's learner did.

    Distances between state vectors are whole numbers times 1 / (55 * diagonal), so that ties are exact. Rows of other
    than five columns are no state vectors: each of their columns counts as a distance in pixels. Equal experience
    vectors are merged into counts.

    The neighbours of single state vectors are cached, and never pickled.

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

    def __init__(
        self,
        diagonal: int | None = None,
        threshold: float = 0.0,
        arithmetic: str = DEFAULT_DECISIONS.distance_arithmetic,
    ) -> None:
        self.diagonal = diagonal
        self.threshold = threshold
        self.arithmetic = arithmetic

    def partial_fit(self, X: ArrayLike, y: ArrayLike, classes: ArrayLike | None = None) -> Self:
        """Learn from further experience vectors: equal to `fit` on all of them together, in whatever order.

        Args:
            X: As for `fit`.
            y: As for `fit`; among `classes`, if these are given.
            classes: All labels that may come. Unlike elsewhere in scikit-learn it need not be given:
                `classes_` grows by the labels that do come.
        """
        self._learn(X, y, classes, forget=not hasattr(self, "classes_"))
        return self

    def act(self, observation: Observation, rng: Generator | None = None) -> Behaviour:
        """A behaviour, drawn with its confidence level as probability: one number from `rng` at every call."""
        rng = checked_generator(rng)
        return self.neighbours(observation).draw(rng)

    def confidence_levels(self, observation: Observation) -> dict[Behaviour, float]:
        """The confidence level of each behaviour that has one above 0 (4.6.2); they sum to 1."""
        return self.neighbours(observation).confidence_levels()

    def neighbours(self, observation: Observation) -> Neighbours:
        """Which experience votes on an observation: what `act` draws from, and where ties and conflicts show."""
        vector = state_vector_of(observation)
        cache = self.__dict__.setdefault("_cache", {})
        key = vector, self.diagonal, self.threshold, self.arithmetic
        found: Neighbours = remembered(cache, key, lambda: self._neighbours(vector))
        return found

    def _neighbours(self, vector: Sequence[int]) -> Neighbours:
        check_is_fitted(self)
        self._check()
        if self.n_features_in_ != STATE_WIDTH:
            raise ValueError(f"learned from rows of {self.n_features_in_} columns; allowed: 5, state vectors")
        behaviours = behaviours_of(self.classes_)
        nearest, shares = self._nearest(vector)
        counts = shares.tolist()
        voted = tuple(behaviour for behaviour, count in zip(behaviours, counts, strict=True) if count)
        return Neighbours(voted, tuple(filter(None, counts)), sum(counts), nearest)

    def _shares(self, query: NDArray[np.float64]) -> NDArray[Any]:
        return self._nearest(query)[1]

    def _nearest(self, query: Any) -> tuple[float, NDArray[np.int64]]:
        """The minimum distance from a query, and the votes for each class of all vectors at it (4.6.1)."""
        distances = self._distances(query).sum(axis=1)
        nearest, scale = distances.min(), unit(self.n_features_in_, self._diagonal)
        chosen = distances == nearest
        if self.threshold:
            reach = Fraction(str(self.threshold)) * scale
            chosen = np.array([further <= reach for further in (distances - nearest).tolist()])
        elif self.arithmetic != "exact" and self.n_features_in_ == STATE_WIDTH:
            (chosen,) = np.nonzero(chosen)
            presence, home, food_type, arm, food = np.abs(self._rows[chosen] - query).T
            differing = np.sign(presence) + np.sign(food_type)
            arithmetic = FIELDS["distance_arithmetic"].as_number(self.arithmetic)
            sums = rounded_distance(differing, arm, home, food, self._diagonal, arithmetic)
            chosen = chosen[sums == sums.min()]
        votes: NDArray[np.int64] = self.votes_[chosen].sum(axis=0)
        return float(nearest / scale), votes

    def _add(self, rows: NDArray[np.float64], codes: NDArray[np.intp]) -> None:
        super()._add(rows, codes)
        self._cache: dict[Any, Neighbours] = {}

    def _check(self) -> None:
        super()._check()
        if not isinstance(self.threshold, Real) or not 0 <= self.threshold < math.inf:
            raise ValueError(f"threshold is {self.threshold!r}; allowed: a finite number, at least 0")
        decision = FIELDS["distance_arithmetic"]
        if self.arithmetic not in decision.choices:
            raise ValueError(f"arithmetic is {self.arithmetic!r}; allowed: {decision.allowed}")
        if self.threshold and decision.as_number(self.arithmetic) != EXACT:
            raise ValueError(f"threshold is {self.threshold!r} with {self.arithmetic}; allowed: 0, or exact arithmetic")

    def __getstate__(self) -> dict[str, Any]:
        return {**super().__getstate__(), "_cache": {}}


WEIGHTINGS = ("uniform", "distance")


class KNearestImitator(ConfidenceClassifier):
    """The `k` nearest experience vectors vote, by the distance of section 4.6.1.

    Vectors at the same distance as the `k`-th also vote, so that the result does not depend on the order of the
    experience. With `k` 1 this is the thesis's imitator.

    Args:
        k: Vectors that vote, at least 1; if there are fewer, all vote.
        weighting: `uniform`, one vote each, or `distance`: votes count by the inverse of the distance, and if some
            vectors equal the query, only these vote.
        diagonal: As of `NearestNeighbourImitator`.

    Attributes:
        classes_: The labels seen, sorted.
        n_features_in_: Number of columns seen.
    """

    def __init__(self, k: int = 5, weighting: str = "uniform", diagonal: int | None = None) -> None:
        self.k = k
        self.weighting = weighting
        self.diagonal = diagonal

    def _shares(self, query: NDArray[np.float64]) -> NDArray[Any]:
        away = self._distances(query).sum(axis=1)
        order = away.argsort(kind="stable")
        reached = self.votes_.sum(axis=1)[order].cumsum()
        last = min(int(reached.searchsorted(self.k)), len(order) - 1)
        chosen = away <= away[order[last]]
        near = away[chosen]
        weights = np.ones(len(near))
        if self.weighting == "distance":
            weights = (near == 0) * 1.0 if near.min() == 0 else near.min() / near
        shares: NDArray[np.float64] = (self.votes_[chosen] * weights[:, None]).sum(axis=0)
        return shares

    def _check(self) -> None:
        super()._check()
        if not isinstance(self.k, Integral) or isinstance(self.k, bool) or self.k < 1:
            raise ValueError(f"k is {self.k!r}; allowed: an integer, at least 1")
        if self.weighting not in WEIGHTINGS:
            raise ValueError(f"weighting is {self.weighting!r}; allowed: {', '.join(WEIGHTINGS)}")


CHOICES = (0, 1, 2, 3, 4, 6, 8, 12, 16)
SWEEPS = 20
"""Most passes over all attributes; the search ends when a pass changes nothing, mostly after three."""


class WeightedImitator(ConfidenceClassifier):
    """The nearest vectors vote, by a distance whose attributes count with different weights.

    "The more significant attributes should be weighted more" (5.5). The weights learned are those with the least
    leave-one-out error of the imitator: each vector in turn is the query, the others vote, and the error is the share
    of the votes for other behaviours than the one heard. This is the probability with which a learner that draws
    behaviours (4.6.2) is wrong. The search changes one attribute at a time, from equal weights: the error is a step
    function without a gradient, and there are only five attributes. Weights are whole numbers, which keeps ties exact.
    Vectors of one episode are alike; with `groups`, all vectors of the query's episode are left out.

    Args:
        diagonal: As of `NearestNeighbourImitator`.
        weights: One whole number for each column, at least 0 and not all 0; learned by default.
        choices: The weights that the search tries.
        search_size: Most vectors that the search compares; with more, this many are drawn.
        random_state: Of that draw.

    Attributes:
        classes_: The labels seen, sorted.
        n_features_in_: Number of columns seen.
        weights_: The weight of each column.
        error_: Leave-one-out error with these weights, 0..1; missing if `weights` are given.
        plain_error_: The same with equal weights.
    """

    weights_: tuple[int, ...]
    error_: float
    plain_error_: float

    def __init__(
        self,
        diagonal: int | None = None,
        weights: Sequence[int] | None = None,
        choices: Sequence[int] = CHOICES,
        search_size: int = 600,
        random_state: Any = None,
    ) -> None:
        self.diagonal = diagonal
        self.weights = weights
        self.choices = choices
        self.search_size = search_size
        self.random_state = random_state

    def fit(self, X: ArrayLike, y: ArrayLike, groups: ArrayLike | None = None) -> Self:
        """Learn from experience vectors, forgetting earlier ones.

        Args:
            X: State vectors, one a row, attributes in the order of `StateVector`.
            y: The behaviour heard with each.
            groups: The training episode of each vector; by default each vector is its own group.

        Raises:
            ValueError: Parameters out of range, data that is no classification problem, or groups of another length.
        """
        rows, codes = self._learn(X, y)
        if self.weights is not None:
            self.weights_ = self._whole("weights", self.weights)
            if len(self.weights_) != rows.shape[1] or not any(self.weights_):
                raise ValueError(f"weights are {self.weights_}; allowed: {rows.shape[1]} whole numbers, not all 0")
            return self
        own = np.arange(len(rows)) if groups is None else np.asarray(groups)
        if own.shape != codes.shape:
            raise ValueError(f"groups have shape {own.shape}; allowed: {codes.shape}, one for each vector")
        if len(rows) > self.search_size:
            chosen = check_random_state(self.random_state).choice(len(rows), self.search_size, replace=False)
            rows, codes, own = rows[chosen], codes[chosen], own[chosen]
        self._search(rows, codes, own)
        return self

    def _shares(self, query: NDArray[np.float64]) -> NDArray[Any]:
        weighted = self._distances(query) @ np.array(self.weights_, np.float64)
        shares: NDArray[np.int64] = self.votes_[weighted == weighted.min()].sum(axis=0)
        return shares

    def _search(self, rows: NDArray[np.float64], codes: NDArray[np.intp], own: NDArray[Any]) -> None:
        choices = self._whole("choices", self.choices)
        pairs = np.stack([attribute_distances(rows, row, self._diagonal) for row in rows])
        same, out = codes[:, None] == codes, own[:, None] == own
        queries = ~out.all(axis=1)  # those that have vectors to vote on them

        def error(weights: list[int]) -> float:
            distances = pairs @ np.array(weights, np.float64)
            distances[out] = np.inf
            voters = (distances == distances.min(axis=1, keepdims=True))[queries] & ~out[queries]
            right = (voters & same[queries]).sum(axis=1) / voters.sum(axis=1)
            return float(1 - right.mean()) if queries.any() else 0.0

        weights = [1] * rows.shape[1]
        self.plain_error_ = best = error(weights)
        for _ in range(SWEEPS):
            before = list(weights)
            for column in range(len(weights)):
                for choice in choices:
                    tried = [*weights[:column], choice, *weights[column + 1 :]]
                    if any(tried) and (found := error(tried)) < best - 1e-12:  # rounding is no improvement
                        best, weights = found, tried
            if weights == before:
                break
        self.weights_, self.error_ = tuple(weights), best

    @staticmethod
    def _whole(name: str, values: Sequence[int]) -> tuple[int, ...]:
        whole = tuple(int(value) for value in values)
        if any(value < 0 or value != given for value, given in zip(whole, values, strict=True)):
            raise ValueError(f"{name} are {tuple(values)}; allowed: whole numbers, at least 0")
        return whole
