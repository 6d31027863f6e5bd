"""The learner of the recall phase: nearest neighbour with confidence levels (section 4.6)."""

import math
from fractions import Fraction
from numbers import Integral, Real
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.base import BaseEstimator, ClassifierMixin
from sklearn.utils.multiclass import check_classification_targets
from sklearn.utils.validation import check_is_fitted, validate_data

from khepera_forage.policies.merging import merged
from khepera_forage.policies.neighbours import Neighbours
from khepera_forage.policies.policy import Observation, state_vector_of
from khepera_forage.policies.votes import PixelVotes, PlainVotes, VoteIndex, all_pixels
from khepera_forage.task.states import Behaviour, StateVector

MEMO_SIZE = 32768
"""State vectors remembered, some 15 MB. Of a corridor a policy sees a few thousand distinct ones."""


class _Memo(NamedTuple):
    """The neighbours of state vectors, and under which parameters they hold."""

    diagonal: int
    threshold: float
    exact_threshold: Fraction
    behaviours: list[Behaviour]
    found: dict[StateVector, Neighbours]


class NearestNeighbourImitator(ClassifierMixin, BaseEstimator):  # type: ignore[misc]  # scikit-learn is untyped
    """Does what the teacher did in the most similar situation on record.

    The distance between two state vectors is the sum of five attribute distances (4.6.1): 1 each if
    ObjectPresence or FoodType differ, the difference of ArmsHeight by 55, those of RobotHomeDistance and
    RobotFoodDistance by the diagonal. All experience vectors at exactly the minimum distance vote; the share
    of a behaviour in the votes is its confidence level (4.6.2). `predict_proba` gives the confidence levels,
    `predict` the behaviour with the highest (of equals the first in `classes_`), and `act` draws a behaviour
    with its confidence level as probability, as the thesis' learner did.

    Whole numbers of magnitude below 2**40 are compared in integer arithmetic, so that ties are exact;
    anything else in floats. Rows of other than five columns are no state vectors: there each column is taken
    for a distance in pixels, and the distance is the sum of the differences by the diagonal. Equal experience
    vectors are merged into counts, and what is learned one by one is found like all the rest (`Plane`).

    The neighbours of single state vectors are remembered, up to `MEMO_SIZE` of them. They follow from
    experience, parameters and state vector alone; they are forgotten when experience or a parameter changes,
    and never pickled.

    Args:
        diagonal: Of the arena foraged in now, in pixels of 5 mm: an integer above 0; 138 in the corridor, 177
            in the rectangle. It can be changed after `fit`, with `set_params`.
        threshold: At least 0. Above 0 it is the variant that section 4.6.1 tried "with poor results": every
            vector within the minimum distance plus `threshold` votes. It is taken for the decimal number it
            is written as: 0.1 is one tenth. The thesis' wording allows another reading, in which vectors are
            appended to the list while the best is still being sought; its outcome depends on the order of the
            file, this one's does not.

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
        return self._learn(X, y, None, anew=True)

    def partial_fit(
        self,
        X: ArrayLike,  # noqa: N803 - scikit-learn's name
        y: ArrayLike,
        classes: ArrayLike | None = None,
    ) -> "NearestNeighbourImitator":
        """Learn from further experience vectors: equal to `fit` on all of them together, in whatever order.

        Args:
            X: As for `fit`.
            y: As for `fit`.
            classes: All labels that may come. Unlike elsewhere in scikit-learn it need not be given:
                `classes_` grows by the labels that do come.

        Raises:
            ValueError: As for `fit`; or a label that is not among `classes`.
        """
        return self._learn(X, y, classes, anew=not hasattr(self, "classes_"))

    def predict_proba(self, X: ArrayLike) -> NDArray[np.float64]:  # noqa: N803
        """The confidence level of each class of `classes_`, one row for each row of `X`."""
        check_is_fitted(self)
        parameters = self._parameters()
        rows = validate_data(self, X, reset=False).tolist()
        counts = np.array([self._index.nearest(row, *parameters).counts for row in rows], np.float64)
        levels: NDArray[np.float64] = counts / counts.sum(axis=1, keepdims=True)
        return levels

    def predict(self, X: ArrayLike) -> NDArray[Any]:  # noqa: N803
        """The class with the highest confidence level, for each row of `X`."""
        best = self.predict_proba(X).argmax(axis=1)
        labels: NDArray[Any] = self.classes_[best]
        return labels

    def act(self, observation: Observation, rng: np.random.Generator | None = None) -> Behaviour:
        """A behaviour, drawn with its confidence level as probability.

        Args:
            observation: What the robot perceives; see `policies.policy.state_vector_of`.
            rng: Must be given. One number is drawn at every call, conflict or not.

        Raises:
            TypeError: `rng` is not a NumPy generator.
            ValueError: The observation holds no state vector, or what was learned are not behaviours.
        """
        if not isinstance(rng, np.random.Generator):
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
        memo = self._memo
        if memo is None or memo.diagonal != self.diagonal or memo.threshold != self.threshold:
            memo = self._memo = self._new_memo()
        vector = state_vector_of(observation)
        found = memo.found.get(vector)
        if found is None:
            distance, counts = self._index.nearest(vector, memo.diagonal, memo.exact_threshold)
            votes = tuple([(b, n) for b, n in zip(memo.behaviours, counts, strict=True) if n])
            found = Neighbours(votes, sum(counts), distance)
            if len(memo.found) >= MEMO_SIZE:
                memo.found.clear()
            memo.found[vector] = found
        return found

    def _new_memo(self) -> _Memo:
        check_is_fitted(self)
        if self.n_features_in_ != 5:
            raise ValueError(f"learned from rows of {self.n_features_in_} columns; allowed: 5, state vectors")
        try:
            behaviours = [Behaviour(label) for label in self.classes_.tolist()]
        except ValueError:
            raise ValueError(
                f"labels learned are {self.classes_.tolist()}; allowed: behaviours, 0 to {max(Behaviour):d}"
            ) from None
        diagonal, exact_threshold = self._parameters()
        return _Memo(diagonal, self.threshold, exact_threshold, behaviours, {})

    def _learn(
        self, data: ArrayLike, y: ArrayLike, classes: ArrayLike | None, *, anew: bool
    ) -> "NearestNeighbourImitator":
        self._parameters()
        rows, labels = validate_data(self, data, y, reset=anew)
        check_classification_targets(labels)
        seen = np.unique(labels)
        allowed = seen if classes is None else np.unique(classes)
        if not np.isin(seen, allowed).all():
            raise ValueError(f"labels are {seen.tolist()}; allowed: those among classes, {allowed.tolist()}")
        self._memo = None
        pixels = all_pixels(rows)
        if anew:
            self.classes_ = allowed
            self._index = PixelVotes(len(allowed)) if pixels else PlainVotes(rows.shape[1], len(allowed))
        elif not np.isin(allowed, self.classes_).all():
            known, self.classes_ = self.classes_, np.union1d(self.classes_, allowed)
            self._index.recode(np.searchsorted(self.classes_, known).tolist(), len(self.classes_))
        if isinstance(self._index, PixelVotes):
            if pixels:
                rows = rows.astype(np.int64)
            else:
                self._index = self._index.plain()
        for row, code, times in merged(rows, np.searchsorted(self.classes_, labels)):
            self._index.add(row, code, times)
        return self

    def _parameters(self) -> tuple[int, Fraction]:
        """The diagonal and the exact threshold, once they are found to be in range."""
        diagonal, threshold = self.diagonal, self.threshold
        if not isinstance(diagonal, Integral) or isinstance(diagonal, bool) or diagonal < 1:
            raise ValueError(f"diagonal is {diagonal!r}; allowed: an integer above 0, in pixels")
        if not isinstance(threshold, Real) or not 0 <= threshold < math.inf:
            raise ValueError(f"threshold is {threshold!r}; allowed: a finite number, at least 0")
        return int(diagonal), Fraction(str(threshold))

    def __getstate__(self) -> dict[str, Any]:
        return {**super().__getstate__(), "_memo": None}
