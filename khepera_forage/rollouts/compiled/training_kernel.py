"""The training kernel: attempts at training episodes, until they are complete (5.2), without Python in between."""

from typing import Any, NamedTuple

from khepera_forage.compilation.decorators import entrance, inline, kernel, sequence
from khepera_forage.compilation.work_queue import take
from khepera_forage.counter_rng import random_bits
from khepera_forage.envs.compiled.commands import drive_behaviours
from khepera_forage.envs.compiled.parameters import floor
from khepera_forage.envs.compiled.rounds import carry_out, put_down
from khepera_forage.envs.compiled.worlds import worlds_of
from khepera_forage.rollouts.compiled.training_rounds import (
    Side,
    Terms,
    drive_learners,
    end_round,
    record_vectors,
    say,
    share_food_types,
)
from khepera_forage.task.placement import draw_food_types, food_type_key, layout_key, place_by_hand

TEACHER, LEARNER = 0, 1
"""The two sides of a pair."""


class Records(NamedTuple):
    """What is recorded of training episodes, one row each.

    Attributes:
        vectors: Those of the last attempt, shape (episodes, rounds, `VECTOR_COLUMNS`).
        attempts: `attempt_dtype`, shape (episodes, attempts).
        tried: How many attempts there were.
        free: Whether robots and food found room on their marks.
    """

    vectors: Any
    attempts: Any
    tried: Any
    free: Any


@sequence  # compiled functions cannot return records within a tuple
def _side_of(side: Side, thread: int) -> Side:
    """The worlds of one thread."""
    worlds = worlds_of(side.worlds, thread, thread)
    return Side(worlds, side.parameters, side.task, side.mark, side.food_marks)


@kernel
def _put_on_marks(side: Side, number: int, i: int, key: Any, terms: Terms) -> bool:
    """Put robot and food of one side on their marks; returns whether there was room."""
    worlds, arena, robot = side.worlds, side.task.arena[0], side.worlds.bodies.robots
    robot.key[i] = random_bits(key, number)
    robot.round[i] = 0
    free = place_by_hand(
        worlds.starts[0],
        worlds.places,
        random_bits(layout_key(key, 0), number),
        side.mark[0],
        side.food_marks,
        terms.error,
        terms.heading_error,
        floor(side.task),
    )
    put_down(worlds, i, side.parameters)
    draw_food_types(worlds.foods[i], food_type_key(key, 0), arena.odds)
    return bool(free)


@kernel
def _begin_attempt(teachers: Side, learners: Side, pair: Any, i: int, key: Any, terms: Terms) -> bool:
    """Begin an attempt in one lane; returns whether there was room."""
    pair.separated = pair.complete = pair.over = False
    pair.separated_rounds = pair.separations = pair.rounds = pair.vectors = pair.since_done = 0
    free = _put_on_marks(teachers, TEACHER, i, key, terms)
    return _put_on_marks(learners, LEARNER, i, key, terms) and free


@inline
def _record_attempt(pair: Any, records: Records) -> None:
    attempt = records.attempts[pair.episode, pair.attempt]
    attempt.complete = pair.complete
    attempt.rounds, attempt.vectors, attempt.separations = pair.rounds, pair.vectors, pair.separations
    records.tried[pair.episode] = pair.attempt + 1


@kernel
def _next_attempts(
    teachers: Side, learners: Side, pairs: Any, terms: Terms, keys: Any, taken: Any, records: Records
) -> int:
    """Begin the next attempt, or the next episode, in every lane whose attempt is over.

    Returns:
        By how many lanes those that train an episode have become more.
    """
    change = 0
    for i in range(pairs.shape[0]):
        pair = pairs[i]
        if not pair.over:
            continue
        if pair.episode >= 0:
            _record_attempt(pair, records)
            change -= 1
        pair.attempt += 1
        if pair.episode < 0 or pair.complete or pair.attempt == terms.attempts:
            coming = take(taken)
            pair.episode, pair.attempt = coming if coming < keys.shape[0] else -1, 0
        pair.over = False
        if pair.episode >= 0:
            change += 1
            key = random_bits(keys[pair.episode], pair.attempt)
            if not _begin_attempt(teachers, learners, pair, i, key, terms):
                records.free[pair.episode] = False
    return change


@sequence
def _train(
    teachers: Side,
    learners: Side,
    pairs: Any,
    terms: Terms,
    keys: Any,
    taken: Any,
    records: Records,
    advance: int,
) -> None:
    """Train episodes in one block of pairs, until no thread finds another."""
    for i in range(pairs.shape[0]):
        # A lane without an episode holds robots at rest, far from anything.
        pairs[i].over = pairs[i].complete = True
        pairs[i].episode, pairs[i].attempt = -1, -1
    over, training = True, 0
    diagonal = int(learners.task.arena[0].map_diagonal)
    shown, learning = teachers.worlds, learners.worlds
    while over or training > 0:
        if over:
            training += _next_attempts(teachers, learners, pairs, terms, keys, taken, records)
        say(shown, learning, pairs)
        record_vectors(learning.tasks, pairs, diagonal, records.vectors)
        drive_behaviours(shown, teachers.task)
        _carry_out(teachers, advance)
        share_food_types(shown, learning)
        drive_learners(learning, pairs, learners.task)
        _carry_out(learners, advance)
        share_food_types(learning, shown)
        over = end_round(teachers, learners, pairs, terms)


@kernel
def _carry_out(side: Side, advance: int) -> None:
    """One round of bodies and task on one side; compiled once for both."""
    carry_out(side.worlds, side.parameters, side.task, advance)


@entrance
def train_all(
    thread: int,
    teachers: Side,
    learners: Side,
    pairs: Any,
    terms: Terms,
    keys: Any,
    taken: Any,
    records: Records,
    advance: int,
) -> None:
    """Train episodes in the block of one thread, until all are taken.

    Args:
        thread: Number of the thread, and of its block.
        teachers: Their side, all blocks.
        learners: Their side, all blocks.
        pairs: `pair_dtype`, shape (blocks, lanes).
        terms: How an operator goes about it.
        keys: Of each training episode.
        taken: A single number: how many episodes all threads have begun.
        records: What is recorded.
        advance: Address of `advance_block`.
    """
    shown = _side_of(teachers, thread)
    learning = _side_of(learners, thread)
    _train(shown, learning, pairs[thread], terms, keys, taken, records, advance)
