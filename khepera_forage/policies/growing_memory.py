"""A memory that grows with experience and forgets, after Marom and Hayes (2001), as described in section 2.3."""

from numbers import Real
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from khepera_forage.policies.distance import STATE_WIDTH, unit
from khepera_forage.policies.imitator import ConfidenceClassifier


class GrowingMemory(ConfidenceClassifier):
    """Nodes grow from experience; frequent stimuli are remembered well, rare ones are slowly forgotten.

    Stimuli (state vectors) come one by one, in the order of the rows. If the node nearest to a stimulus, by the
    distance of section 4.6.1, is within `reach`, the node moves towards the stimulus and counts the behaviour heard.
    Otherwise a new node grows at the stimulus. Every node has a habituation value: 1 for a stimulus never perceived,
    near 0 for one perceived all the time. The lower the value, the less a node moves. A stimulus lowers the value
    of its node by the share `habituation`; every stimulus first raises all values by the share `recovery` of what is
    missing to 1. Above `forgetting` a node is forgotten. A node visited once lasts for
    log(habituation / (1 - forgetting)) / recovery stimuli, a node visited often a few hundred more.

    The thesis gives no numbers; the defaults are ours. A node lasts for some 1,700 stimuli, the experience of about
    thirty training episodes.

    Args:
        diagonal: As of `NearestNeighbourImitator`.
        reach: Distance up to which a stimulus belongs to a node; at least 0.
        habituation: 0..1, above 0.
        recovery: 0..1; with 0 nothing is forgotten.
        forgetting: Habituation value above which a node is forgotten, 0..1.
        moving: Share of the way to the stimulus that a node with habituation value 1 would move, 0..1.

    Attributes:
        classes_: The labels seen, sorted.
        n_features_in_: Number of columns seen.
        nodes_: The nodes, one a row.
        habituation_: The habituation value of each.
        votes_: How often each node was perceived with each class, one row a node.
    """

    habituation_: NDArray[np.float64]

    def __init__(
        self,
        diagonal: int | None = None,
        reach: float = 0.02,
        habituation: float = 0.3,
        recovery: float = 0.002,
        forgetting: float = 0.99,
        moving: float = 0.1,
    ) -> None:
        self.diagonal = diagonal
        self.reach = reach
        self.habituation = habituation
        self.recovery = recovery
        self.forgetting = forgetting
        self.moving = moving

    def partial_fit(self, X: ArrayLike, y: ArrayLike, classes: ArrayLike | None = None) -> Self:
        """Perceive further stimuli, in the order of the rows; arguments as of `NearestNeighbourImitator`."""
        self._learn(X, y, classes, forget=not hasattr(self, "classes_"))
        return self

    @property
    def nodes_(self) -> NDArray[np.float64]:
        """The nodes, one a row."""
        return self._rows

    def _shares(self, query: NDArray[np.float64]) -> NDArray[Any]:
        shares: NDArray[np.int64] = self.votes_[self._distances(query).sum(axis=1).argmin()]
        return shares

    def _add(self, rows: NDArray[np.float64], codes: NDArray[np.intp]) -> None:
        if not len(self.votes_):
            self._rows, self.habituation_ = np.empty((0, rows.shape[1])), np.empty(0)
        for row, code in zip(rows, codes.tolist(), strict=True):
            self._perceive_one(row, code)

    def _perceive_one(self, row: NDArray[np.float64], code: int) -> None:
        self.habituation_ += self.recovery * (1 - self.habituation_)
        # Of rows that are no state vectors, the distance is the sum of the differences.
        scale = unit(len(row), self._diagonal) if len(row) == STATE_WIDTH else 1
        away = self._distances(row).sum(axis=1) / scale
        node = int(away.argmin()) if len(away) else -1
        if node < 0 or away[node] > self.reach:
            node = len(self._rows)
            self._rows = np.vstack((self._rows, row))
            self.habituation_ = np.append(self.habituation_, 1.0)
            self.votes_ = np.vstack((self.votes_, np.zeros(len(self.classes_), np.int64)))
        else:
            self._rows[node] += self.moving * self.habituation_[node] * (row - self._rows[node])
        self.habituation_[node] *= 1 - self.habituation
        self.votes_[node, code] += 1
        kept = self.habituation_ <= self.forgetting
        kept[node] = True
        if not kept.all():
            self._rows, self.votes_ = self._rows[kept], self.votes_[kept]
            self.habituation_ = self.habituation_[kept]

    def _check(self) -> None:
        super()._check()
        if not isinstance(self.reach, Real) or not 0 <= self.reach < np.inf:
            raise ValueError(f"reach is {self.reach!r}; allowed: a finite number, at least 0")
        for name in ("habituation", "recovery", "forgetting", "moving"):
            value = getattr(self, name)
            if not isinstance(value, Real) or not 0 <= value <= 1 or (name == "habituation" and not value):
                raise ValueError(f"{name} is {value!r}; allowed: 0 to 1, habituation above 0")
