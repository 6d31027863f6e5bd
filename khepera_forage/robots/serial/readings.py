"""From what the protocol reports to `Senses`: ranges, counters that outlive a restart, and which reading is surprising.

The protocol has no checksum: a digit changed on the line may leave a well-formed reply. A reading that the last one and
the command do not lead one to expect is therefore asked for again, and the middle one of three is believed if the first
two differ. Thresholds only cost or save time: what was true is believed in the end.
"""

from collections.abc import Callable
from typing import NamedTuple

from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, JAW_CLOSED, JAW_OPEN, PRESENT

Values = tuple[int, ...]

BARRIER_THRESHOLD = 100
"""The optical barrier reads more with an object in it (PYRO)."""
_PULSES_PER_UNIT = 10
"""Encoder pulses a round and speed unit."""
_SLACK = 60
"""Pulses by which a round's travel may differ from the commanded one without surprising."""
_RESTART_JUMP = 1000
"""Pulses: a counter that has jumped so far and is nearer to zero than this was set to zero by a restart."""
_REFRESH = 10
"""Rounds after which a position is asked although nothing moves."""


class Kind(NamedTuple):
    """What is normal for a reading.

    Attributes:
        step: By how much it may change from round to round without surprising.
        alike: By how much two readings in a row may differ and count as the same.
    """

    step: int
    alike: int


PROXIMITY = Kind(200, 200)
PRESENCE = Kind(0, 0)
ARM = Kind(8, 8)
JAW = Kind(45, 45)
COUNTERS = Kind(_SLACK, 40)


def present(barrier: int) -> int:
    """255 while the optical barrier is interrupted, otherwise 0."""
    return PRESENT if barrier > BARRIER_THRESHOLD else 0


def arm_of(position: int) -> int:
    """The arm's position in the range of `Senses`; a real one can also be raised further, or lie at the back."""
    return max(ARM_RAISED, min(ARM_DOWN, position))


def jaw_of(position: int) -> int:
    """The jaw's position in the range of `Senses`."""
    return max(JAW_CLOSED, min(JAW_OPEN, position))


def confirmed(ask: Callable[[], Values], surprising: Callable[[Values], bool], alike: int) -> Values:
    """A reading, asked for again if it is surprising, and a third time if the first two differ.

    Args:
        ask: Reads.
        surprising: Whether a reading is not what one expects.
        alike: By how much two readings may differ and count as the same.

    Returns:
        The first, the second, or the middle of three, value by value.
    """
    first = ask()
    if not surprising(first):
        return first
    second = ask()
    if all(abs(a - b) <= alike for a, b in zip(first, second, strict=True)):
        return second
    third = ask()
    return tuple(sorted(three)[1] for three in zip(first, second, third, strict=True))


class Position:
    """Where arm or jaw is as last read, where it is going, and whether to ask.

    Args:
        kind: What is normal for it.
        stalls: Whether it may come to rest before its target for good, as a jaw does that closes on food. An arm that
            has come down on something goes on once there is room, so it is asked in every round until it is there.
        phase: Round of `_REFRESH` in which it is asked in any case.
    """

    def __init__(self, kind: Kind, *, stalls: bool, phase: int) -> None:
        self.value: int | None = None
        self._kind = kind
        self._stalls = stalls
        self._target: int | None = None
        self._resting = 0
        self._round = -phase

    def sent_to(self, target: int | None) -> None:
        """It was told to go there; None if it has forgotten what it was told."""
        self._target = target
        self._resting = 0

    def due(self) -> bool:
        """Whether it is to be asked in the round that begins now."""
        self._round += 1
        arrived = self._target is not None and self.value is not None and abs(self.value - self._target) <= 3
        rests = self._resting >= (1 if arrived else 10)
        return (
            not (rests and (arrived or self._stalls or self._target is None)) or self._round % _REFRESH == 0
        )

    def surprising(self, values: Values) -> bool:
        """Whether a reading is neither where it was nor on the way to where it was sent."""
        (value,) = values
        if self.value is None:
            return True
        target = self.value if self._target is None else self._target
        low, high = min(self.value, target), max(self.value, target)
        return not low - 3 <= value <= high + 3 or abs(value - self.value) > self._kind.step

    def read(self, value: int) -> None:
        """Take a reading."""
        self._resting = self._resting + 1 if value == self.value else 0
        self.value = value


class Counters:
    """The wheels' encoders as counts that never wrap and never start anew.

    What a wheel travelled between the last reading and a restart is lost: less than a round's worth.
    """

    def __init__(self) -> None:
        self.total = (0, 0)
        self._raw: Values | None = None
        self._restarted = False

    def restarted(self) -> None:
        """The robot was seen to restart: its counters began anew at zero."""
        self._restarted = True

    def surprising(self, raw: Values, now: Values, before: Values) -> bool:
        """Whether a reading is not what the wheels' speeds, in this round and the one before, lead one to expect."""
        if self._raw is None:
            return True
        for value, last, *speeds in zip(raw, self._raw, now, before, strict=True):
            travelled = [speed * _PULSES_PER_UNIT for speed in speeds]
            if not min(0, *travelled) - _SLACK <= _wrapped(value - last) <= max(0, *travelled) + _SLACK:
                return True
        return False

    def read(self, raw: Values) -> bool:
        """Take a reading; returns whether it shows a restart that nobody saw."""
        if self._raw is None:
            self.total = (raw[0], raw[1])
        jumps = [_wrapped(value - last) for value, last in zip(raw, self._raw or raw, strict=True)]
        jumped = any(abs(jump) > _RESTART_JUMP for jump in jumps)
        anew = (self._restarted or jumped) and all(abs(value) < _RESTART_JUMP for value in raw)
        unseen = anew and not self._restarted
        if self._raw is not None:
            left, right = raw if anew else jumps
            self.total = (self.total[0] + left, self.total[1] + right)
        self._raw = raw
        self._restarted = False
        return unseen


def _wrapped(difference: int) -> int:
    """A difference of two 32-bit counters that may have wrapped between the readings."""
    return (difference + 2**31) % 2**32 - 2**31
