"""Rows of the benchmark."""

from dataclasses import dataclass

TEACHER, RANDOM, IMITATOR = "teacher", "random", "imitator"
"""Names of the two bounds, and of the thesis's learner."""
UNTRAINED = "-"
"""Training of a bound."""
AS_IT_IS = "as it is"
"""The imitator's distance without a change."""


@dataclass(frozen=True, slots=True)
class ArenaRecalls:
    """Recalls of one learner in one arena.

    Attributes:
        learner: Its name among the learners; `TEACHER` or `RANDOM`.
        training: A name of `trainings.TRAININGS`; `UNTRAINED` for the bounds.
        distances: The decision `distances`, in training and in recall.
        replication: Number of the repetition, with experience, test levels and recall seeds of its own.
        group: `thesis`, `named` or a difficulty.
        arena: Name of the arena.
        vectors: That the learner learned from, or queries.
        recalls: Number of recalls.
        foods: Food objects in them that are not poisonous.
        delivered: Those that were brought home.
        poison_home: Poisonous food brought home.
        score: Mean score (equation 5.1), percent.
        steps: Of all recalls.
    """

    learner: str
    training: str
    distances: str
    replication: int
    group: str
    arena: str
    vectors: int
    recalls: int
    foods: int
    delivered: int
    poison_home: int
    score: float
    steps: int


@dataclass(frozen=True, slots=True)
class WrongDecisions:
    """Decisions of the imitator along its own recalls, with one change to its distance, in one state.

    The imitator draws behaviours with their confidence levels; wrong decisions are therefore expected numbers.

    Attributes:
        training: A name of `trainings.TRAININGS`.
        replication: Number of the repetition.
        group: Of the arena.
        arena: Name of the arena.
        state: The state in which the decisions were taken.
        change: `AS_IT_IS`, an attribute that is left out of the distance, or another name of `attribution.CHANGES`.
        decisions: Their number.
        wrong: Those that are wrong, expected.
        beyond: Wrong ones at a distance beyond all of the training's, expected.
        still_wrong: Decisions that are wrong when all are drawn again with the change, expected.
        corrected: Wrong decisions that are right when drawn again with the change, expected.
    """

    training: str
    replication: int
    group: str
    arena: str
    state: str
    change: str
    decisions: int
    wrong: float
    beyond: float
    still_wrong: float
    corrected: float
