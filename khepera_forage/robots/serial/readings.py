"""Readings of the robot's sensors: plausibility, repetition, and conversion to the ranges of `Senses`.

The protocol has no checksum: a digit changed in transmission may leave a well-formed reply. A reading that the last one
and the command make implausible is therefore requested again; if the two differ, the median of three counts. The limits
trade time for certainty: a true reading is always accepted in the end.
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
COUNTER_LIMITS = Limits(60, 40)
"""Pulses; the change is the deviation from the commanded travel."""


def object_presence(barrier: int) -> int:
    """255 while the optical barrier is interrupted, otherwise 0."""
    return PRESENT if barrier > BARRIER_THRESHOLD else 0


def arm_position(reading: int) -> int:
    """The arm's position in the range of `Senses`; a real arm can be raised further, or lie at the back."""
    return max(ARM_RAISED, min(ARM_DOWN, reading))


def jaw_position(reading: int) -> int:
    """The jaw's position in the range of `Senses`."""
    return max(JAW_CLOSED, min(JAW_OPEN, reading))


def read_confirmed(
    read: Callable[[], Values], implausible: Callable[[Values], bool], equal_within: int
) -> Values:
    """A reading, repeated if it is implausible, and a third time if the first two differ.

    Args:
        read: Requests a reading.
        implausible: Whether a reading contradicts the expectation.
        equal_within: Two readings that differ by at most this count as equal.

    Returns:
        The first, the second, or the median of three, value by value.
    """
    first = read()
    if not implausible(first):
        return first
    second = read()
    if all(abs(a - b) <= equal_within for a, b in zip(first, second, strict=True)):
        return second
    third = read()
    return tuple(sorted(three)[1] for three in zip(first, second, third, strict=True))
