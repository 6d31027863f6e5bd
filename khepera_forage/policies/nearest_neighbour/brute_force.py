"""Distinct vectors of any numbers, for learners that compare a query with every vector."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray


class DistinctVectors(NamedTuple):
    """Vectors of any numbers, each once, and how often each was heard with each label.

    Attributes:
        rows: One vector a row.
        votes: One row for each vector, one column for each label.
    """

    rows: NDArray[np.float64]
    votes: NDArray[np.int64]

    def unpacked(self) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
        """The vectors with each label they were heard with, the label, and how often."""
        vectors, labels = self.votes.nonzero()
        return self.rows[vectors], labels, self.votes[vectors, labels]


def distinct_vectors(
    rows: NDArray[Any], labels: NDArray[np.int64], classes: int, times: NDArray[np.int64] | int = 1
) -> DistinctVectors:
    """Merge equal vectors.

    Args:
        rows: One vector a row.
        labels: The label of each row, from 0.
        classes: How many labels there are.
        times: How often each row was heard.
    """
    distinct, places = np.unique(rows.astype(np.float64), axis=0, return_inverse=True)
    votes = np.zeros((len(distinct), classes), np.int64)
    np.add.at(votes, (places.ravel(), labels), times)
    return DistinctVectors(distinct, votes)
