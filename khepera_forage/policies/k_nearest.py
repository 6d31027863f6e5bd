"""Variants of the imitator in which more than the nearest vectors vote."""

from numbers import Integral

import numpy as np
from numpy.typing import ArrayLike, NDArray

from khepera_forage.policies.distinct import DistinctRows

WEIGHTINGS = ("uniform", "distance")


class KNearestImitator(DistinctRows):
    """The `k` nearest experience vectors vote, by the distance of section 4.6.1.

    All vectors as near as the `k`-th vote too, so that the outcome does not depend on the order of the records;
    with `k` 1 this is the thesis' imitator.

    Args:
        k: Vectors that vote, at least 1; with fewer on record all of them vote.
        weighting: `uniform`, one vote each, or `distance`: votes count by the inverse of the distance, and where
            there are vectors equal to the one perceived, they alone vote.
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

    def _shares(self, away: NDArray[np.float64]) -> NDArray[np.float64]:
        self._check()
        distances = away.sum(axis=1)
        order = distances.argsort(kind="stable")
        reached = self._counts.sum(axis=1)[order].cumsum()
        last = min(int(reached.searchsorted(self.k)), len(order) - 1)
        chosen = (distances <= distances[order[last]]).nonzero()[0]
        votes, near = self._counts[chosen], distances[chosen]
        if self.weighting == "distance":
            votes = votes * (near == 0 if near.min() == 0 else near.min() / near)[:, None]
        shares: NDArray[np.float64] = votes.sum(axis=0)
        return shares

    def _check(self) -> None:
        if not isinstance(self.k, Integral) or isinstance(self.k, bool) or self.k < 1:
            raise ValueError(f"k is {self.k!r}; allowed: an integer, at least 1")
        if self.weighting not in WEIGHTINGS:
            raise ValueError(f"weighting is {self.weighting!r}; allowed: {', '.join(WEIGHTINGS)}")
