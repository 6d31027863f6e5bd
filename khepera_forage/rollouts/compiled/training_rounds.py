"""One round of training in every pair of a block: what is said, recorded, driven, and how the round ends (4.5)."""

from typing import Any, NamedTuple

from khepera_forage.compilation.decorators import inline, kernel
from khepera_forage.envs.compiled.commands import drive
from khepera_forage.envs.compiled.parameters import TaskParameters, arena_map
from khepera_forage.envs.compiled.raw_data import raw_data_in
from khepera_forage.envs.compiled.ways_home import find_ways_home
from khepera_forage.envs.compiled.worlds import Worlds
from khepera_forage.robots.khepera import applicable
from khepera_forage.rollouts.compiled.records import HEARD
from khepera_forage.sim.compiled.parameters import Parameters
from khepera_forage.task.behaviours import command
from khepera_forage.task.episode import has_done_its_part
from khepera_forage.task.food_tracking import share_identified
from khepera_forage.task.pairing import (
    attempt_ends,
    is_complete,
    lead,
    rounds_since_done,
    teacher_says,
    update_pairing,
)
from khepera_forage.task.states import Behaviour, StateVector

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


@kernel
def say(teachers: Worlds, learners: Worlds, pairs: Any) -> None:
    """The teachers' decisions, which the learners hear in the same round and execute."""
    robot = teachers.bodies.robots
    for i in range(robot.x.shape[0]):
        # Before its first frame a robot has perceived nothing.
        silent = pairs[i].separated or robot.first_frame[i] != 0.0
        behaviour = teacher_says(int(teachers.tasks.state[i]), silent)
        teachers.tasks.behaviour[i] = learners.tasks.behaviour[i] = behaviour


@kernel
def record_vectors(task: Any, pairs: Any, diagonal: int, vectors: Any) -> None:
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
def drive_learners(worlds: Worlds, pairs: Any, task: TaskParameters) -> None:
    """Command what the behaviour heard commands, bent towards the teacher (4.5.2)."""
    robot, known = worlds.bodies.robots, worlds.tasks
    arena, decisions = arena_map(task), task.decisions[0]
    find_ways_home(worlds, task, known.behaviour)
    for i in range(robot.x.shape[0]):
        behaviour = int(known.behaviour[i])
        own = command(behaviour, raw_data_in(robot, known, i, arena), decisions)
        x, y, orientation = robot.marker_x[i], robot.marker_y[i], robot.marker_heading[i]
        drive(robot, i, applicable(lead(pairs[i], own, behaviour, x, y, orientation, decisions)))


@kernel
def share_food_types(worlds: Worlds, others: Worlds) -> None:
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
def end_round(teachers: Side, learners: Side, pairs: Any, terms: Terms) -> bool:
    """Account for a round of every pair; returns whether any attempt has ended."""
    shown, learning = teachers.worlds, learners.worlds
    teacher, learner = shown.bodies.robots, learning.bodies.robots
    teacher_arena, arena, decisions = (
        arena_map(teachers.task),
        arena_map(learners.task),
        teachers.task.decisions[0],
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
        done = _is_done(shown, i, radius, decisions) and _is_done(learning, i, radius, decisions)
        pair.since_done = rounds_since_done(pair.since_done, done)
        pair.complete = is_complete(pair.since_done, decisions)
        ended = attempt_ends(pair.complete, pair.rounds, terms.limit, pair.separated_rounds, terms.patience)
        pair.over = ended and pair.episode >= 0
        any_over = any_over or pair.over
    return any_over
