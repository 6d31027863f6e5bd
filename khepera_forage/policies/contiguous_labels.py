"""Classifiers that only know labels 0, 1, 2, ..., such as XGBoost's: behaviours as such labels, and back."""

from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray


class ContiguousLabels:
    """Lets a classifier learn labels that are not 0, 1, 2, ...

    Behaviours heard in training leave gaps: without poisonous food nobody hears AVOID FOOD.

    Args:
        estimator: Any classifier with `fit` and `predict_proba`.

    Attributes:
        classes_: The labels learned, in increasing order.
    """

    def __init__(self, estimator: Any) -> None:
        self.estimator = estimator
        self.classes_: NDArray[Any]

    def fit(self, X: ArrayLike, y: ArrayLike, **kwargs: Any) -> Self:  # noqa: N803 - scikit-learn's name
        """Learn from rows and their labels.

        Args:
            X: Of shape (n, 5) for state vectors.
            y: Of shape (n,).
            **kwargs: For the estimator's own `fit`.
        """
        self.classes_, codes = np.unique(y, return_inverse=True)
        self.n_features_in_ = np.shape(X)[1]
        self.estimator.fit(X, codes, **kwargs)
        return self

    def predict_proba(self, X: ArrayLike) -> NDArray[np.float64]:  # noqa: N803
        """The probability of each class of `classes_`, one row for each row of `X`."""
        levels: NDArray[np.float64] = np.asarray(self.estimator.predict_proba(X))
        return levels

    def predict(self, X: ArrayLike) -> NDArray[Any]:  # noqa: N803
        """The most probable class of each row of `X`."""
        labels: NDArray[Any] = self.classes_[self.predict_proba(X).argmax(axis=1)]
        return labels
