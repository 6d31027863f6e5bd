"""Approximate Bayesian computation by random forests: simulated sets, weighted by their likeness to an experiment.

A forest learns to predict decisions from summary statistics, so that it finds out which statistics matter. A set that
falls into the same leaves as an experiment has similar statistics as far as these decisions are concerned; the share of
leaves that they have in common is its weight. Weighted sets are the posterior (Raynal et al. 2019, "ABC random forests
for Bayesian parameter inference", Bioinformatics 35: 1720-1728; for several parameters together, the forest predicts
all of them, as in distributional random forests).
"""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from sklearn.ensemble import RandomForestRegressor

Floats = NDArray[np.float64]


TREES = 200
LEAST_LEAF = 5
"""Fewest experiments in a leaf, of those that the tree was grown with."""


class SetForest:
    """A forest on the experiments of simulated sets.

    Args:
        statistics: Of the experiments, shape (sets, experiments, statistics); they may be missing (nan).
        targets: What the trees predict, shape (sets, columns).
        seed: Of the forest.
        trees: Number of trees.
    """

    def __init__(self, statistics: Floats, targets: Floats, seed: int, trees: int = TREES) -> None:
        self._sets, experiments, _ = statistics.shape
        self._rows = np.ascontiguousarray(statistics.reshape(self._sets * experiments, -1), dtype=np.float32)
        self._owners = np.repeat(np.arange(self._sets), experiments)
        forest = RandomForestRegressor(
            trees,
            min_samples_leaf=LEAST_LEAF,
            max_features=1 / 3,
            max_samples=self._sets,  # about one experiment of each set, and others in the next tree
            random_state=seed,
        )
        values = targets[self._owners]
        self._trees = [
            one.tree_
            for one in forest.fit(self._rows, values[:, 0] if values.shape[1] == 1 else values).estimators_
        ]

    def weights(self, observed: Floats) -> Floats:
        """How much each set counts, given the statistics of an experiment.

        Args:
            observed: Statistics of some experiments, shape (queries, statistics).

        Returns:
            Shape (queries, sets); each row sums to 1.
        """
        queries = np.ascontiguousarray(observed, dtype=np.float32)
        total = np.zeros((len(queries), self._sets))
        for tree in self._trees:
            leaves = tree.apply(self._rows)
            size = np.bincount(leaves, minlength=tree.node_count)
            shares = csr_array((1.0 / size[leaves], (leaves, self._owners)), (tree.node_count, self._sets))
            total += shares[tree.apply(queries)].toarray()
        return total / len(self._trees)
