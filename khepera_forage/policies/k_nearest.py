"""Variants of the imitator in which `k` vectors vote."""

from numbers import Integral
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from khepera_forage.policies.brute_force_classifier import BruteForceClassifier

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
