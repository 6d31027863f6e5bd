"""The training phase of the thesis (4.5, 5.2, 5.3) for thousands of learners at once, in compiled paired arenas."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from khepera_forage.compilation import entry, rule, share_out
from khepera_forage.counter_rng import keys_of, random_bits
from khepera_forage.envs.arguments import FoodOdds, checked_decisions, whole_number
from khepera_forage.envs.compiled.arenas import arena_at
from khepera_forage.envs.compiled.pairs import (
    Sides,
    carry_out_pair,
    paired_sides,
    pairing_dtype,
    put_on_marks,
)
from khepera_forage.envs.compiled.step import World, new_worlds
from khepera_forage.envs.layouts import no_room_on_marks
from khepera_forage.noise import Noise, checked_noise
from khepera_forage.rollouts.compiled.training_results import HEARD, Trained, attempt_dtype, trained
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
    decisions, noise = checked_decisions(decisions), checked_noise(noise)
    limit = whole_number("max_cycles", max_cycles, 1)
    most = decisions.most_attempts if attempts is None else whole_number("attempts", attempts, 1)
    arenas, sides, terms = paired_sides(2, arena, noise, food_types, limit, patience, options, decisions)
    learner_keys = keys_of(np.uint64(whole_number("seed", seed, 0)) + np.arange(n, dtype=np.uint64))
    keys = random_bits(learner_keys[:, None], np.arange(1, episodes + 1, dtype=np.uint64)).ravel()
    bytes_each = limit * ((HEARD + 1) * 2 + 4) + most * attempt_dtype.itemsize
    at_once = min(keys.size, max(_LEAST, _ROOM // bytes_each))
    rows = np.empty((at_once, limit, HEARD + 1), np.int16)
    rewards = np.empty((at_once, limit), np.float32)
    records = np.empty((at_once, most), attempt_dtype)
    vectors, gains, lines, tried = [], [], [], []
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
            raise no_room_on_marks(arenas[0], noise)
        done = records[: some.size][np.arange(most) < made[:, None]]
        last = done[np.cumsum(made) - 1]
        if not last["complete"].all():
            raise IncompleteTrainingError(f"none of {most} attempts at a training episode was complete")
        heard = np.arange(limit) < last["vectors"][:, None]
        vectors.append(rows[: some.size][heard])
        gains.append(rewards[: some.size][heard])
        lines.append(done)
        tried.append(made)
    return trained(
        np.concatenate(vectors),
        np.concatenate(gains),
        np.concatenate(lines),
        np.concatenate(tried),
        n,
        limit,
        arenas[0].name,
        seed,
        decisions,
    )


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
    worlds: World,
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
        attempts: One `Attempt` record.
        pairings: Two `Pairing` records; that of the learner counts.
        actions: Two behaviours.
    """
    diagonal = int(arena_at(sides.blocks, sides.places[1]).numbers[0].map_diagonal)
    attempt, pairing, teacher, learner = (
        attempts[0],
        pairings[1],
        worlds.foragers[0, 0],
        worlds.foragers[1, 0],
    )
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
                    _record_vector(learner.vector, behaviour, rows[number, vectors], diagonal)
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


@rule
def _record_vector(vector: Any, behaviour: int, row: Any, diagonal: int) -> None:
    """Record the learner's own state vector with the behaviour heard."""
    row[0], row[1] = vector.object_presence, min(vector.robot_home_distance, diagonal)
    row[2], row[3] = vector.food_type, vector.arms_height
    row[4], row[HEARD] = min(vector.robot_food_distance, diagonal), behaviour
