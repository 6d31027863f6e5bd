"""What learners that compare a query with every vector share."""

from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.utils.validation import check_is_fitted, validate_data

from khepera_forage.policies.confidence_classifier import ConfidenceClassifier, checked_classes
from khepera_forage.policies.nearest_neighbour.brute_force import DistinctVectors, distinct_vectors
from khepera_forage.policies.nearest_neighbour.distance import attribute_distances, checked_diagonal


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
