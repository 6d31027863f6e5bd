"""What is kept of every lesson and every recall of an experiment, and how much of them there is."""

from dataclasses import dataclass
from typing import NamedTuple


@dataclass(frozen=True, slots=True)
class Lesson:
    """One complete training episode, with all the attempts it took.

    Attributes:
        replication: Number of the repetition of the whole experiment.
        condition: What was done differently.
        amount: The experiment's own count: learners at once, or generation; otherwise 1.
        file: Number of the experience file.
        attempts: Up to the complete one.
        rounds: MultiSteps of the complete one.
        all_rounds: MultiSteps of all attempts.
        vectors: Experience vectors recorded in the complete one.
        true: Those of them whose behaviour the teacher of section 4.4 would have chosen on that very state vector.
        separations: Times a learner got separated in the complete one, all learners together.
    """

    replication: int
    condition: str
    amount: int
    file: int
    attempts: int
    rounds: int
    all_rounds: int
    vectors: int
    true: int
    separations: int


@dataclass(frozen=True, slots=True)
class Recalled:
    """One recall episode (5.4).

    Attributes:
        replication: Number of the repetition of the whole experiment.
        condition: What was done differently.
        arena: `corridor` or `rectangle`.
        amount: Training episodes, or the generation; 0 for who learned nothing.
        number: Of the recall.
        seed: Of the episode; the same places for every condition and amount.
        score: Equation 5.1, in percent.
        correct: Steps in which the learner did what the teacher would have done.
        steps: Steps taken.
        foods: Food objects in the arena.
        delivered: Objects brought home, poison not counted.
        avoided: Objects known to be poisonous and not brought home.
        poison_home: Poisonous objects brought home.
        beyond: How much further from home than in training the first object lay, in pixels.
        vectors: Experience vectors of the learner.
        distinct: Different state vectors among them.
        rounds_by_state: Steps in each of the ten states, as the teacher would classify them.
        wrong_by_state: Those of them in which the learner did not do what the teacher would have done.
    """

    replication: int
    condition: str
    arena: str
    amount: int
    number: int
    seed: int
    score: float
    correct: int
    steps: int
    foods: int
    delivered: int
    avoided: int
    poison_home: int
    beyond: float
    vectors: int
    distinct: int
    rounds_by_state: tuple[int, ...]
    wrong_by_state: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Done:
    """Rows of one piece of work, or of all."""

    lessons: tuple[Lesson, ...] = ()
    recalls: tuple[Recalled, ...] = ()


class Size(NamedTuple):
    """How much is done.

    Attributes:
        replications: Repetitions of the whole experiment, new training files included.
        files: Most training episodes of a learner.
        recalls: Recall episodes of each learner in each arena.
        generations: Of a chain.
        attempts: At a lesson, after which it is given up as hopeless.
    """

    replications: int
    files: int = 10
    recalls: int = 4
    generations: int = 5
    attempts: int = 100

    @property
    def amounts(self) -> tuple[int, ...]:
        """Numbers of training episodes after which a learner is looked at: the thesis', as far as files go."""
        return tuple(n for n in (1, 3, 5, 10) if n <= self.files)


class Unit(NamedTuple):
    """One piece of work.

    Attributes:
        seed: Of the whole run.
        replication: From 0.
        condition: One of the experiment's.
        size: Of the whole experiment.
    """

    seed: int
    replication: int
    condition: str
    size: Size
