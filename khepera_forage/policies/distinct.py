"""What learners that compare every vector on record have in common: distinct rows, counts, parameters."""

from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, ClassifierMixin
from sklearn.utils.multiclass import check_classification_targets
from sklearn.utils.validation import check_is_fitted, validate_data

from khepera_forage.policies.measure import apart, checked_diagonal


class DistinctRows(ClassifierMixin, BaseEstimator):  # type: ignore[misc]  # scikit-learn is untyped
    """A classifier that keeps distinct rows and how often each was seen with each class, and looks at them all.

    Subclasses say in `_shares` what the distances make of the counts. For a few thousand distinct vectors; the
    thesis' imitator does not look at all of them.
    """

    diagonal: int
    classes_: NDArray[Any]
    n_features_in_: int
    _rows: NDArray[np.float64]
    _counts: NDArray[np.float64]

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
        rows = validate_data(self, X, reset=False, dtype=np.float64)
        shares = np.array([self._shares(apart(self._rows, row, diagonal)) for row in rows])
        levels: NDArray[np.float64] = shares / shares.sum(axis=1, keepdims=True)
        return levels

    def predict(self, X: ArrayLike) -> NDArray[Any]:  # noqa: N803
        """The class with the highest confidence level, for each row of `X`."""
        best = self.predict_proba(X).argmax(axis=1)
        labels: NDArray[Any] = self.classes_[best]
        return labels

    def _learn(self, X: ArrayLike, y: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.intp]]:  # noqa: N803
        """Keep what is seen; returns the rows and the codes of their classes as given."""
        checked_diagonal(self.diagonal)
        rows, labels = validate_data(self, X, y, dtype=np.float64)
        check_classification_targets(labels)
        self.classes_, codes = np.unique(labels, return_inverse=True)
        self._rows, places = np.unique(rows, axis=0, return_inverse=True)
        self._counts = np.zeros((len(self._rows), len(self.classes_)))
        np.add.at(self._counts, (places.ravel(), codes), 1.0)
        return rows, codes

    def _shares(self, away: NDArray[np.float64]) -> NDArray[np.float64]:
        """What each class gets, given how far each distinct row is in each column."""
        raise NotImplementedError
