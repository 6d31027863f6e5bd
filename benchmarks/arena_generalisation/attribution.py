"""Which attribute of the state vector an imitator's wrong decisions are due to.

Every state vector in which the imitator decided is judged again with one attribute left out of the distance, and with
the distances divided by the corridor's diagonal in place of the arena's. Setting an attribute that is beyond all
experience to the nearest value of the training would change nothing: it is then further from every experience vector
by the same amount, and the same vectors stay the nearest.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from arena_generalisation.learning import CORRIDOR_DIAGONAL
from arena_generalisation.recall_arenas import RecallArena
from arena_generalisation.rows import AS_IT_IS, WrongDecisions
from arena_generalisation.trainings import Training
from khepera_forage.envs.arguments import checked_arena
from khepera_forage.envs.forager import arena_map_of
from khepera_forage.policies.nearest_neighbour.brute_force import distinct_vectors
from khepera_forage.policies.nearest_neighbour.distance import STATE_WIDTH, attribute_distances
from khepera_forage.task.decisions import DEFAULT_DECISIONS, DEFAULT_VALUES
from khepera_forage.task.states import NUM_BEHAVIOURS, State, StateVector, classify

CORRIDORS_DIAGONAL = "corridor's diagonal"
CHANGES = (AS_IT_IS, *StateVector._fields, CORRIDORS_DIAGONAL)
_KEPT = np.column_stack((np.ones(STATE_WIDTH), 1.0 - np.eye(STATE_WIDTH)))
"""Weights of the attributes, one column for each change but the last."""
_HOME, _FOOD = (StateVector._fields.index(name) for name in ("robot_home_distance", "robot_food_distance"))


class Visits(NamedTuple):
    """Where an imitator decided in one arena.

    Attributes:
        arena: Where.
        vectors: The state vectors, shape (n, 5).
        levels: Confidence level of each behaviour there, shape (n, 10).
        times: How often it decided in each.
    """

    arena: RecallArena
    vectors: NDArray[np.int64]
    levels: NDArray[np.float64]
    times: NDArray[np.int64]


class _Judged(NamedTuple):
    """One row for each state vector, in the order of `Visits`."""

    states: NDArray[np.int64]
    right: NDArray[np.float64]
    beyond: NDArray[np.bool_]


def wrong_decisions(visits: Visits, training: Training, name: str, replication: int) -> list[WrongDecisions]:
    """Wrong decisions in each state, with each change.

    Args:
        visits: Of the imitator in one arena.
        training: What it learned from.
        name: Of the training.
        replication: For the rows.
    """
    arena_map = arena_map_of(checked_arena(visits.arena.arena, DEFAULT_DECISIONS))
    judged, memory = _judge(visits, training, arena_map.home_radius), _Memory.of(training)
    changed = np.array(
        [
            memory.right_with_changes(vector, state, arena_map.diagonal)
            for vector, state in zip(visits.vectors, judged.states.tolist(), strict=True)
        ]
    )
    rows = []
    for change, right in zip(CHANGES, changed.T, strict=True):
        for state in np.unique(judged.states).tolist():
            own = judged.states == state
            times, before, after = visits.times[own], judged.right[own], right[own]
            rows.append(
                WrongDecisions(
                    training=name,
                    replication=replication,
                    group=visits.arena.group,
                    arena=visits.arena.name,
                    state=State(state).name,
                    change=change,
                    decisions=int(times.sum()),
                    wrong=float((times * (1 - before)).sum()),
                    beyond=float((times * (1 - before))[judged.beyond[own]].sum()),
                    still_wrong=float((times * (1 - after)).sum()),
                    corrected=float((times * (1 - before) * after).sum()),
                )
            )
    return rows


def _judge(visits: Visits, training: Training, home_radius: float) -> _Judged:
    """The state of each vector, the confidence in its right behaviour, and whether it is beyond all experience."""
    vectors = [StateVector(*vector) for vector in visits.vectors.tolist()]
    states = np.array([classify(vector, home_radius, DEFAULT_VALUES) for vector in vectors], np.int64)
    columns = [_HOME, _FOOD]
    return _Judged(
        states,
        visits.levels[np.arange(len(states)), states],
        (visits.vectors[:, columns] > training.vectors[:, columns].max(axis=0)).any(axis=1),
    )


class _Memory(NamedTuple):
    """The distinct experience vectors of an imitator, and how often each was heard with each behaviour."""

    rows: NDArray[np.float64]
    votes: NDArray[np.int64]

    @classmethod
    def of(cls, training: Training) -> "_Memory":
        return cls(
            *distinct_vectors(training.vectors.astype(np.float64), training.behaviours, NUM_BEHAVIOURS)
        )

    def right_with_changes(self, vector: NDArray[np.int64], state: int, diagonal: int) -> tuple[float, ...]:
        """The confidence in the right behaviour with each change to the distance (4.6.1, 4.6.2)."""
        own, corridors = (
            attribute_distances(self.rows, vector, scale) for scale in (diagonal, CORRIDOR_DIAGONAL)
        )
        distances = np.column_stack((own @ _KEPT, corridors.sum(axis=1)))
        # Sums of whole numbers: equal distances are equal exactly.
        votes = (distances == distances.min(axis=0)).T @ self.votes
        return tuple((votes[:, state] / votes.sum(axis=1)).tolist())
