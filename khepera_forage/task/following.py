"""The learner's arc towards the teacher (4.5.2), and when the two count as separated."""

from khepera_forage.geometry.angles import bearing_of, length, turn_to
from khepera_forage.robots.khepera import MAX_SPEED, Motors

SEPARATION = 14.0
"""Pixels between the learner and where the teacher is beyond which they are separated. Our decision."""
SAME_PLACE = 2.0
"""Pixels within which they are in about the same position. Our decision."""
SAME_HEADING = 8.0
"""Degrees within which they go in the same direction. Our decision."""
NOMINAL_SPEED = 6.0
"""Speed units of a learner that recovers while the teacher waits. Our decision: that of MOVE SLOWLY."""

_GAIN = 0.1
"""Speed units of difference a degree off course."""


def separated(x: float, y: float, teacher_x: float, teacher_y: float) -> bool:
    """Whether the robots are significantly apart (4.5.2).

    Args:
        x: Of the learner, pixels.
        y: Of the learner.
        teacher_x: Of the teacher, moved into the learner's arena.
        teacher_y: Of the teacher, moved into the learner's arena.
    """
    return length(teacher_x - x, teacher_y - y) > SEPARATION


def follow(
    motors: Motors,
    x: float,
    y: float,
    orientation: float,
    teacher_x: float,
    teacher_y: float,
    teacher_orientation: float,
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
    """
    mean = (motors.left + motors.right) / 2
    if mean <= 0.0:
        return motors
    if length(teacher_x - x, teacher_y - y) <= SAME_PLACE:
        return motors
    if abs(turn_to(teacher_orientation, orientation)) <= SAME_HEADING:
        return motors
    return _arc(motors, mean, x, y, orientation, teacher_x, teacher_y)


def recover(
    motors: Motors, x: float, y: float, orientation: float, teacher_x: float, teacher_y: float
) -> Motors:
    """The arc at nominal speed by which a separated learner comes back while the teacher waits.

    Args:
        motors: What the learner would do otherwise; arm and jaw are kept.
        x: Of the learner, pixels.
        y: Of the learner.
        orientation: Of the learner, degrees.
        teacher_x: Of the teacher, moved into the learner's arena.
        teacher_y: Of the teacher.
    """
    nominal = Motors(NOMINAL_SPEED, NOMINAL_SPEED, motors.arm, motors.jaw)
    return _arc(nominal, NOMINAL_SPEED, x, y, orientation, teacher_x, teacher_y)


def _arc(
    motors: Motors, mean: float, x: float, y: float, orientation: float, teacher_x: float, teacher_y: float
) -> Motors:
    error = turn_to(bearing_of(teacher_x - x, teacher_y - y), orientation)
    limit = min(mean, MAX_SPEED - mean)
    turn = max(-limit, min(limit, (motors.right - motors.left) / 2 + _GAIN * error))
    return Motors(mean - turn, mean + turn, motors.arm, motors.jaw)
