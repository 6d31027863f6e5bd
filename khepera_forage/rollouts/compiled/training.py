"""The training phase of the thesis (4.5, 5.2, 5.3) for thousands of learners at once, in compiled paired arenas."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from khepera_forage.compilation import entry, rule, share_out
from khepera_forage.counter_rng import keys_of, random_bits
from khepera_forage.envs.arguments import FoodOdds, Settings, whole_number
from khepera_forage.envs.compiled.arenas import MOST_ROUNDS
from khepera_forage.envs.compiled.pairs import Sides, carry_out_pair, paired_sides, pairing_dtype, put_on_marks
from khepera_forage.envs.compiled.step import WorldRecords, new_worlds
from khepera_forage.envs.layouts import no_room_on_marks
from khepera_forage.experience import Experience
from khepera_forage.noise import Noise
from khepera_forage.policies.policy import HEARD
from khepera_forage.rollouts.training import IncompleteTrainingError
from khepera_forage.sim.arena import Arena
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.pairing import teacher_says
from khepera_forage.task.states import Behaviour

_WAIT = Behaviour.WAIT.value
_ROOM = 1 << 28
"""Bytes of records that are kept open at a time, at most."""
_LEAST = 8
"""Training episodes for which another thread pays."""


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
        return Experience([row[:HEARD] for row in rows], heard, self.arena, self.seed, episodes, self.decisions)


def train_learners(
    n: int,
    arena: Arena | str = "corridor",
    seed: int = 0,
    *,
    noise: Noise | str | None = "laboratory",
    food_types: FoodOdds = None,
    max_cycles: int = 600,
    patience: int | None = None,
    episodes: int = 1,
    attempts: int | None = None,
    options: Mapping[str, Any] | None = None,
    decisions: Decisions | None = None,
) -> Trained:
    """Train learners side by side, each in paired arenas of its own with a teacher of its own.

    Each episode is demonstrated "as if it was the first time" until it is complete (5.2): robots and food on their
    marks as well as an operator can put them there, the teacher shouting and waiting, the learner recording its own
    state vector with each behaviour it hears, executing it, and following. What incomplete attempts recorded is
    forgotten. One learner hears one teacher; for several learners of the same teacher take `paired_corridors_v1`.

    Args:
        n: How many learners.
        arena: As for the environments; its copy must fit beside it under the camera.
        seed: Episode k of learner i of a seed is the same whatever else is asked for.
        noise: The laboratory's troubles.
        food_types: One type, or odds by type; corresponding food is of one type.
        max_cycles: Rounds after which an attempt is out of time.
        patience: Rounds of separation after which one is given up.
        episodes: Complete training episodes of each learner.
        attempts: Incomplete ones of an episode after which it is hopeless.
        options: `start` (x mm, y mm, heading degrees) and `foods`, one (x mm, y mm) an object: other marks than those
            of figure 5.1, in the teacher's arena.
        decisions: Ours by default.

    Raises:
        ValueError: An argument out of range, or marks with no room.
        IncompleteTrainingError: No attempt at a training episode was complete.
    """
    n, episodes = whole_number("n", n, 1), whole_number("episodes", episodes, 1)
    settings = Settings.of(arena, noise, food_types, decisions)
    decisions = settings.decisions
    limit = whole_number("max_cycles", max_cycles, 1, MOST_ROUNDS)
    most = decisions.most_attempts if attempts is None else whole_number("attempts", attempts, 1)
    arenas, sides, terms = paired_sides(2, settings, limit, patience, options)
    first_seed = whole_number("seed", seed, 0)
    learner_keys = keys_of(range(first_seed, first_seed + n))
    keys = random_bits(learner_keys[:, None], np.arange(1, episodes + 1, dtype=np.uint64)).ravel()
    bytes_each = limit * ((HEARD + 1) * 2 + 4) + most * attempt_dtype.itemsize
    at_once = min(keys.size, max(_LEAST, _ROOM // bytes_each))
    rows = np.empty((at_once, limit, HEARD + 1), np.int16)
    rewards = np.empty((at_once, limit), np.float32)
    records = np.empty((at_once, most), attempt_dtype)
    parts: list[tuple[NDArray[Any], ...]] = []
    for first in range(0, keys.size, at_once):
        some = keys[first : first + at_once]
        made, free = np.zeros(some.size, np.int64), np.ones(some.size, np.bool_)
        share_out(
            _train,
            some.size,
            *(sides, some, rows, rewards, records, made, free),
            scratch=lambda: (
                new_worlds(2, len(arenas[0].foods)),
                terms.copy(),
                np.zeros(2, pairing_dtype),
                np.zeros(2, np.int64),
            ),
            least=_LEAST,
        )
        if not free.all():
            raise no_room_on_marks(arenas[0], settings.noise)
        done = records[: some.size][np.arange(most) < made[:, None]]
        last = done[np.cumsum(made) - 1]
        if not last["complete"].all():
            raise IncompleteTrainingError(f"none of {most} attempts at a training episode was complete")
        heard = np.arange(limit) < last["vectors"][:, None]
        parts.append((rows[: some.size][heard], rewards[: some.size][heard], done, made))
    vectors, gains, done, tried = map(np.concatenate, zip(*parts, strict=True))
    ends = np.cumsum(done["vectors"][done["complete"]]).reshape(n, episodes)
    offsets = np.column_stack((np.concatenate(([0], ends[:-1, -1])), ends))
    made_attempts = _attempts_of(done, tried, episodes, limit)
    return Trained(vectors, offsets, made_attempts, arenas[0].name, seed, decisions, gains)


@entry
def _train(
    first: int,
    last: int,
    sides: Sides,
    keys: Any,
    rows: Any,
    rewards: Any,
    records: Any,
    made: Any,
    free: Any,
    worlds: WorldRecords,
    attempts: Any,
    pairings: Any,
    actions: Any,
) -> None:
    """Train the episodes from `first` to `last`, attempt by attempt until one is complete.

    Args:
        first: Number of an episode.
        last: Number after the last one.
        sides: Of teacher and learner.
        keys: Of the random numbers of each episode.
        rows: Experience vectors of the last attempt at each episode, shape (episodes, rounds, 6).
        rewards: The learner's, from each of them to the next, shape (episodes, rounds).
        records: `attempt_dtype`, shape (episodes, attempts).
        made: How many attempts at each episode there were.
        free: Whether robots and food found room on their marks.
        worlds: Two of them, the teacher's and the learner's.
        attempts: One `AttemptState` record.
        pairings: Two `Pairing` records; that of the learner counts.
        actions: Two behaviours.
    """
    attempt, pairing, teacher, learner = (attempts[0], pairings[1], worlds.foragers[0, 0], worlds.foragers[1, 0])
    for number in range(first, last):
        for k in range(records.shape[1]):
            room = put_on_marks(worlds, 0, sides, attempt, pairings, random_bits(keys[number], k))
            free[number] = free[number] and room
            rewards[number] = 0.0
            vectors, ended = 0, False
            while not ended:
                # The learner hears the teacher's decision in the same round, and executes it.
                behaviour = teacher_says(teacher.state, pairing.separated or worlds.robots[0, 0].first_frame)
                if behaviour != _WAIT:
                    _record_vector(learner.vector, behaviour, rows[number, vectors])
                    vectors += 1
                actions[0] = actions[1] = behaviour
                ended = carry_out_pair(worlds, 0, sides, attempt, pairings, actions)
                rewards[number, max(vectors - 1, 0)] += learner.episode.reward
            record = records[number, k]
            record.complete, record.rounds, record.vectors = attempt.complete, attempt.rounds, vectors
            record.separations = pairing.separations
            made[number] = k + 1
            if attempt.complete:
                break


def _attempts_of(done: NDArray[Any], tried: NDArray[np.int64], episodes: int, limit: int) -> Attempts:
    """What the kernel has written down of the attempts.

    Args:
        done: `attempt_dtype`, one record an attempt, in the order of learners and episodes.
        tried: How many attempts there were at each episode.
        episodes: Of each learner.
        limit: Rounds after which an attempt was out of time.
    """
    number = np.repeat(np.arange(tried.size), tried)
    complete, rounds = done["complete"], done["rounds"].astype(np.int64)
    return Attempts(
        number // episodes,
        number % episodes,
        np.arange(number.size) - np.repeat(np.cumsum(tried) - tried, tried) + 1,
        complete,
        rounds,
        done["vectors"].astype(np.int64),
        done["separations"].astype(np.int64),
        np.where(complete, "", np.where(rounds < limit, "separated", "out of time")),
    )


@rule
def _record_vector(vector: Any, behaviour: int, row: Any) -> None:
    """Record the learner's own state vector with the behaviour heard."""
    row[0], row[1], row[2] = vector.object_presence, vector.robot_home_distance, vector.food_type
    row[3], row[4], row[HEARD] = vector.arms_height, vector.robot_food_distance, behaviour


def _within(name: str, value: int, count: int) -> int:
    if not 0 <= value < count:
        raise ValueError(f"{name} is {value!r}; allowed: 0 to {count - 1}")
    return value
