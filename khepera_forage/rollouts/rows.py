"""The rows of recall episodes and training attempts, from which all results can be recomputed."""

import csv
import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions, decisions_from_text, decisions_text, differences
from khepera_forage.task.states import Behaviour, State

IMITATOR = "imitator"
"""The `learner` of the thesis's nearest-neighbour learner (4.6)."""
TEACHER = "teacher"
"""The `learner` of rows in which the teacher forages alone."""
RANDOM = "random"
"""The `learner` of rows in which every behaviour is drawn uniformly, which measures the chance level."""

STATES = len(Behaviour) - 1
"""Number of states that occur: 0..9 in the order of table 4.1."""


@dataclass(frozen=True, slots=True)
class RecallRow:
    """One recall episode (5.4), or one forage of the teacher or of a random policy under the same conditions.

    Places are in pixels of 5 mm from the centre of the home: x along the arena (training starts at negative x), y
    across it. The food fields have one value for each food object, in the same order.

    Attributes:
        replication: Number of the repetition of the whole design, its own training files included.
        arena: Name of the arena.
        episodes: Training episodes of the learner; 0 for a policy without training.
        file_id: The thesis's name of the training files (`g135`); `-` for a policy without training.
        recall: Number of the recall with these files, from 0.
        seed: Reproduces this episode.
        learner: `imitator`, `teacher`, `random`, or the name of another learner.
        noise: Name of the noise condition, see `design.noise_conditions`.
        correct: Steps in which the learner executed the teacher's behaviour.
        steps: Steps until every food was delivered or known poisonous, or the limit was reached.
        limit: Time limit in steps.
        penalty: 0, 5 or 20 percentage points for uncollected food.
        score: 100 * correct / steps - penalty (equation 5.1), in percent.
        delivered: Food objects carried home, without poisonous ones.
        foods: Food objects in the arena.
        poison_home: Poisonous objects carried home.
        food_x: Place of each object at the start, along the arena.
        food_y: The same, across the arena.
        food_delivered: Whether each object was delivered; False for poisonous ones.
        start_x: Place of the robot at the start, along the arena.
        start_y: The same, across the arena.
        start_heading: In degrees, 0 along x.
        rounds_by_state: Rounds in each state, as the teacher classifies it, in the order of table 4.1.
        wrong_by_state: Rounds of each state in which the learner did not execute the teacher's behaviour.
        orient_without_food: Rounds in which the learner, unlike the teacher, executed ORIENT WITH FOOD without
            candidate food within the close threshold.
        ties: Rounds in which several experience vectors were equally near.
        conflicts: Rounds with a tie between different behaviours.
        experience_size: Number of the learner's experience vectors.
        decisions: Those of the environment, as in `v1;next_to_food=17`; empty for version 0.1 (`task.decisions`).

    Raises:
        ValueError: Fields that contradict each other.
    """

    replication: int
    arena: str
    episodes: int
    file_id: str
    recall: int
    seed: int
    learner: str
    noise: str
    correct: int
    steps: int
    limit: int
    penalty: int
    score: float
    delivered: int
    foods: int
    poison_home: int
    food_x: tuple[float, ...]
    food_y: tuple[float, ...]
    food_delivered: tuple[bool, ...]
    start_x: float
    start_y: float
    start_heading: float
    rounds_by_state: tuple[int, ...]
    wrong_by_state: tuple[int, ...]
    orient_without_food: int
    ties: int
    conflicts: int
    experience_size: int
    decisions: str = ""

    def __post_init__(self) -> None:
        wrong, steps = self.steps - self.correct, self.steps
        require_field(1 <= steps <= self.limit, self, "steps", f"1..limit, which is {self.limit}")
        require_field(0 <= self.correct <= steps, self, "correct", f"0..steps, which is {steps}")
        score = 100.0 * self.correct / steps - self.penalty
        require_field(math.isclose(self.score, score, abs_tol=1e-6), self, "score", f"{score:.6f}")
        for name in ("food_x", "food_y", "food_delivered"):
            fits = len(getattr(self, name)) == self.foods
            require_field(fits, self, name, f"one value for each of {self.foods} foods")
        delivered = sum(self.food_delivered)
        require_field(self.delivered == delivered, self, "delivered", f"{delivered}, the sum of food_delivered")
        for name, total in (("rounds_by_state", steps), ("wrong_by_state", wrong)):
            counts = getattr(self, name)
            valid = len(counts) == STATES and min(counts) >= 0 and sum(counts) == total
            require_field(valid, self, name, f"{STATES} counts that add up to {total}")
        for state, (rounds, mistaken) in enumerate(zip(self.rounds_by_state, self.wrong_by_state, strict=True)):
            if mistaken > rounds:
                raise ValueError(f"wrong_by_state[{state}] is {mistaken}; allowed: at most {rounds}, its rounds")
        fits = 0 <= self.orient_without_food <= wrong
        require_field(fits, self, "orient_without_food", f"0..{wrong} wrong rounds")
        require_field(0 <= self.ties <= steps, self, "ties", f"0..{steps} steps")
        require_field(0 <= self.conflicts <= self.ties, self, "conflicts", f"0..{self.ties} ties")
        row_decisions(self.decisions)

    @property
    def food_home_distances(self) -> tuple[float, ...]:
        """Distance of each food object from the centre of the home at the start, in pixels."""
        return tuple(math.hypot(x, y) for x, y in zip(self.food_x, self.food_y, strict=True))

    @property
    def orient_wanted(self) -> int:
        """Rounds in which ORIENT WITH FOOD is the teacher's behaviour."""
        return self.rounds_by_state[State.NEXT_TO_FOOD]

    @property
    def orient_missed(self) -> int:
        """Rounds in which ORIENT WITH FOOD is the teacher's behaviour, and the learner executed another."""
        return self.wrong_by_state[State.NEXT_TO_FOOD]

    @property
    def failed(self) -> bool:
        """Whether food was left that should have been delivered."""
        return self.penalty > 0

    @property
    def failure_mode(self) -> State | None:
        """The state with most wrong rounds of a failed recall, the first of several; None without wrong rounds."""
        most = max(self.wrong_by_state)
        return State(self.wrong_by_state.index(most)) if self.failed and most > 0 else None


@dataclass(frozen=True, slots=True)
class TrainingRow:
    """One attempt at a training episode (5.3).

    Attributes:
        replication: Number of the repetition of the whole design.
        file: Number of the training file, 1..10.
        attempt: Number of the attempt at this file, from 1; the last one is complete.
        seed: Reproduces this attempt.
        noise: Name of the noise condition.
        complete: Whether teacher and learner both delivered their food and left home.
        rounds: Number of MultiSteps.
        vectors: Number of recorded experience vectors.
        separations: How often the teacher began to wait for the learner.
        reason: Why the attempt is incomplete; empty for a complete one.
        decisions: As in `RecallRow`.

    Raises:
        ValueError: Fields that contradict each other.
    """

    replication: int
    file: int
    attempt: int
    seed: int
    noise: str
    complete: bool
    rounds: int
    vectors: int
    separations: int
    reason: str
    decisions: str = ""

    def __post_init__(self) -> None:
        require_field(self.file >= 1, self, "file", "1 or more")
        require_field(self.attempt >= 1, self, "attempt", "1 or more")
        require_field(self.rounds >= 0, self, "rounds", "0 or more")
        require_field(0 <= self.vectors <= self.rounds, self, "vectors", f"0..{self.rounds} rounds")
        require_field(self.separations >= 0, self, "separations", "0 or more")
        require_field(bool(self.reason) != self.complete, self, "reason", "empty if and only if complete")
        row_decisions(self.decisions)


@lru_cache(maxsize=1024)
def row_decisions(text: str) -> Decisions:
    """The decisions that the column `decisions` of a row describes.

    Raises:
        ValueError: Not of the form of `task.decisions.decisions_text`.
    """
    return decisions_from_text(text)


def require_field(valid: bool, row: object, name: str, allowed: str) -> None:
    """Refuse the value of a field unless it is valid."""
    if not valid:
        raise ValueError(f"{name} is {getattr(row, name)!r}; allowed: {allowed}")


def common_decisions(*tables: Iterable[Any]) -> Decisions:
    """The decisions of all rows of some tables; the defaults without rows.

    Raises:
        ValueError: Rows of different decisions.
    """
    texts = list(dict.fromkeys(row.decisions for table in tables for row in table))
    first, *others = [row_decisions(text) for text in texts] or [DEFAULT_DECISIONS]
    for other in others:
        if other != first:
            raise ValueError(
                f"rows of different decisions: {differences(other, first)}; "
                "allowed: rows of the same decisions in one report"
            )
    return first


def refuse_other_decisions(path: Path, decisions: Decisions) -> None:
    """Check that an existing file of rows may be replaced by rows of certain decisions.

    Only the first row is read. A file without a column `decisions`, which version 0.1 wrote, is of the decisions of
    version 0.1. A file without rows, or that does not exist, is of none.

    Raises:
        ValueError: The file has rows of other decisions.
    """
    if not path.exists():
        return
    with open(path, encoding="utf-8", newline="") as file:
        row = next(csv.DictReader(file), None)
    if row is None:
        return
    try:
        found = row_decisions(row.get("decisions") or "")
    except ValueError as error:
        raise ValueError(f"{path}:2: {error}") from error
    if found != decisions:
        raise ValueError(
            f"{path} has rows of other decisions: {differences(found, decisions)}; allowed: the same decisions "
            f"(now {decisions_text(decisions)}), another --out, or no such file"
        )
