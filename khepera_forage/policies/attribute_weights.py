"""The imitator with attribute weights learned from its experience (suggested in 5.4.1.2 and 5.5)."""

from collections.abc import Sequence
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray
from sklearn.utils import check_random_state

from khepera_forage.policies.brute_force_classifier import BruteForceClassifier
from khepera_forage.policies.nearest_neighbour.distance import attribute_distances, checked_diagonal

CHOICES = (0, 1, 2, 3, 4, 6, 8, 12, 16)
SWEEPS = 20
"""Most passes over all attributes; the search ends when a pass changes nothing, mostly after three."""


class WeightedImitator(BruteForceClassifier):
    """The nearest vectors vote, by a distance whose attributes count with different weights.

    "The more significant attributes should be weighted more" (5.5). The weights learned are those with the least
    leave-one-out error of the imitator: each vector in turn is the query, the others vote, and the error is the share
    of the votes for other behaviours than the one heard. This is the probability with which a learner that draws
    behaviours (4.6.2) is wrong. The search changes one attribute at a time, from equal weights: the error is a step
    function without a gradient, and there are only five attributes. Weights are whole numbers, which keeps ties exact.
    Vectors of one episode are alike; with `groups`, all vectors of the query's episode are left out.

    Args:
        diagonal: Of the arena foraged in now, in pixels.
        weights: One whole number for each column, at least 0 and not all 0; learned by default.
        choices: The weights that the search tries.
        search_size: Most vectors that the search compares; with more, this many are drawn.
        random_state: Of that draw.

    Attributes:
        classes_: The labels seen, sorted.
        n_features_in_: Number of columns seen.
        weights_: The weight of each column.
        error_: Leave-one-out error with these weights, 0..1; missing if `weights` are given.
        plain_error_: The same with equal weights.
    """

    weights_: tuple[int, ...]
    error_: float
    plain_error_: float

    def __init__(
        self,
        diagonal: int = 138,
        weights: Sequence[int] | None = None,
        choices: Sequence[int] = CHOICES,
        search_size: int = 600,
        random_state: Any = None,
    ) -> None:
        self.diagonal = diagonal
        self.weights = weights
        self.choices = choices
        self.search_size = search_size
        self.random_state = random_state

    def fit(self, X: ArrayLike, y: ArrayLike, groups: ArrayLike | None = None) -> Self:  # noqa: N803
        """Learn from experience vectors, forgetting earlier ones.

        Args:
            X: State vectors, one a row, attributes in the order of `StateVector`.
            y: The behaviour heard with each.
            groups: The training episode of each vector; by default each vector is its own group.

        Raises:
            ValueError: Parameters out of range, data that is no classification problem, or groups of another length.
        """
        rows, codes = self._learn(X, y)
        if self.weights is not None:
            self.weights_ = self._whole("weights", self.weights)
            if len(self.weights_) != rows.shape[1] or not any(self.weights_):
                raise ValueError(
                    f"weights are {self.weights_}; allowed: {rows.shape[1]} whole numbers, not all 0"
                )
            return self
        own = np.arange(len(rows)) if groups is None else np.asarray(groups)
        if own.shape != codes.shape:
            raise ValueError(f"groups have shape {own.shape}; allowed: {codes.shape}, one for each vector")
        if len(rows) > self.search_size:
            chosen = check_random_state(self.random_state).choice(len(rows), self.search_size, replace=False)
            rows, codes, own = rows[chosen], codes[chosen], own[chosen]
        self._search(rows, codes, own)
        return self

    def _shares(self, distances: NDArray[np.float64], votes: NDArray[np.int64]) -> NDArray[Any]:
        weighted = distances @ np.array(self.weights_, np.float64)
        shares: NDArray[np.int64] = votes[weighted == weighted.min()].sum(axis=0)
        return shares

    def _search(self, rows: NDArray[np.float64], codes: NDArray[np.intp], own: NDArray[Any]) -> None:
        choices = self._whole("choices", self.choices)
        diagonal = checked_diagonal(self.diagonal)
        pairs = np.stack([attribute_distances(rows, row, diagonal) for row in rows])
        same, out = codes[:, None] == codes, own[:, None] == own
        queries = ~out.all(axis=1)  # those that have vectors to vote on them

        def error(weights: list[int]) -> float:
            distances = pairs @ np.array(weights, np.float64)
            distances[out] = np.inf
            voters = (distances == distances.min(axis=1, keepdims=True))[queries] & ~out[queries]
            right = (voters & same[queries]).sum(axis=1) / voters.sum(axis=1)
            return float(1 - right.mean()) if queries.any() else 0.0

        weights = [1] * rows.shape[1]
        self.plain_error_ = best = error(weights)
        for _ in range(SWEEPS):
            before = list(weights)
            for column in range(len(weights)):
                for choice in choices:
                    tried = [*weights[:column], choice, *weights[column + 1 :]]
                    if any(tried) and (found := error(tried)) < best - 1e-12:  # rounding is no improvement
                        best, weights = found, tried
            if weights == before:
                break
        self.weights_, self.error_ = tuple(weights), best

    @staticmethod
    def _whole(name: str, values: Sequence[int]) -> tuple[int, ...]:
        whole = tuple(int(value) for value in values)
        if any(value < 0 or value != given for value, given in zip(whole, values, strict=True)):
            raise ValueError(f"{name} are {tuple(values)}; allowed: whole numbers, at least 0")
        return whole
