"""Readings of the robot's sensors: plausibility, repetition, and conversion to the ranges of `Senses`.

The protocol has no checksum: a digit changed in transmission may leave a well-formed reply. A reading that the last one
and the command make implausible is therefore requested again, until one is plausible or agrees with the one before. The
limits trade time for certainty: a true reading is accepted as soon as it arrives twice.
"""

from collections.abc import Callable
from typing import NamedTuple

from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, JAW_CLOSED, JAW_OPEN, PRESENT

Values = tuple[int, ...]

BARRIER_THRESHOLD = 100
"""The optical barrier reads more than this with an object in it (PYRO)."""


class Limits(NamedTuple):
    """Plausibility limits of a reading.

    Attributes:
        max_change: Largest plausible change from round to round.
        equal_within: Two consecutive readings that differ by at most this count as equal.
    """

    max_change: int
    equal_within: int


PROXIMITY_LIMITS = Limits(200, 200)
PRESENCE_LIMITS = Limits(0, 0)
ARM_LIMITS = Limits(8, 8)
JAW_LIMITS = Limits(45, 45)
BEHIND_ARM = 900
"""Infra-reds in front of which the lowered arm lies read more than this (WSU: 1015 and more)."""
MAX_READINGS = 5
"""Readings of a sensor in one round; if none is plausible and no two agree, its value is unknown."""


def object_presence(barrier: int) -> int:
    """255 while the optical barrier is interrupted, otherwise 0."""
    return PRESENT if barrier > BARRIER_THRESHOLD else 0


def arm_position(reading: int) -> int:
    """The arm's position in the range of `Senses`; a real arm can be raised further, or lie at the back."""
    return max(ARM_RAISED, min(ARM_DOWN, reading))


def jaw_position(reading: int) -> int:
    """The jaw's position in the range of `Senses`."""
    return max(JAW_CLOSED, min(JAW_OPEN, reading))


def arm_passed(first: Values, second: Values) -> bool:
    """Whether the arm has moved in front of the infra-reds between two readings, or away from them.

    It covers all six in front (WSU). A disturbance of some bytes cannot change six values alike.
    """
    pairs = [*zip(first[:6], second[:6], strict=True)]
    lowered = all(b > BEHIND_ARM and b - a > PROXIMITY_LIMITS.max_change for a, b in pairs)
    raised = all(a > BEHIND_ARM and a - b > PROXIMITY_LIMITS.max_change for a, b in pairs)
    return (lowered or raised) and within(first[6:], second[6:], PROXIMITY_LIMITS.max_change)


def read_confirmed(
    read: Callable[[], Values | None],
    plausible: Callable[[Values], bool],
    agree: Callable[[Values, Values], bool],
    before: Values | None = None,
) -> Values | None:
    """A reading that is plausible, or confirmed by the one before.

    Args:
        read: Requests a reading; returns None if there is no time for another one.
        plausible: Whether a reading meets the expectation.
        agree: Whether two consecutive readings show the same.
        before: A reading of the last round that was not confirmed.

    Returns:
        The reading; None if the readings contradict each other, so that the value is unknown.
    """
    for _ in range(MAX_READINGS):
        values = read()
        if values is None:
            return None
        if plausible(values) or (before is not None and agree(before, values)):
            return values
        before = values
    return None


def within(a: Values, b: Values, difference: int) -> bool:
    """Whether all values differ by at most this."""
    return all(abs(x - y) <= difference for x, y in zip(a, b, strict=True))
