"""Classifiers of scikit-learn with our settings, and those that only know labels 0, 1, 2, ...."""

from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from khepera_forage.policies.distance import CORRIDOR_DIAGONAL


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


def tree(random_state: int = 0, **settings: Any) -> Any:
    """scikit-learn's decision tree, not fitted.

    Categories stay small whole numbers, which a tree can split.

    Args:
        random_state: Seed of the choice between equally good splits.
        **settings: Arguments of `sklearn.tree.DecisionTreeClassifier`.
    """
    from sklearn.tree import DecisionTreeClassifier

    return DecisionTreeClassifier(random_state=random_state, **settings)


def boosting(random_state: int = 0, **settings: Any) -> Any:
    """scikit-learn's gradient boosting, not fitted.

    The variant over histograms takes ten milliseconds a decision, this one a third of a millisecond.

    Args:
        random_state: Seed of its random choices.
        **settings: Arguments of `sklearn.ensemble.GradientBoostingClassifier`.
    """
    from sklearn.ensemble import GradientBoostingClassifier

    return GradientBoostingClassifier(random_state=random_state, **settings)


def cloning(random_state: int = 0, **settings: Any) -> Any:
    """scikit-learn's multi-layer perceptron on encoded state vectors (`policies.features.encoded`), not fitted.

    Distances are scaled by the corridor's diagonal in every arena: a network learns places in pixels, not in diagonals.

    Args:
        random_state: Seed of the first weights and of the order of the vectors.
        **settings: Arguments of `sklearn.neural_network.MLPClassifier`.
    """
    from sklearn.neural_network import MLPClassifier
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import FunctionTransformer

    from khepera_forage.policies.features import encoded

    return make_pipeline(
        FunctionTransformer(encoded, kw_args={"diagonal": CORRIDOR_DIAGONAL}),
        MLPClassifier(random_state=random_state, **settings),
    )
