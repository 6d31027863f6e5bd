"""The wheels' encoder counters, continued across 32-bit wrap-around and restarts of the robot."""

from khepera_forage.robots.khepera import PULSES_PER_UNIT
from khepera_forage.robots.serial.command_table import wrap_counter
from khepera_forage.robots.serial.readings import COUNTER_LIMITS, Values

_RESTART_JUMP = 1000
"""Pulses: a restart has reset a counter that changed by more than this and is now nearer to zero than this."""


class EncoderCounters:
    """Total encoder counts since the first reading.

    The pulses between the last reading and a restart are lost: less than one round's worth.

    Attributes:
        total: Counts of the left and the right wheel.
    """

    def __init__(self) -> None:
        self.total = (0, 0)
        self._raw: Values | None = None
        self._restarted = False

    def restarted(self) -> None:
        """Record that the robot sent its banner: its counters restarted at zero."""
        self._restarted = True

    def implausible(self, raw: Values, speeds: Values, speeds_before: Values) -> bool:
        """Whether the wheels' speeds, in this round and the one before, do not explain a reading."""
        if self._raw is None:
            return True
        slack = COUNTER_LIMITS.max_change
        for value, last, *wheel_speeds in zip(raw, self._raw, speeds, speeds_before, strict=True):
            travel = [speed * PULSES_PER_UNIT for speed in wheel_speeds]
            if not min(0, *travel) - slack <= wrap_counter(value - last) <= max(0, *travel) + slack:
                return True
        return False

    def update(self, raw: Values) -> bool:
        """Add a reading; returns whether it reveals a restart whose banner was not received."""
        if self._raw is None:
            self.total = (raw[0], raw[1])
        changes = [wrap_counter(value - last) for value, last in zip(raw, self._raw or raw, strict=True)]
        jumped = any(abs(change) > _RESTART_JUMP for change in changes)
        was_reset = (self._restarted or jumped) and all(abs(value) < _RESTART_JUMP for value in raw)
        unnoticed_restart = was_reset and not self._restarted
        if self._raw is not None:
            left, right = raw if was_reset else changes
            self.total = (self.total[0] + left, self.total[1] + right)
        self._raw = raw
        self._restarted = False
        return unnoticed_restart
