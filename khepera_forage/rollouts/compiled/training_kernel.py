"""The training kernel: attempts at training episodes, until they are complete (5.2), without Python in between."""

from typing import Any, NamedTuple

from khepera_forage.compilation.decorators import entrance, inline, kernel, sequence
from khepera_forage.compilation.work_queue import take
from khepera_forage.counter_rng import random_bits
from khepera_forage.envs.compiled.commands import drive, drive_behaviours, raw_data_in
from khepera_forage.envs.compiled.parameters import TaskParameters, arena_map, decision_values, floor
from khepera_forage.envs.compiled.rounds import carry_out, put_down
from khepera_forage.envs.compiled.worlds import Worlds, worlds_of
from khepera_forage.robots.khepera import applicable
from khepera_forage.rollouts.compiled.records import HEARD
from khepera_forage.sim.compiled.parameters import Parameters
from khepera_forage.task.behaviours import command
from khepera_forage.task.episode import has_done_its_part
from khepera_forage.task.food_tracking import share_identified
from khepera_forage.task.pairing import attempt_ends, lead, teacher_says, update_pairing
from khepera_forage.task.placement import draw_food_types, food_type_key, layout_key, place_by_hand
from khepera_forage.task.states import Behaviour, StateVector

TEACHER, LEARNER = 0, 1
"""The two sides of a pair."""
_WAIT = float(Behaviour.WAIT)


class Side(NamedTuple):
    """One side of the pairs: teachers, or learners.

    Attributes:
        worlds: Its worlds.
        parameters: Of the bodies.
        task: Of the task.
        mark: `start_dtype`, shape (1,): where robots are put.
        food_marks: `place_dtype`, shape (foods,): where food is put.
    """

    worlds: Worlds
    parameters: Parameters
    task: TaskParameters
    mark: Any
    food_marks: Any


class Terms(NamedTuple):
    """How an operator goes about it.

    Attributes:
        limit: Rounds after which an attempt is out of time.
        patience: Rounds of separation after which an attempt is given up.
        attempts: Incomplete attempts after which an episode is given up.
        error: Standard deviation with which something is put on its mark, mm.
        heading_error: Of a robot's heading, radians.
    """

    limit: int
    patience: int
    attempts: int
    error: float
    heading_error: float


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
    pair.separated_rounds = pair.separations = pair.rounds = pair.vectors = 0
    free = _put_on_marks(teachers, TEACHER, i, key, terms)
    return _put_on_marks(learners, LEARNER, i, key, terms) and free


@kernel
def _say(teachers: Worlds, learners: Worlds, pairs: Any) -> None:
    """The teachers' decisions, which the learners hear in the same round and execute."""
    robot = teachers.bodies.robots
    for i in range(robot.x.shape[0]):
        # Before its first frame a robot has perceived nothing.
        silent = pairs[i].separated or robot.first_frame[i] != 0.0
        behaviour = teacher_says(int(teachers.tasks.state[i]), silent)
        teachers.tasks.behaviour[i] = learners.tasks.behaviour[i] = behaviour


@kernel
def _record_vectors(task: Any, pairs: Any, diagonal: int, vectors: Any) -> None:
    """Record the learners' own state vectors, each with the behaviour heard; nothing in silence."""
    for i in range(pairs.shape[0]):
        pair = pairs[i]
        if pair.episode < 0 or task.behaviour[i] == _WAIT:
            continue
        row = vectors[pair.episode, pair.vectors]
        row[0] = int(task.object_presence[i])
        row[1] = min(int(task.robot_home_distance[i]), diagonal)
        row[2] = int(task.vector_food_type[i])
        row[3] = int(task.arms_height[i])
        row[4] = min(int(task.robot_food_distance[i]), diagonal)
        row[HEARD] = int(task.behaviour[i])
        pair.vectors += 1


@kernel
def _drive_learners(worlds: Worlds, pairs: Any, task: TaskParameters) -> None:
    """Command what the behaviour heard commands, bent towards the teacher (4.5.2)."""
    robot, known = worlds.bodies.robots, worlds.tasks
    arena, decisions = arena_map(task), decision_values(task)
    for i in range(robot.x.shape[0]):
        behaviour = int(known.behaviour[i])
        own = command(behaviour, raw_data_in(robot, known, i, arena), decisions)
        x, y, orientation = robot.marker_x[i], robot.marker_y[i], robot.marker_heading[i]
        drive(robot, i, applicable(lead(pairs[i], own, behaviour, x, y, orientation, decisions)))


@kernel
def _share_identified(worlds: Worlds, others: Worlds) -> None:
    """Make known on one side what was identified on the other."""
    for i in range(worlds.foods.shape[0]):
        share_identified(worlds.foods[i], others.foods[i])


@inline
def _is_done(worlds: Worlds, i: int, home_radius: float, decisions: Any) -> bool:
    task = worlds.tasks
    vector = StateVector(
        int(task.object_presence[i]),
        int(task.robot_home_distance[i]),
        int(task.vector_food_type[i]),
        int(task.arms_height[i]),
        int(task.robot_food_distance[i]),
    )
    return has_done_its_part(worlds.trackers[i], worlds.foods[i], vector, home_radius, decisions)


@kernel
def _end_round(teachers: Side, learners: Side, pairs: Any, terms: Terms) -> bool:
    """Account for a round of every pair; returns whether any attempt has ended."""
    shown, learning = teachers.worlds, learners.worlds
    teacher, learner = shown.bodies.robots, learning.bodies.robots
    teacher_arena, arena, decisions = (
        arena_map(teachers.task),
        arena_map(learners.task),
        decision_values(teachers.task),
    )
    any_over = False
    for i in range(pairs.shape[0]):
        pair = pairs[i]
        update_pairing(
            pair,
            learner.marker_x[i],
            learner.marker_y[i],
            arena,
            teacher.marker_x[i],
            teacher.marker_y[i],
            teacher.marker_heading[i],
            teacher_arena,
            decisions,
        )
        if shown.tasks.begins[i] != 0.0:
            continue
        pair.rounds += 1
        radius = arena.home_radius
        pair.complete = _is_done(shown, i, radius, decisions) and _is_done(learning, i, radius, decisions)
        ended = attempt_ends(pair.complete, pair.rounds, terms.limit, pair.separated_rounds, terms.patience)
        pair.over = ended and pair.episode >= 0
        any_over = any_over or pair.over
    return any_over


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
    teachers: Side, learners: Side, pairs: Any, terms: Terms, keys: Any, taken: Any, records: Records
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
        _say(shown, learning, pairs)
        _record_vectors(learning.tasks, pairs, diagonal, records.vectors)
        drive_behaviours(shown.bodies.robots, shown.tasks, teachers.task)
        carry_out(shown, teachers.parameters, teachers.task)
        _share_identified(shown, learning)
        _drive_learners(learning, pairs, learners.task)
        carry_out(learning, learners.parameters, learners.task)
        _share_identified(learning, shown)
        over = _end_round(teachers, learners, pairs, terms)


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
    """
    shown = _side_of(teachers, thread)
    learning = _side_of(learners, thread)
    _train(shown, learning, pairs[thread], terms, keys, taken, records)
