"""The learner of the recall phase: nearest neighbour with confidence levels (section 4.6)."""

from fractions import Fraction
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, ClassifierMixin
from sklearn.utils.multiclass import check_classification_targets
from sklearn.utils.validation import check_is_fitted, validate_data

from khepera_forage.foraging.states import Behaviour, StateVector
from khepera_forage.policies.policy import Observation, state_vector_of
from khepera_forage.policies.votes import PixelVotes, PlainVotes, VoteIndex

MEMO_SIZE = 32768
"""Decisions remembered: some 10 MB. A corridor has a few thousand distinct state vectors."""
WHOLE_LIMIT = 2**40
"""Whole numbers from here on are treated as floats."""


class Neighbours(NamedTuple):
    """The experience vectors at the minimum distance from a state vector (with a threshold: near it).

    Attributes:
        votes: How many of them there are for each behaviour; behaviours without a vote are left out.
        distance: The minimum distance, in the measure of section 4.6.1.
    """

    votes: dict[Behaviour, int]
    distance: float

    @property
    def tied(self) -> int:
        """How many experience vectors vote; equal vectors count one by one."""
        return sum(self.votes.values())

    @property
    def tie(self) -> bool:
        """Whether more than one experience vector votes."""
        return self.tied > 1

    @property
    def conflict(self) -> bool:
        """Whether they vote for more than one behaviour."""
        return len(self.votes) > 1


class _Decision(NamedTuple):
    """What `act` needs of the votes for one state vector."""

    votes: tuple[tuple[Behaviour, int], ...]
    total: int
    distance: float


class _Memo(NamedTuple):
    """Decisions by state vector, and the parameters under which they hold."""

    diagonal: int
    threshold: float
    exact_threshold: Fraction
    behaviours: list[Behaviour]
    decisions: dict[StateVector, _Decision]


class NearestNeighbourImitator(ClassifierMixin, BaseEstimator):  # type: ignore[misc]  # scikit-learn is untyped
    """Does what the teacher did in the most similar situation on record.

    The distance between two state vectors is the sum of five attribute distances (4.6.1): ObjectPresence and FoodType
    1 if different, ArmsHeight by 55, RobotHomeDistance and RobotFoodDistance by the diagonal. All experience vectors
    at exactly the minimum distance vote; the share of a behaviour in the votes is its confidence level (4.6.2).
    `predict_proba` gives the confidence levels, `predict` the behaviour with the highest (the first of equals in
    `classes_`), and `act` draws a behaviour with its confidence level as probability, as the thesis' learner did.

    Whole numbers below 2**40 are compared in integer arithmetic, so that ties are exact; anything else in floats. Rows
    of other than five columns are no state vectors: there each column is taken for a distance in pixels, and the
    distance is the sum of the differences by the diagonal. Equal experience vectors are merged into counts.

    Single decisions are remembered (a pure function of experience, parameters and state vector); the memo is dropped
    whenever one of these changes, and is not pickled.

    Args:
        diagonal: Of the arena foraged in now, in pixels: an integer above 0; 138 in the corridor, 177 in the rectangle.
            It can be changed after `fit`, with `set_params`.
        threshold: The variant that section 4.6.1 tried "with poor results": every vector within the minimum distance
            plus `threshold` votes. 0, the default, is the thesis' algorithm. It is read as the decimal number it is
            written as: 0.1 is one tenth. The thesis' wording allows another reading, in which vectors are appended
            while the best is still being sought; that depends on the order of the file, this does not.

    Attributes:
        classes_: The labels seen, sorted.
        n_features_in_: Number of columns seen.
    """

    classes_: NDArray[Any]
    n_features_in_: int
    _index: VoteIndex
    _memo: _Memo | None = None

    def __init__(self, diagonal: int = 138, threshold: float = 0.0) -> None:
        self.diagonal = diagonal
        self.threshold = threshold

    def fit(self, X: ArrayLike, y: ArrayLike) -> "NearestNeighbourImitator":  # noqa: N803 - scikit-learn's name
        """Learn from experience vectors, forgetting earlier ones.

        Args:
            X: State vectors, one a row, attributes in the order of `StateVector`.
            y: The behaviour heard with each.

        Raises:
            ValueError: Parameters out of range, or data that is no classification problem.
        """
        self._exact_threshold()
        rows, labels = validate_data(self, X, y)
        check_classification_targets(labels)
        self.classes_ = np.unique(labels)
        whole = _whole_numbers(rows) is not None
        self._index = PixelVotes(len(self.classes_)) if whole else PlainVotes(rows.shape[1], len(self.classes_))
        return self._add(rows, labels)

    def partial_fit(
        self,
        X: ArrayLike,  # noqa: N803 - scikit-learn's name
        y: ArrayLike,
        classes: ArrayLike | None = None,
    ) -> "NearestNeighbourImitator":
        """Learn from further experience vectors; equal to `fit` on all of them together, in whatever order.

        Args:
            X: As for `fit`.
            y: As for `fit`.
            classes: All labels there may be. Other than elsewhere in scikit-learn it need not be given: `classes_` grows
                by the labels that come.

        Raises:
            ValueError: As for `fit`; or a label that is not among `classes`.
        """
        if not hasattr(self, "_index"):
            if classes is None:
                return self.fit(X, y)
            self.fit(X, y)
            return self._widen(np.asarray(classes))
        return self
