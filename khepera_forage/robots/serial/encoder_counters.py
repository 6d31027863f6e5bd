"""The wheels' encoder counters, continued across 32-bit wrap-around and restarts of the robot."""

import time

from khepera_forage.robots.khepera import PULSE, SPEED_UNIT
from khepera_forage.robots.serial.command_table import wrap_counter
from khepera_forage.robots.serial.readings import Values

PLAUSIBLE_DEVIATION = 30
"""Pulses (2.4 mm) by which a wheel's travel may differ from its speed times the time without a second reading. A wrong
reading that is accepted and a right one then differ by at most twice as much."""
_PULSES = SPEED_UNIT / PULSE
"""Pulses of a wheel in one second at one speed unit."""

_RESTART_JUMP = 1000
"""Pulses: a restart has reset a counter that changed by more than this and is now nearer to zero than this."""


class EncoderCounters:
    """Total encoder counts since the first reading.

    The pulses between the last reading and a restart are lost: less than one round's worth.

    Args:
        period: Seconds of a round.

    Attributes:
        total: Counts of the left and the right wheel.
        raw: The last reading; None before the first.
        restart_noticed: Whether a reading has revealed a restart whose banner was not received.
    """

    def __init__(self, period: float) -> None:
        self.total = (0, 0)
        self._period = period
        self._read_at = 0.0
        self.raw: Values | None = None
        self.restart_noticed = self._restarted = False

    def restarted(self) -> None:
        """Record that the robot sent its banner: its counters restarted at zero."""
        self._restarted = True

    def plausible(self, raw: Values, speeds: Values) -> bool:
        """Whether the wheels' speeds explain a reading, after one period or after a longer time since the last one.

        A simulation advances by one period even if it takes longer to compute.
        """
        if self.raw is None:
            return False
        elapsed = max(self._period, time.monotonic() - self._read_at)
        changes = [wrap_counter(value - last) for value, last in zip(raw, self.raw, strict=True)]
        return any(_turned(changes, speeds, seconds) for seconds in (self._period, elapsed))

    def update(self, raw: Values) -> None:
        """Add a reading."""
        last = raw if self.raw is None else self.raw
        changes = [wrap_counter(value - before) for value, before in zip(raw, last, strict=True)]
        jumped = any(abs(change) > _RESTART_JUMP for change in changes)
        was_reset = (self._restarted or jumped) and all(abs(value) < _RESTART_JUMP for value in raw)
        self.restart_noticed = was_reset and not self._restarted
        if self.raw is None:
            self.total = (raw[0], raw[1])
        left, right = raw if was_reset and self.raw is not None else changes
        self.total = (self.total[0] + left, self.total[1] + right)
        self.raw = raw
        self._read_at = time.monotonic()
        self._restarted = False


def agree(first: Values, second: Values, speeds: Values, seconds: float) -> bool:
    """Whether the wheels have not turned between two readings, or have turned at their speeds for some seconds."""
    changes = [wrap_counter(b - a) for a, b in zip(first, second, strict=True)]
    return _turned(changes, speeds, 0.0) or _turned(changes, speeds, seconds)


def _turned(changes: list[int], speeds: Values, seconds: float) -> bool:
    """Whether both wheels have turned at their speeds for the same time."""
    return all(
        abs(change - speed * _PULSES * seconds) <= PLAUSIBLE_DEVIATION
        for change, speed in zip(changes, speeds, strict=True)
    )
