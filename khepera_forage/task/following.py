"""The learner's arc towards the teacher (4.5.2), and when the two count as separated."""

from khepera_forage.geometry.angles import bearing_of, length, turn_to
from khepera_forage.robots.khepera import MAX_SPEED, Motors
from khepera_forage.task.decisions import DecisionValues


def separated(x: float, y: float, teacher_x: float, teacher_y: float, decisions: DecisionValues) -> bool:
    """Whether the robots are significantly apart (4.5.2).

    Args:
        x: Of the learner, pixels.
        y: Of the learner.
        teacher_x: Of the teacher, moved into the learner's arena.
        teacher_y: Of the teacher, moved into the learner's arena.
        decisions: `DecisionValues`.
    """
    return length(teacher_x - x, teacher_y - y) > decisions.separation


def follow(
    motors: Motors,
    x: float,
    y: float,
    orientation: float,
    teacher_x: float,
    teacher_y: float,
    teacher_orientation: float,
    decisions: DecisionValues,
) -> Motors:
    """Bend the learner's way towards the teacher.

    Changes the difference of the wheels and never their mean: the learner "does not alter its speed". Nothing
    changes for wheels that do not go forward, at about the same place, or in about the same direction.

    Args:
        motors: What the learner's behaviour commands.
        x: Of the learner, pixels.
        y: Of the learner.
        orientation: Of the learner, degrees.
        teacher_x: Of the teacher, moved into the learner's arena.
        teacher_y: Of the teacher.
        teacher_orientation: Of the teacher, degrees.
        decisions: `DecisionValues`.
    """
    mean = (motors.left + motors.right) / 2
    if mean <= 0.0:
        return motors
    if length(teacher_x - x, teacher_y - y) <= decisions.same_place:
        return motors
    if abs(turn_to(teacher_orientation, orientation)) <= decisions.same_heading:
        return motors
    return _arc(motors, mean, x, y, orientation, teacher_x, teacher_y, decisions.following_gain)


def recover(
    motors: Motors,
    x: float,
    y: float,
    orientation: float,
    teacher_x: float,
    teacher_y: float,
    decisions: DecisionValues,
) -> Motors:
    """The arc at nominal speed by which a separated learner comes back while the teacher waits.

    Args:
        motors: What the learner would do otherwise; arm and jaw are kept.
        x: Of the learner, pixels.
        y: Of the learner.
        orientation: Of the learner, degrees.
        teacher_x: Of the teacher, moved into the learner's arena.
        teacher_y: Of the teacher.
        decisions: `DecisionValues`.
    """
    speed = decisions.recovery_speed
    nominal = Motors(speed, speed, motors.arm, motors.jaw)
    return _arc(nominal, speed, x, y, orientation, teacher_x, teacher_y, decisions.following_gain)


def _arc(
    motors: Motors,
    mean: float,
    x: float,
    y: float,
    orientation: float,
    teacher_x: float,
    teacher_y: float,
    gain: float,
) -> Motors:
    error = turn_to(bearing_of(teacher_x - x, teacher_y - y), orientation)
    limit = min(mean, MAX_SPEED - mean)
    turn = max(-limit, min(limit, (motors.right - motors.left) / 2 + gain * error))
    return Motors(mean - turn, mean + turn, motors.arm, motors.jaw)
