"""Compiled paired corridors: the training phase of the thesis (4.5, 5.2, 5.3) for thousands of learners at once.

A pair is a teacher's world and a learner's, the copy of the arena at its offset under the same camera, with its own
walls, home and marker. Marker and food of one are never hidden by, or under the cable of, the robot of the other: the
gap between the arenas is wider than a marker reaches, and the cables hang from its middle. So the two share nothing
but what the learner hears, where the teacher is, and the types of corresponding food.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from khepera_forage.compilation import entry, rule, share_out
from khepera_forage.counter_rng import keys_of, random_bits
from khepera_forage.envs.arguments import FoodOdds, checked_arena, checked_decisions, whole_number
from khepera_forage.envs.compiled.arenas import arena_at, arena_block, ground_of, map_of, settings_of
from khepera_forage.envs.compiled.batch import given_records
from khepera_forage.envs.compiled.step import (
    World,
    carry_out,
    command_behaviour,
    drive,
    motors_of,
    new_worlds,
    stand_ready,
    world_of,
)
from khepera_forage.envs.layouts import arenas_with_marks, no_room_on_marks
from khepera_forage.noise import Noise, checked_noise
from khepera_forage.records import dtype_of
from khepera_forage.rollouts.compiled.training_results import HEARD, Trained, attempt_dtype, trained
from khepera_forage.rollouts.training import IncompleteTrainingError
from khepera_forage.sim.arena import Arena, copies
from khepera_forage.sim.layout_checks import cable_anchor, check_layout, check_seen
from khepera_forage.sim.world import Layout
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.episode import has_done_its_part
from khepera_forage.task.food_tracking import share_identified
from khepera_forage.task.pairing import (
    Pairing,
    attempt_ends,
    is_complete,
    lead,
    rounds_since_done,
    teacher_says,
    update_pairing,
)
from khepera_forage.task.placement import draw_food_types, food_type_key, layout_key, place_by_hand
from khepera_forage.task.states import Behaviour

_WAIT = Behaviour.WAIT.value
_ROOM = 1 << 28
"""Bytes of records that are kept open at a time, at most."""
_LEAST = 8
"""Training episodes for which another thread pays."""


@dataclass(slots=True)
class _Attempt:
    """An attempt at a training episode under way, and how an operator goes about it.

    Attributes:
        pairing: The learner and its teacher.
        rounds: So far.
        vectors: Experience vectors recorded so far.
        since_done: For how many rounds the robots have done their part.
        complete: Whether teacher and learner delivered and left home (5.3).
        limit: Rounds after which an attempt is out of time.
        patience: Rounds of separation after which an attempt is given up.
        attempts: Incomplete attempts after which an episode is given up.
        error: Standard deviation with which something is put on its mark, mm.
        heading_error: Of a robot's heading, radians.
    """

    pairing: Pairing = field(default_factory=Pairing)
    rounds: int = 0
    vectors: int = 0
    since_done: int = 0
    complete: bool = False
    limit: int = 600
    patience: int = 100
    attempts: int = 200
    error: float = 0.0
    heading_error: float = 0.0


_attempt_dtype = dtype_of(_Attempt)


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
    terms = np.zeros(1, _attempt_dtype)
    terms["limit"] = limit = whole_number("max_cycles", max_cycles, 1)
    terms["patience"] = decisions.patience if patience is None else whole_number("patience", patience, 1)
    most = decisions.most_attempts if attempts is None else whole_number("attempts", attempts, 1)
    terms["attempts"], terms["error"] = most, noise.placement_error
    terms["heading_error"] = np.radians(noise.placement_heading_error)
    arenas = arenas_with_marks(copies(checked_arena(arena, decisions), 2), options or {})
    _check(arenas)
    foods, anchor = len(arenas[0].foods), cable_anchor(arenas)
    # The teacher has the marker of one hole.
    sides: list[Any] = []
    for side, holes in zip(arenas, (1, 2), strict=True):
        settings = settings_of(foods, limit, noise, food_types, decisions, holes)
        sides += [arena_block(side, anchor), settings, *given_records(side.start, side.foods, foods)]
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
            *(*sides, some, rows, rewards, records, made, free),
            scratch=lambda: (new_worlds(2, foods), terms.copy()),
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


def _check(arenas: Any) -> None:
    """Complain about arenas that are out of sight, or marks that nothing can stand on."""
    check_seen(arenas)
    layout = Layout(tuple(a.start for a in arenas), tuple(food for a in arenas for food in a.foods))
    check_layout(arenas, layout)


@entry
def _train(
    first: int,
    last: int,
    teacher_block: Any,
    teacher_settings: Any,
    teacher_mark: Any,
    teacher_food_marks: Any,
    learner_block: Any,
    learner_settings: Any,
    learner_mark: Any,
    learner_food_marks: Any,
    keys: Any,
    rows: Any,
    rewards: Any,
    records: Any,
    made: Any,
    free: Any,
    worlds: World,
    attempts: Any,
) -> None:
    """Train the episodes from `first` to `last`, attempt by attempt until one is complete.

    Args:
        first: Number of an episode.
        last: Number after the last one.
        teacher_block: The teacher's arena; likewise its settings, the robot's mark and the food's.
        teacher_settings: Likewise.
        teacher_mark: Likewise.
        teacher_food_marks: Likewise.
        learner_block: The learner's; likewise.
        learner_settings: Likewise.
        learner_mark: Likewise.
        learner_food_marks: Likewise.
        keys: Of the random numbers of each episode.
        rows: Experience vectors of the last attempt at each episode, shape (episodes, rounds, 6).
        rewards: The learner's, from each of them to the next, shape (episodes, rounds).
        records: `attempt_dtype`, shape (episodes, attempts).
        made: How many attempts at each episode there were.
        free: Whether robots and food found room on their marks.
        worlds: Two of them, the teacher's and the learner's.
        attempts: One `_Attempt` record, with how an operator goes about it.
    """
    teacher, learner = world_of(worlds, 0), world_of(worlds, 1)
    teacher_arena, learner_arena = arena_at(teacher_block, 0), arena_at(learner_block, 0)
    diagonal = int(learner_arena.numbers[0].map_diagonal)
    attempt = attempts[0]
    for number in range(first, last):
        attempt.complete = False
        for k in range(attempt.attempts):
            key = random_bits(keys[number], k)
            _begin(attempt)
            rewards[number] = 0.0
            room = _put_on_marks(
                teacher,
                teacher_arena,
                teacher_settings[0],
                0,
                key,
                teacher_mark[0],
                teacher_food_marks,
                attempt,
            )
            room = room and _put_on_marks(
                learner,
                learner_arena,
                learner_settings[0],
                1,
                key,
                learner_mark[0],
                learner_food_marks,
                attempt,
            )
            free[number] = free[number] and room
            ended = False
            while not ended:
                ended = _round(
                    teacher,
                    learner,
                    teacher_arena,
                    learner_arena,
                    teacher_settings[0],
                    learner_settings[0],
                    attempt,
                    rows[number],
                    rewards[number],
                    diagonal,
                )
            record = records[number, k]
            record.complete, record.rounds, record.vectors = attempt.complete, attempt.rounds, attempt.vectors
            record.separations = attempt.pairing.separations
            made[number] = k + 1
            if attempt.complete:
                break


@rule
def _begin(attempt: Any) -> None:
    pairing = attempt.pairing
    pairing.separated, pairing.separated_rounds, pairing.separations = False, 0, 0
    attempt.rounds = attempt.vectors = attempt.since_done = 0
    attempt.complete = False


@rule
def _put_on_marks(
    world: World, arena: Any, settings: Any, side: int, key: Any, mark: Any, food_marks: Any, terms: Any
) -> bool:
    """Put the robot and food of one side on their marks; returns whether there was room."""
    robot = world.robots[0]
    robot.key, robot.round = random_bits(key, side), 0
    room = place_by_hand(
        world.starts[0],
        world.places,
        random_bits(layout_key(key, 0), side),
        mark,
        food_marks,
        terms.error,
        terms.heading_error,
        ground_of(arena),
    )
    stand_ready(world, settings)
    draw_food_types(world.objects, food_type_key(key, 0), settings.odds)
    return bool(room)


@rule
def _round(
    teacher: World,
    learner: World,
    teacher_arena: Any,
    learner_arena: Any,
    teacher_settings: Any,
    learner_settings: Any,
    attempt: Any,
    row: Any,
    gains: Any,
    diagonal: int,
) -> bool:
    """One round of a pair; returns whether the attempt has ended. The first round only takes the first frame."""
    pairing, first = attempt.pairing, teacher.robots[0].first_frame
    # The learner hears the teacher's decision in the same round, and executes it.
    behaviour = teacher_says(teacher.foragers[0].state, pairing.separated or first)
    if behaviour != _WAIT:
        _record_vector(learner.foragers[0].vector, behaviour, row[attempt.vectors], diagonal)
        attempt.vectors += 1
    command_behaviour(teacher, teacher_arena, teacher_settings, behaviour)
    carry_out(teacher, teacher_arena, teacher_settings)
    share_identified(teacher.objects, learner.objects)
    _command_learner(learner, learner_arena, learner_settings, pairing, behaviour)
    carry_out(learner, learner_arena, learner_settings)
    gains[max(attempt.vectors - 1, 0)] += learner.foragers[0].episode.reward
    share_identified(learner.objects, teacher.objects)

    shown, learning = teacher.robots[0], learner.robots[0]
    decisions = teacher_settings.decisions
    teacher_map, learner_map = map_of(teacher_arena), map_of(learner_arena)
    update_pairing(
        pairing,
        learning.marker_x,
        learning.marker_y,
        learner_map,
        shown.marker_x,
        shown.marker_y,
        shown.marker_heading,
        teacher_map,
        decisions,
    )
    if first:
        return False
    attempt.rounds += 1
    radius = learner_map.home_radius
    done = _is_done(teacher, radius, decisions) and _is_done(learner, radius, decisions)
    attempt.since_done = rounds_since_done(attempt.since_done, done)
    attempt.complete = is_complete(attempt.since_done, decisions)
    return bool(
        attempt_ends(
            attempt.complete, attempt.rounds, attempt.limit, pairing.separated_rounds, attempt.patience
        )
    )


@rule
def _record_vector(vector: Any, behaviour: int, row: Any, diagonal: int) -> None:
    """Record the learner's own state vector with the behaviour heard."""
    row[0], row[1] = vector.object_presence, min(vector.robot_home_distance, diagonal)
    row[2], row[3] = vector.food_type, vector.arms_height
    row[4], row[HEARD] = min(vector.robot_food_distance, diagonal), behaviour


@rule
def _command_learner(world: World, arena: Any, settings: Any, pairing: Any, behaviour: int) -> None:
    """Command what the behaviour heard commands, bent towards the teacher (4.5.2)."""
    robot, forager = world.robots[0], world.foragers[0]
    forager.behaviour = behaviour
    own = motors_of(world, map_of(arena), settings, behaviour)
    x, y, orientation = robot.marker_x, robot.marker_y, robot.marker_heading
    drive(world, lead(pairing, own, behaviour, x, y, orientation, settings.decisions))


@rule
def _is_done(world: World, home_radius: float, decisions: Any) -> bool:
    forager = world.foragers[0]
    return bool(has_done_its_part(forager.tracker, world.objects, forager.vector, home_radius, decisions))
