"""Teacher and learner beside each other (4.5, 4.5.2): separation, silence, and how the learner is led.

The functions take *records*: objects with the fields of `Pairing`. `own` and `teacher` are raw data.
"""

from dataclasses import dataclass
from typing import Any

from khepera_forage.geometry.plane import bearing_of, length, turn_to
from khepera_forage.robots.khepera import MAX_SPEED, Motors
from khepera_forage.task.arena_map import ArenaMap
from khepera_forage.task.decisions import DecisionValues
from khepera_forage.task.states import Behaviour


@dataclass(slots=True)
class Pairing:
    """One learner and its teacher.

    Attributes:
        separated: Whether the learner is significantly apart from the teacher.
        separated_rounds: For how many rounds it has been.
        separations: How often it has become so.
        teacher_x: The teacher's place in the learner's arena, pixels.
        teacher_y: The teacher's place in the learner's arena, pixels.
        teacher_orientation: Degrees.
    """

    separated: bool = False
    separated_rounds: int = 0
    separations: int = 0
    teacher_x: float = 0.0
    teacher_y: float = 0.0
    teacher_orientation: float = 0.0


def update_pairing(
    pairing: Any, own: Any, arena: ArenaMap, teacher: Any, teacher_arena: ArenaMap, decisions: DecisionValues
) -> None:
    """Account for one round. The robots are separated if they are significantly apart (4.5.2)."""
    pairing.teacher_x = teacher.x + arena.home_x - teacher_arena.home_x
    pairing.teacher_y = teacher.y + arena.home_y - teacher_arena.home_y
    pairing.teacher_orientation = teacher.orientation
    apart = length(pairing.teacher_x - own.x, pairing.teacher_y - own.y) > decisions.separation
    if apart and not pairing.separated:
        pairing.separations += 1
    pairing.separated_rounds = pairing.separated_rounds + 1 if apart else 0
    pairing.separated = apart


def teacher_says(state: int, any_separated: bool) -> int:
    """What the teacher executes and says (4.5): WAIT, which is silence, while a learner is separated."""
    # States and behaviours correspond one to one (4.4.1).
    return Behaviour.WAIT.value if any_separated else state


def lead(pairing: Any, motors: Motors, behaviour: int, own: Any, decisions: DecisionValues) -> Motors:
    """The motors that a learner's behaviour commands, bent towards the teacher (4.5.2); one that waits recovers."""
    if pairing.separated and behaviour == Behaviour.WAIT:
        return recover(pairing, motors, own, decisions)
    if behaviour == Behaviour.PUSH_FOOD and not decisions.has_gripper:
        return motors  # On an arc, food would slip away to the side.
    return follow(pairing, motors, own, decisions)


def follow(pairing: Any, motors: Motors, own: Any, decisions: DecisionValues) -> Motors:
    """Bend the learner's way towards the teacher.

    Changes the difference of the wheels and never their mean: the learner "does not alter its speed". Nothing
    changes for wheels that do not go forward, at about the same place, or in about the same direction.
    """
    mean = (motors.left + motors.right) / 2
    if mean <= 0.0:
        return motors
    if length(pairing.teacher_x - own.x, pairing.teacher_y - own.y) <= decisions.same_place:
        return motors
    if abs(turn_to(pairing.teacher_orientation, own.orientation)) <= decisions.same_heading:
        return motors
    return _arc(pairing, motors, mean, own, decisions)


def recover(pairing: Any, motors: Motors, own: Any, decisions: DecisionValues) -> Motors:
    """The arc at nominal speed by which a separated learner comes back while the teacher waits."""
    speed = decisions.recovery_speed
    return _arc(pairing, Motors(speed, speed, motors.arm, motors.jaw), speed, own, decisions)


def _arc(pairing: Any, motors: Motors, mean: float, own: Any, decisions: DecisionValues) -> Motors:
    error = turn_to(bearing_of(pairing.teacher_x - own.x, pairing.teacher_y - own.y), own.orientation)
    limit = min(mean, MAX_SPEED - mean)
    turn = max(-limit, min(limit, (motors.right - motors.left) / 2 + decisions.following_gain * error))
    return Motors(mean - turn, mean + turn, motors.arm, motors.jaw)


@dataclass(slots=True)
class AttemptState:
    """An attempt at a training episode under way, and how an operator goes about it.

    Attributes:
        number: Of the next attempt of a compiled world.
        rounds: So far.
        since_done: For how many rounds the robots have done their part, counted from the first one.
        complete: Whether all robots delivered and left home, and the operator has ended the episode (5.3).
        limit: Rounds after which an attempt is out of time.
        patience: Rounds of separation after which an attempt is given up.
        error: Standard deviation with which something is put on its mark, mm.
        heading_error: Of a robot's heading, radians.
    """

    number: int = 0
    rounds: int = 0
    since_done: int = 0
    complete: bool = False
    limit: int = 600
    patience: int = 100
    error: float = 0.0
    heading_error: float = 0.0


def end_round(attempt: Any, all_done: bool, separated_rounds: int, decisions: DecisionValues) -> bool:
    """Account for a round of an attempt, which an operator ends some rounds after the robots have done their part.

    Args:
        attempt: The `AttemptState` record; changed in place.
        all_done: Whether all robots have done their part now (`episode.has_done_its_part`).
        separated_rounds: For how many rounds a learner has been separated.
        decisions: `DecisionValues`.

    Returns:
        Whether the attempt has ended: complete, out of time, or separated for too long (5.3.1).
    """
    if all_done or attempt.since_done > 0:
        attempt.since_done += 1
    attempt.complete = attempt.since_done > decisions.rounds_after_training
    out_of_time = attempt.rounds >= attempt.limit
    return bool(attempt.complete or out_of_time or separated_rounds >= attempt.patience)
