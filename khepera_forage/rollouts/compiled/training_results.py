"""What comes of training many learners: their experience, and the account of every attempt."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.experience import Experience
from khepera_forage.task.decisions import Decisions

HEARD = 5
"""Column of the behaviour heard in an experience vector, behind the five attributes."""
attempt_dtype = np.dtype(
    [("complete", "?"), *((name, "i4") for name in ("rounds", "vectors", "separations"))], align=True
)
"""What became of one attempt at a training episode."""


class Attempts(NamedTuple):
    """What came of every attempt at every training episode, one element each, in the order of learners and episodes.

    Attributes:
        learner: From 0.
        episode: Of the learner, from 0.
        attempt: At the episode, from 1, up to the one that is complete.
        complete: Whether teacher and learner delivered and left home (5.3).
        rounds: MultiSteps it took.
        vectors: Experience vectors recorded; those of an incomplete attempt are forgotten.
        separations: Times the learner got separated.
        reason: Why it is incomplete, `separated` or `out of time`; empty for a complete one.
    """

    learner: NDArray[np.int64]
    episode: NDArray[np.int64]
    attempt: NDArray[np.int64]
    complete: NDArray[np.bool_]
    rounds: NDArray[np.int64]
    vectors: NDArray[np.int64]
    separations: NDArray[np.int64]
    reason: NDArray[np.str_]


class Trained(NamedTuple):
    """The experience of many learners.

    Attributes:
        experience: One vector a row: the five attributes of the state vector, and the behaviour heard; int16.
        offsets: Where each learner's episodes begin in it, and the last ends: shape (learners, episodes + 1).
        attempts: One element an attempt.
        arena: Name of the arena.
        seed: As given.
        decisions: Of the training.
        rewards: The learner's from each vector to the next, one a row, as in `TrainingEnv`; float32.
    """

    experience: NDArray[np.int16]
    offsets: NDArray[np.int64]
    attempts: Attempts
    arena: str
    seed: int
    decisions: Decisions
    rewards: NDArray[np.float32]

    def vectors_of(self, learner: int, episode: int | None = None) -> NDArray[np.int16]:
        """The rows of one learner, of all its episodes or of one; a view.

        Raises:
            ValueError: There is no such learner, or no such episode.
        """
        return self.experience[self._rows(learner, episode)]

    def _rows(self, learner: int, episode: int | None) -> slice:
        learners, episodes = self.offsets.shape[0], self.offsets.shape[1] - 1
        own = self.offsets[_within("learner", learner, learners)]
        if episode is None:
            return slice(own[0], own[-1])
        episode = _within("episode", episode, episodes)
        return slice(own[episode], own[episode + 1])

    def rewards_of(self, learner: int, episode: int | None = None) -> NDArray[np.float32]:
        """The reward that followed each row of `vectors_of`; a view.

        Raises:
            ValueError: There is no such learner, or no such episode.
        """
        return self.rewards[self._rows(learner, episode)]

    def experience_of(self, learner: int, episode: int | None = None) -> Experience:
        """The same as an `Experience`, which can be saved as a file.

        Raises:
            ValueError: There is no such learner, or no such episode.
        """
        rows = self.vectors_of(learner, episode).tolist()
        episodes = self.offsets.shape[1] - 1 if episode is None else 1
        heard = [row[HEARD] for row in rows]
        return Experience(
            [row[:HEARD] for row in rows], heard, self.arena, self.seed, episodes, self.decisions
        )


def trained(
    vectors: NDArray[np.int16],
    rewards: NDArray[np.float32],
    attempts: NDArray[Any],
    tried: NDArray[np.int64],
    n: int,
    limit: int,
    arena: str,
    seed: int,
    decisions: Decisions,
) -> Trained:
    """What the kernel has written down, learner by learner.

    Args:
        vectors: Of all complete episodes, one after the other.
        rewards: One a vector.
        attempts: `attempt_dtype`, one record an attempt.
        tried: How many attempts there were at each episode.
        n: Learners.
        limit: Rounds after which an attempt was out of time.
        arena: Its name.
        seed: Of all.
        decisions: Of the training.
    """
    episodes = tried.size // n
    number = np.repeat(np.arange(tried.size), tried)
    attempt = np.arange(number.size) - np.repeat(np.cumsum(tried) - tried, tried) + 1
    rounds, complete = attempts["rounds"].astype(np.int64), attempts["complete"]
    ends = np.cumsum(attempts["vectors"][complete]).reshape(n, episodes)
    starts = np.concatenate(([0], ends[:-1, -1]))
    return Trained(
        vectors,
        np.column_stack((starts, ends)),
        Attempts(
            number // episodes,
            number % episodes,
            attempt,
            complete,
            rounds,
            attempts["vectors"].astype(np.int64),
            attempts["separations"].astype(np.int64),
            np.where(complete, "", np.where(rounds < limit, "separated", "out of time")),
        ),
        arena,
        seed,
        decisions,
        rewards,
    )


def _within(name: str, value: int, count: int) -> int:
    if not 0 <= value < count:
        raise ValueError(f"{name} is {value!r}; allowed: 0 to {count - 1}")
    return value
