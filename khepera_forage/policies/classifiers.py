"""Classifiers of scikit-learn: as policies, with our settings, and those that only know labels 0, 1, 2, ...."""

from dataclasses import dataclass, field
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from khepera_forage.policies.distance import CORRIDOR_DIAGONAL, STATE_WIDTH
from khepera_forage.policies.features import encoded
from khepera_forage.policies.policy import (
    Observation,
    behaviours_of,
    checked_generator,
    draw_label,
    remembered,
    state_vector_of,
)
from khepera_forage.task.states import Behaviour, StateVector

TOLERANCE = 1e-3
"""How much the sum of probabilities may differ from 1: learners with 32-bit floats round."""


@dataclass(frozen=True, slots=True)
class ClassifierPolicy:
    """Executes the behaviour that a classifier predicts from the state vector.

    Attributes:
        classifier: As of scikit-learn, with `predict_proba` and `classes_`, fitted on `Experience.arrays`.
        sample: Whether a behaviour is drawn with its probability, like the imitator's with its confidence level.
            If not, the most probable behaviour is executed.
        remember: Whether probabilities are cached by state vector, which makes decisions ten to a thousand times as
            fast. Only for a classifier that learns no further.
    """

    classifier: Any
    sample: bool = True
    remember: bool = False
    _cache: dict[StateVector, NDArray[np.float64]] = field(default_factory=dict, init=False, repr=False, compare=False)

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """The behaviour drawn, or the most probable one; with `sample` one number is drawn at every call.

        Raises:
            TypeError: As `Policy.act`.
            ValueError: As `Policy.act`; or the classifier's probabilities are none, or its labels no behaviours.
        """
        vector = state_vector_of(observation)
        cache = self._cache if self.remember else {}
        levels = remembered(cache, vector, lambda: self._predicted(vector))
        label = int(levels.argmax())
        if self.sample:
            label = draw_label(levels, levels.sum(), checked_generator(rng).random())
        return behaviours_of(self.classifier.classes_)[label]

    def _predicted(self, vector: StateVector) -> NDArray[np.float64]:
        classes = self.classifier.classes_
        if len(classes) == 1:  # for which scikit-learn's networks predict two probabilities
            return np.ones(1)
        levels = np.asarray(self.classifier.predict_proba(np.array([vector], np.int64)))[0]
        fine = levels.shape == np.shape(classes) and np.all(levels >= 0.0)  # NaN fails the comparison
        if not fine or abs(levels.sum() - 1.0) > TOLERANCE:
            raise ValueError(
                f"{type(self.classifier).__name__} predicts the probabilities {np.round(levels, 4).tolist()} of the "
                f"classes {np.array(classes).tolist()}; allowed: one for each class, none negative, with the sum 1"
            )
        probabilities: NDArray[np.float64] = levels.astype(np.float64, copy=False)
        return probabilities


def policy_of(learner: Any, sample: bool = True) -> ClassifierPolicy:
    """The policy of a fitted classifier, which learns no further.

    Raises:
        ValueError: It has no probabilities, does not say of which behaviours, or knows no state vectors.
    """
    kind = type(learner).__name__
    if not callable(getattr(learner, "predict_proba", None)):
        raise ValueError(f"{kind} has no predict_proba; allowed: a classifier that gives each behaviour a probability")
    if not hasattr(learner, "classes_"):
        raise ValueError(
            f"{kind} has no classes_; allowed: a fitted classifier, whose classes_ are the behaviours that the columns "
            "of predict_proba stand for"
        )
    behaviours_of(learner.classes_)
    columns = getattr(learner, "n_features_in_", STATE_WIDTH)
    if columns != STATE_WIDTH:
        raise ValueError(f"{kind} was fitted on {columns} columns; allowed: {STATE_WIDTH}, state vectors")
    return ClassifierPolicy(learner, sample, remember=True)


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

    def fit(self, X: ArrayLike, y: ArrayLike, **kwargs: Any) -> Self:
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

    def predict_proba(self, X: ArrayLike) -> NDArray[np.float64]:
        """The probability of each class of `classes_`, one row for each row of `X`."""
        levels: NDArray[np.float64] = np.asarray(self.estimator.predict_proba(X))
        return levels

    def predict(self, X: ArrayLike) -> NDArray[Any]:
        """The most probable class of each row of `X`."""
        labels: NDArray[Any] = self.classes_[self.predict_proba(X).argmax(axis=1)]
        return labels


def tree(random_state: int = 0, **settings: Any) -> Any:
    """scikit-learn's `DecisionTreeClassifier`, not fitted: a tree can split categories that are whole numbers."""
    from sklearn.tree import DecisionTreeClassifier

    return DecisionTreeClassifier(random_state=random_state, **settings)


def boosting(random_state: int = 0, **settings: Any) -> Any:
    """scikit-learn's `GradientBoostingClassifier`, not fitted.

    The variant over histograms takes ten milliseconds a decision, this one a third of a millisecond.
    """
    from sklearn.ensemble import GradientBoostingClassifier

    return GradientBoostingClassifier(random_state=random_state, **settings)


def cloning(random_state: int = 0, **settings: Any) -> Any:
    """scikit-learn's `MLPClassifier` on encoded state vectors (`policies.features.encoded`), not fitted.

    Distances are scaled by the corridor's diagonal in every arena: a network learns places in pixels, not in diagonals.
    """
    from sklearn.neural_network import MLPClassifier
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import FunctionTransformer

    return make_pipeline(
        FunctionTransformer(encoded, kw_args={"diagonal": CORRIDOR_DIAGONAL}),
        MLPClassifier(random_state=random_state, **settings),
    )
