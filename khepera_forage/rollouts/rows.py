"""What is kept of every training attempt and every recall episode: enough to recompute it all."""

import math
from dataclasses import dataclass

from khepera_forage.task.states import Behaviour, State

IMITATOR = "imitator"
"""The `learner` of the thesis' nearest-neighbour learner (4.6)."""
TEACHER = "teacher"
"""The `learner` of rows in which the teacher forages alone."""
RANDOM = "random"
"""The `learner` of rows in which every behaviour is drawn uniformly: the chance level."""

STATES = len(Behaviour) - 1
"""States that occur, 0..9 in the order of table 4.1."""


@dataclass(frozen=True, slots=True)
class RecallRow:
    """One recall episode (5.4), or one forage of the teacher or of a random policy under the same conditions.

    Places are in pixels of 5 mm from the centre of the home: x along the arena (the start of training lies at
    negative x), y across it. One value per food object stands in each of the food fields, in the same order.

    Attributes:
        replication: Number of the repetition of the whole design, its own training files included.
        arena: `corridor` or `rectangle`.
        episodes: Training episodes the learner had; 0 for who needs none.
        file_id: The thesis' name of the training files used (`g135`); `-` for who needs none.
        recall: Number of the recall with these files, from 0.
        seed: Reproduces this episode.
        learner: `imitator`, `teacher`, `random`, or the name of another learner.
        noise: Name of the noise condition, see `design.noise_conditions`.
        correct: Steps in which the learner did what the teacher would have done.
        steps: Steps until every food was delivered or known poisonous, or the limit was reached.
        limit: Time limit in steps.
        penalty: 0, 5 or 20 percentage points for uncollected food.
        score: 100 * correct / steps - penalty (equation 5.1), in percent.
        delivered: Food objects carried home, poison not counted.
        foods: Food objects in the arena.
        poison_home: Poisonous objects brought home.
        food_x: Where each object lay at the start.
        food_y: The same, across the arena.
        food_delivered: Whether each object was delivered, False for poison.
        start_x: Where the robot started.
        start_y: The same, across the arena.
        start_heading: In degrees, 0 along x.
        rounds_by_state: Rounds in each state as the teacher would classify it, in the order of table 4.1.
        wrong_by_state: Rounds of each state in which the learner did not do what the teacher would have done.
        orient_ghost: Rounds in which ORIENT WITH FOOD was executed although the teacher would not have, and
            no candidate food was within the close threshold.
        ties: Rounds in which several experience vectors were equally near.
        conflicts: Rounds with a tie between different behaviours.
        experience_size: Experience vectors the learner had.

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
    orient_ghost: int
    ties: int
    conflicts: int
    experience_size: int

    def __post_init__(self) -> None:
        _require(1 <= self.steps <= self.limit, "steps", self.steps, f"1..limit, which is {self.limit}")
        _require(0 <= self.correct <= self.steps, "correct", self.correct, f"0..steps, which is {self.steps}")
        score = 100.0 * self.correct / self.steps - self.penalty
        _require(math.isclose(self.score, score, abs_tol=1e-6), "score", self.score, f"{score:.6f}")
        for name in ("food_x", "food_y", "food_delivered"):
            values = getattr(self, name)
            _require(len(values) == self.foods, name, values, f"one value for each of {self.foods} foods")
        sure = sum(self.food_delivered)
        _require(self.delivered == sure, "delivered", self.delivered, f"{sure}, by food_delivered")
        for name, total in (("rounds_by_state", self.steps), ("wrong_by_state", self.steps - self.correct)):
            counts = getattr(self, name)
            right = len(counts) == STATES and min(counts) >= 0 and sum(counts) == total
            _require(right, name, counts, f"{STATES} counts that add up to {total}")
        for state, (rounds, wrong) in enumerate(zip(self.rounds_by_state, self.wrong_by_state, strict=True)):
            _require(wrong <= rounds, f"wrong_by_state[{state}]", wrong, f"at most {rounds}, all its rounds")
        wrong = self.steps - self.correct
        _require(
            0 <= self.orient_ghost <= wrong, "orient_ghost", self.orient_ghost, f"0..{wrong} wrong rounds"
        )
        _require(0 <= self.ties <= self.steps, "ties", self.ties, f"0..{self.steps} steps")
        _require(0 <= self.conflicts <= self.ties, "conflicts", self.conflicts, f"0..{self.ties} ties")

    @property
    def food_home_distances(self) -> tuple[float, ...]:
        """Distance of each food object from the centre of the home at the start, in pixels."""
        return tuple(math.hypot(x, y) for x, y in zip(self.food_x, self.food_y, strict=True))

    @property
    def orient_wanted(self) -> int:
        """Rounds in which the teacher would have executed ORIENT WITH FOOD."""
        return self.rounds_by_state[State.NEXT_TO_FOOD]

    @property
    def orient_missed(self) -> int:
        """Rounds of these in which the learner did something else."""
        return self.wrong_by_state[State.NEXT_TO_FOOD]

    @property
    def failed(self) -> bool:
        """Whether food was left that should have been collected."""
        return self.penalty > 0

    @property
    def failure_mode(self) -> State | None:
        """The state in which a failed recall went wrong most often; the earliest of several, None if none."""
        most = max(self.wrong_by_state)
        return State(self.wrong_by_state.index(most)) if self.failed and most > 0 else None


@dataclass(frozen=True, slots=True)
class TrainingRow:
    """One attempt at a training episode (5.3).

    Attributes:
        replication: Number of the repetition of the whole design.
        file: Number of the training file it was for, 1..10.
        attempt: From 1, up to the one that is complete.
        seed: Reproduces this attempt.
        noise: Name of the noise condition.
        complete: Whether teacher and learner both delivered and left home.
        rounds: MultiSteps it took.
        vectors: Experience vectors recorded.
        separations: Times the teacher began to wait for the learner.
        reason: Why an incomplete attempt ended; empty for a complete one.

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

    def __post_init__(self) -> None:
        _require(self.file >= 1, "file", self.file, "1 or more")
        _require(self.attempt >= 1, "attempt", self.attempt, "1 or more")
        _require(self.rounds >= 0, "rounds", self.rounds, "0 or more")
        _require(0 <= self.vectors <= self.rounds, "vectors", self.vectors, f"0..{self.rounds} rounds")
        _require(self.separations >= 0, "separations", self.separations, "0 or more")
        _require(bool(self.reason) != self.complete, "reason", self.reason, "empty if and only if complete")


def _require(fine: bool, name: str, value: object, allowed: str) -> None:
    if not fine:
        raise ValueError(f"{name} is {value!r}; allowed: {allowed}")
