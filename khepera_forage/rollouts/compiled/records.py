"""The records of rollouts in compiled worlds: decisions, what became of recalls, and training attempts."""

import numpy as np

from khepera_forage.task.states import NUM_BEHAVIOURS, NUM_STATES

decision_dtype = np.dtype(
    [
        ("policy", "i4"),  # number of a memory, or `TEACHER` or `UNIFORM`
        ("query", "i8"),  # state vector of the votes below, as one number; -1 without votes
        ("total", "i4"),  # number of votes
        ("votes", "i4", (NUM_BEHAVIOURS,)),  # for each behaviour
        ("ties", "i4"),  # rounds in which several experience vectors were equally near
        ("conflicts", "i4"),  # rounds with a tie between different behaviours
        # `task.episode.DecisionCounts`.
        ("by_state", "i4", (NUM_STATES,)),
        ("wrong_by_state", "i4", (NUM_STATES,)),
        ("orient_without_food", "i4"),
        ("recall", "i4"),  # number of the recall under way, -1 without one that counts
    ],
    align=True,
)
"""The policy of one world, its latest votes, and the count of its decisions."""

outcome_dtype = np.dtype(
    [
        *((name, "i4") for name in ("steps", "correct", "delivered", "poison_home", "deliverable")),
        *((name, "f8") for name in ("score", "penalty")),
        *((name, "i4") for name in ("ties", "conflicts", "orient_without_food")),
        *((name, "i4", (NUM_STATES,)) for name in ("by_state", "wrong_by_state")),
        ("start", "f8", (3,)),  # x, y (mm) and heading (radians)
    ],
    align=True,
)
"""What became of one recall."""

pair_dtype = np.dtype(
    [
        # `task.pairing.Pairing`.
        ("separated", "?"),
        *((name, "i8") for name in ("separated_rounds", "separations")),
        *((name, "f8") for name in ("teacher_x", "teacher_y", "teacher_orientation")),
        # The attempt under way.
        *((name, "i8") for name in ("rounds", "vectors", "since_done")),
        ("complete", "?"),
        ("over", "?"),
        ("episode", "i8"),  # number of the training episode, -1 without one
        ("attempt", "i8"),  # number of the attempt at it, from 0
    ],
    align=True,
)
"""One teacher and its learner."""

attempt_dtype = np.dtype(
    [("complete", "?"), *((name, "i4") for name in ("rounds", "vectors", "separations"))], align=True
)
"""What became of one attempt at a training episode."""

HEARD = 5
"""Column of the behaviour heard in an experience vector, behind the five attributes."""
VECTOR_COLUMNS = 6
"""Columns of an experience vector."""
