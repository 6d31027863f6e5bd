"""Synthetic rows: single rows with changes, cells, and whole reproductions."""

from collections.abc import Callable
from functools import partial
from itertools import count
from typing import Any

import numpy as np

from khepera_forage.rollouts.rows import IMITATOR, STATES, TEACHER, RecallRow, TrainingRow
from khepera_forage.study import WorkUnit
from khepera_forage.task.decisions import Decisions, decisions_text
from khepera_forage.task.states import State
from khepera_forage.thesis import figures
from khepera_forage.thesis.design import FILES, LABORATORY, THESIS, Cell
from khepera_forage.thesis.orient_analysis import OrientRow
from khepera_forage.thesis.replication import JobCounts, Row


class OneRowJob:
    """A job that leaves one row of each kind.

    Args:
        decisions: Of the rows.
    """

    def __init__(self, decisions: Decisions) -> None:
        self._decisions = decisions_text(decisions)

    key = "one"

    def run(self) -> list[Row]:
        orient = OrientRow(0, 10, "g1", 0, 1.0, 0.0, 0.0, self._decisions)
        return [recall(decisions=self._decisions), training(decisions=self._decisions), orient]


BY_EPISODES = tuple(
    (
        partial(figures.figure_by_episodes, number, arena, food),
        arena,
        (20 if number == 3 else 24) if food else None,
    )
    for number, arena, food in figures.BY_EPISODES
)
"""Figures with their arena, and the food objects in it."""


def one_row_jobs(seed: int, counts: JobCounts, decisions: Decisions) -> list[WorkUnit]:
    """In place of `jobs.compiled_jobs`."""
    return [OneRowJob(decisions)]


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


def cell_rows(
    cell: Cell,
    replications: int,
    rng: np.random.Generator,
    skill: float,
    success: Callable[[float], float],
    **changes: Any,
) -> list[RecallRow]:
    """Rows of one cell.

    Args:
        cell: The design.
        replications: Their number.
        rng: Draws the rows.
        skill: Mean share of correct steps.
        success: Probability of delivering food, by its distance from home in pixels.
        **changes: Of fields, the same in all rows.
    """
    rows = []
    for replication in range(replications):
        luck = rng.normal(0, 0.04)
        for subset in cell.subsets:
            for number in range(cell.recalls):
                x, y = rng.uniform(-104, 14, cell.foods), rng.uniform(-17, 17, cell.foods)
                x = np.where(np.hypot(x, y) < 20, -40, x)
                done = tuple(bool(rng.random() < success(d) + luck) for d in np.hypot(x, y))
                steps = int(rng.integers(70, cell.limit)) if all(done) else cell.limit
                correct = int(steps * np.clip(rng.normal(skill + luck, 0.12), 0, 1))
                wrong = rng.multinomial(steps - correct, (0.5, 0.1, 0.3, 0.02, 0.02, 0, 0, 0.04, 0.01, 0.01))
                right = rng.multinomial(correct, (0.55, 0.1, 0.1, 0.03, 0.03, 0, 0, 0.15, 0.02, 0.02))
                values = {
                    "replication": replication,
                    "arena": cell.arena,
                    "episodes": cell.episodes,
                    "file_id": subset.name,
                    "recall": number,
                    "seed": int(rng.integers(2**31)),
                    "steps": steps,
                    "correct": correct,
                    "limit": cell.limit,
                    "food_x": tuple(map(float, x)),
                    "food_y": tuple(map(float, y)),
                    "food_delivered": done,
                    "wrong_by_state": tuple(map(int, wrong)),
                    "rounds_by_state": tuple(map(int, wrong + right)),
                    "orient_without_food": int(rng.integers(0, 4)) * (steps - correct > 10),
                    "ties": steps // 3,
                    "conflicts": steps // 20,
                    "experience_size": 90 * cell.episodes,
                }
                rows.append(recall(**values | changes))
    return rows


def reproduction(
    replications: int, rng: np.random.Generator, cells: tuple[Cell, ...] = THESIS
) -> list[RecallRow]:
    """Rows of all cells: scores rise with training, and success is best at the training distance."""
    rows = []
    for cell in cells:
        gain = 1 - np.exp(-cell.episodes / 3)
        rows += cell_rows(
            cell,
            replications,
            rng,
            skill=0.6 + 0.22 * gain - 0.05 * (cell.arena == "rectangle"),
            success=partial(_success, gain),
        )
    return rows


def attempts(replications: int, rng: np.random.Generator, noise: str, complete: float) -> list[TrainingRow]:
    """Attempts at ten files; each attempt is complete with this probability."""
    rows = []
    for replication in range(replications):
        for file in range(1, FILES + 1):
            for attempt in count(1):
                done = bool(rng.random() < complete)
                rows.append(
                    training(
                        replication=replication,
                        file=file,
                        attempt=attempt,
                        seed=int(rng.integers(2**31)),
                        noise=noise,
                        separations=int(rng.integers(0, 3)),
                        reason="" if done else "separated for too long",
                    )
                )
                if done:
                    break
    return rows


def teachers(replications: int, rng: np.random.Generator, arena: str, longest: int) -> list[RecallRow]:
    """Ten forages of the teacher for each replication, with at most `longest` steps."""
    foods = 1 if arena == "corridor" else 2
    return [
        recall(
            replication=replication,
            arena=arena,
            episodes=0,
            file_id="-",
            recall=number,
            learner=TEACHER,
            steps=(steps := int(rng.integers(longest // 3, longest + 1))),
            correct=steps,
            limit=2000,
            food_x=(-36.0,) * foods,
            food_y=(0.0,) * foods,
            food_delivered=(True,) * foods,
            ties=0,
            conflicts=0,
            experience_size=0,
        )
        for replication in range(replications)
        for number in range(10)
    ]


def _success(gain: float, distance: float) -> float:
    return float((0.25 + 0.6 * np.exp(-(((distance - 36) / 15) ** 2))) * (0.4 + 0.6 * gain))
