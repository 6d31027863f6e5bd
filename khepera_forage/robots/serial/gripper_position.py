"""The position of arm or jaw, and when to request it: in every round while it moves, otherwise now and then."""

from khepera_forage.robots.serial.readings import Limits, Values

_REFRESH_ROUNDS = 10
"""Rounds after which a position is requested although nothing moves."""
_AT_TARGET = 3
"""Positions within which a target counts as reached. Assumption."""


class GripperPosition:
    """The position of arm or jaw as last read, and its target.

    Args:
        limits: Plausibility limits of its readings.
        can_stall: Whether it may stop short of its target for good, as a jaw does that closes on food. An arm that
            rests on an obstacle moves on once there is room, so its position is requested in every round until it
            reaches its target.
        phase: Round of `_REFRESH_ROUNDS` in which the position is always requested.

    Attributes:
        value: The last reading; None before the first.
    """

    def __init__(self, limits: Limits, *, can_stall: bool, phase: int) -> None:
        self.value: int | None = None
        self._limits = limits
        self._can_stall = can_stall
        self._target: int | None = None
        self._rounds_at_rest = 0
        self._round = -phase

    def set_target(self, target: int | None) -> None:
        """Record a new target; None if the robot has lost it in a restart."""
        self._target = target
        self._rounds_at_rest = 0

    def is_due(self) -> bool:
        """Begin a round; returns whether the position must be requested in it."""
        self._round += 1
        arrived = (
            self._target is not None
            and self.value is not None
            and abs(self.value - self._target) <= _AT_TARGET
        )
        at_rest = self._rounds_at_rest >= (1 if arrived else 10)
        settled = at_rest and (arrived or self._can_stall or self._target is None)
        return not settled or self._round % _REFRESH_ROUNDS == 0

    def plausible(self, values: Values) -> bool:
        """Whether a reading is between the last position and the target, and not too far from the last position."""
        (value,) = values
        if self.value is None:
            return False
        target = self.value if self._target is None else self._target
        low, high = min(self.value, target), max(self.value, target)
        on_the_way = low - _AT_TARGET <= value <= high + _AT_TARGET
        return on_the_way and abs(value - self.value) <= self._limits.max_change

    def update(self, value: int) -> None:
        """Record a reading."""
        self._rounds_at_rest = self._rounds_at_rest + 1 if value == self.value else 0
        self.value = value
