"""Rows of the experiments: a training episode and a recall episode."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class TrainingEpisode:
    """One complete training episode, with all the attempts it took.

    Attributes:
        replication: Number of the repetition of the whole experiment.
        condition: Of the experiment.
        amount: Number of learners, generation or delay, where the experiment varies one of these; otherwise 1.
        file: Number of the experience file.
        attempts: Up to the complete one.
        rounds: MultiSteps of the complete attempt.
        all_rounds: MultiSteps of all attempts.
        vectors: Experience vectors recorded in the complete attempt.
        true: Vectors among them whose behaviour the teacher of section 4.4 would have chosen on the same state vector.
        separations: Separations in the complete attempt, of all learners together.
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
class RecallEpisode:
    """One recall episode (5.4).

    Attributes:
        replication: Number of the repetition of the whole experiment.
        condition: Of the experiment.
        arena: `corridor` or `rectangle`.
        amount: Training episodes, or the generation or delay; 0 for a policy that learned nothing.
        number: Of the recall.
        seed: Of the episode; the same places for every condition and amount.
        score: Equation 5.1, in percent.
        correct: Steps in which the learner did what the teacher would have done.
        steps: Steps taken.
        foods: Food objects in the arena.
        delivered: Objects brought home, poison not counted.
        avoided: Objects known to be poisonous and not brought home.
        poison_home: Poisonous objects brought home.
        beyond: Distance of the first object from home minus that in training, in pixels.
        vectors: Experience vectors of the learner.
        distinct: Different state vectors among them.
        rounds_by_state: Steps in each of the ten states, as the teacher would classify them.
        wrong_by_state: Steps of each state in which the learner did not do what the teacher would have done.
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


Row = TrainingEpisode | RecallEpisode
TABLES = {TrainingEpisode: "trainings", RecallEpisode: "recalls"}
