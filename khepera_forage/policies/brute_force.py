"""Learners that compare a query with every vector: votes of the k nearest, and learned weights of attributes."""

from collections.abc import Sequence
from numbers import Integral
from typing import Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, ClassifierMixin
from sklearn.utils import check_random_state
from sklearn.utils.multiclass import check_classification_targets
from sklearn.utils.validation import check_is_fitted, validate_data

from khepera_forage.policies.distance import attribute_distances, checked_diagonal


class DistinctVectors(NamedTuple):
    """Vectors of any numbers, each once, and how often each was heard with each label.

    Attributes:
        rows: One vector a row.
        votes: One row for each vector, one column for each label.
    """

    rows: NDArray[np.float64]
    votes: NDArray[np.int64]


def distinct_vectors(rows: NDArray[np.float64], labels: NDArray[np.intp], classes: int) -> DistinctVectors:
    """Merge equal vectors.

    Args:
        rows: One vector a row.
        labels: The label of each row, from 0.
        classes: How many labels there are.
    """
    distinct, places = np.unique(rows, axis=0, return_inverse=True)
    votes = np.zeros((len(distinct), classes), np.int64)
    np.add.at(votes, (places.ravel(), labels), 1)
    return DistinctVectors(distinct, votes)


class ConfidenceClassifier(ClassifierMixin, BaseEstimator):  # type: ignore[misc]  # scikit-learn is untyped
    """A classifier whose `predict_proba` gives confidence levels (4.6.2)."""

    classes_: NDArray[Any]
    n_features_in_: int

    def predict_proba(self, X: ArrayLike) -> NDArray[np.float64]:  # noqa: N803 - scikit-learn's name
        """The confidence level of each class of `classes_`, one row for each row of `X`."""
        raise NotImplementedError

    def predict(self, X: ArrayLike) -> NDArray[Any]:  # noqa: N803
        """The class with the highest confidence level, for each row of `X`; of equals the first."""
        best = self.predict_proba(X).argmax(axis=1)
        labels: NDArray[Any] = self.classes_[best]
        return labels


def checked_classes(labels: NDArray[Any], classes: ArrayLike | None) -> NDArray[Any]:
    """The classes that some labels may have, sorted.

    Args:
        labels: The labels seen.
        classes: All labels that may come; by default those seen.

    Raises:
        ValueError: The labels are no classes, or one is not among `classes`.
    """
    check_classification_targets(labels)
    seen = np.unique(labels)
    allowed = seen if classes is None else np.unique(classes)
    if not np.isin(seen, allowed).all():
        raise ValueError(f"labels are {seen.tolist()}; allowed: those among classes, {allowed.tolist()}")
    return allowed


class BruteForceClassifier(ConfidenceClassifier):
    """A classifier that compares a query with every distinct vector of its experience.

    Subclasses turn the distances into shares, in `_shares`. It suits a few thousand distinct vectors; the thesis's
    imitator has an index instead.
    """

    diagonal: int
    _vectors: DistinctVectors

    def fit(self, X: ArrayLike, y: ArrayLike) -> Self:  # noqa: N803 - scikit-learn's name
        """Learn from experience vectors, forgetting earlier ones.

        Args:
            X: State vectors, one a row, attributes in the order of `StateVector`.
            y: The behaviour heard with each.

        Raises:
            ValueError: Parameters out of range, or data that is no classification problem.
        """
        self._learn(X, y)
        return self

    def predict_proba(self, X: ArrayLike) -> NDArray[np.float64]:  # noqa: N803
        """The confidence level of each class of `classes_`, one row for each row of `X`."""
        check_is_fitted(self)
        diagonal = checked_diagonal(self.diagonal)
        queries = validate_data(self, X, reset=False, dtype=np.float64)
        rows, votes = self._vectors
        shares = np.array(
            [self._shares(attribute_distances(rows, query, diagonal), votes) for query in queries]
        )
        levels: NDArray[np.float64] = shares / shares.sum(axis=1, keepdims=True)
        return levels

    def _learn(self, X: ArrayLike, y: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.intp]]:  # noqa: N803
        """Keep the experience; returns the vectors as given, and the code of the class of each."""
        checked_diagonal(self.diagonal)
        rows, labels = validate_data(self, X, y, dtype=np.float64)
        self.classes_ = checked_classes(labels, None)
        codes = np.searchsorted(self.classes_, labels)
        self._vectors = distinct_vectors(rows, codes, len(self.classes_))
        return rows, codes

    def _shares(self, distances: NDArray[np.float64], votes: NDArray[np.int64]) -> NDArray[Any]:
        """The share of each class, in any unit.

        Args:
            distances: What each attribute contributes to the distance of each vector from the query.
            votes: How often each vector was heard with each class.
        """
        raise NotImplementedError


WEIGHTINGS = ("uniform", "distance")


class KNearestImitator(BruteForceClassifier):
    """The `k` nearest experience vectors vote, by the distance of section 4.6.1.

    Vectors at the same distance as the `k`-th also vote, so that the result does not depend on the order of the
    experience. With `k` 1 this is the thesis's imitator.

    Args:
        k: Vectors that vote, at least 1; if there are fewer, all vote.
        weighting: `uniform`, one vote each, or `distance`: votes count by the inverse of the distance, and if some
            vectors equal the query, only these vote.
        diagonal: Of the arena foraged in now, in pixels.

    Attributes:
        classes_: The labels seen, sorted.
        n_features_in_: Number of columns seen.
    """

    def __init__(self, k: int = 5, weighting: str = "uniform", diagonal: int = 138) -> None:
        self.k = k
        self.weighting = weighting
        self.diagonal = diagonal

    def _learn(self, X: ArrayLike, y: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.intp]]:  # noqa: N803
        self._check()
        return super()._learn(X, y)

    def _shares(self, distances: NDArray[np.float64], votes: NDArray[np.int64]) -> NDArray[Any]:
        self._check()
        away = distances.sum(axis=1)
        order = away.argsort(kind="stable")
        reached = votes.sum(axis=1)[order].cumsum()
        last = min(int(reached.searchsorted(self.k)), len(order) - 1)
        chosen = away <= away[order[last]]
        near = away[chosen]
        weights = np.ones(len(near))
        if self.weighting == "distance":
            weights = (near == 0) * 1.0 if near.min() == 0 else near.min() / near
        shares: NDArray[np.float64] = (votes[chosen] * weights[:, None]).sum(axis=0)
        return shares

    def _check(self) -> None:
        if not isinstance(self.k, Integral) or isinstance(self.k, bool) or self.k < 1:
            raise ValueError(f"k is {self.k!r}; allowed: an integer, at least 1")
        if self.weighting not in WEIGHTINGS:
            raise ValueError(f"weighting is {self.weighting!r}; allowed: {', '.join(WEIGHTINGS)}")


CHOICES = (0, 1, 2, 3, 4, 6, 8, 12, 16)
SWEEPS = 20
"""Most passes over all attributes; the search ends when a pass changes nothing, mostly after three."""


class WeightedImitator(BruteForceClassifier):
    """The nearest vectors vote, by a distance whose attributes count with different weights.

    "The more significant attributes should be weighted more" (5.5). The weights learned are those with the least
    leave-one-out error of the imitator: each vector in turn is the query, the others vote, and the error is the share
    of the votes for other behaviours than the one heard. This is the probability with which a learner that draws
    behaviours (4.6.2) is wrong. The search changes one attribute at a time, from equal weights: the error is a step
    function without a gradient, and there are only five attributes. Weights are whole numbers, which keeps ties exact.
    Vectors of one episode are alike; with `groups`, all vectors of the query's episode are left out.

    Args:
        diagonal: Of the arena foraged in now, in pixels.
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
        diagonal: int = 138,
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

    def fit(self, X: ArrayLike, y: ArrayLike, groups: ArrayLike | None = None) -> Self:  # noqa: N803
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
                raise ValueError(
                    f"weights are {self.weights_}; allowed: {rows.shape[1]} whole numbers, not all 0"
                )
            return self
        own = np.arange(len(rows)) if groups is None else np.asarray(groups)
        if own.shape != codes.shape:
            raise ValueError(f"groups have shape {own.shape}; allowed: {codes.shape}, one for each vector")
        if len(rows) > self.search_size:
            chosen = check_random_state(self.random_state).choice(len(rows), self.search_size, replace=False)
            rows, codes, own = rows[chosen], codes[chosen], own[chosen]
        self._search(rows, codes, own)
        return self

    def _shares(self, distances: NDArray[np.float64], votes: NDArray[np.int64]) -> NDArray[Any]:
        weighted = distances @ np.array(self.weights_, np.float64)
        shares: NDArray[np.int64] = votes[weighted == weighted.min()].sum(axis=0)
        return shares

    def _search(self, rows: NDArray[np.float64], codes: NDArray[np.intp], own: NDArray[Any]) -> None:
        choices = self._whole("choices", self.choices)
        diagonal = checked_diagonal(self.diagonal)
        pairs = np.stack([attribute_distances(rows, row, diagonal) for row in rows])
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
