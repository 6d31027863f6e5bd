"""Single rows with changes, and a job that leaves them."""

from typing import Any

from khepera_forage.rollouts.rows import IMITATOR, STATES, RecallRow, TrainingRow
from khepera_forage.study import Job
from khepera_forage.task.decisions import Decisions, decisions_text
from khepera_forage.task.states import State
from khepera_forage.thesis.design import LABORATORY
from khepera_forage.thesis.orient_analysis import OrientRow
from khepera_forage.thesis.replication import JobCounts, Row


def one_row_jobs(seed: int, counts: JobCounts, decisions: Decisions, backend: str) -> list[Job]:
    """In place of `jobs`: a job that leaves one row of each kind."""
    return [Job("one", one_row, (decisions_text(decisions),))]


def one_row(decisions: str) -> list[Row]:
    orient = OrientRow(0, 10, "g1", 0, 1.0, 0.0, 0.0, decisions)
    return [recall(decisions=decisions), training(decisions=decisions), orient]


def recall(**changes: Any) -> RecallRow:
    """A recall in the corridor that delivered after 200 steps, 160 of them correct, with these changes.

    Score, foods and counts are consistent with the other fields unless they are given.
    """
    row: dict[str, Any] = {
        "replication": 0,
        "arena": "corridor",
        "episodes": 10,
        "file_id": "g12345678910",
        "recall": 0,
        "seed": 1,
        "learner": IMITATOR,
        "noise": LABORATORY,
        "steps": 200,
        "correct": 160,
        "limit": 500,
        "poison_home": 0,
        "food_x": (-36.0,),
        "food_y": (0.0,),
        "food_delivered": (True,),
        "start_x": -90.0,
        "start_y": 0.0,
        "start_heading": 10.0,
        "orient_without_food": 0,
        "ties": 50,
        "conflicts": 5,
        "experience_size": 800,
    } | changes
    row.setdefault("foods", len(row["food_delivered"]))
    row.setdefault("delivered", sum(row["food_delivered"]))
    some = 5 if row["delivered"] else 20
    row.setdefault("penalty", 0 if row["delivered"] == row["foods"] else some)
    row.setdefault("score", 100 * row["correct"] / row["steps"] - row["penalty"])
    wrong = row["steps"] - row["correct"]
    row.setdefault("wrong_by_state", counts({State.SEARCH: wrong}))
    rounds = list(row["wrong_by_state"])
    rounds[State.SEARCH] += row["correct"]
    row.setdefault("rounds_by_state", tuple(rounds))
    return RecallRow(**row)


def failed(**changes: Any) -> RecallRow:
    """A recall in the corridor that reached the time limit."""
    return recall(**{"steps": 500, "correct": 300, "food_delivered": (False,)} | changes)


def training(**changes: Any) -> TrainingRow:
    """A complete attempt, or an incomplete one with this `reason`."""
    row: dict[str, Any] = {
        "replication": 0,
        "file": 1,
        "attempt": 1,
        "seed": 1,
        "noise": LABORATORY,
        "rounds": 120,
        "vectors": 110,
        "separations": 1,
        "reason": "",
    } | changes
    row.setdefault("complete", not row["reason"])
    return TrainingRow(**row)


def counts(by_state: dict[State, int]) -> tuple[int, ...]:
    """Ten counts by state; missing ones are zero."""
    return tuple(by_state.get(State(i), 0) for i in range(STATES))
