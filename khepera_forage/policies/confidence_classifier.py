"""What the classifiers of this package share: labels that may grow, and the label with the highest confidence."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, ClassifierMixin
from sklearn.utils.multiclass import check_classification_targets


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
