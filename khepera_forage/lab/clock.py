"""The clocks of a laboratory: the wall clock, in rounds without drift, and simulated time."""

import logging
import time
from collections.abc import Callable
from typing import Protocol

_LOG = logging.getLogger(__name__)
_WARNING_INTERVAL = 100
"""Rounds after which the overruns among them may cause a warning."""
MANY_OVERRUNS = 10
"""Number of overruns among these rounds that causes a warning."""


class Clock(Protocol):
    """The clock that ends the rounds of a laboratory."""

    @property
    def rounds(self) -> int:
        """Rounds since the clock was created."""
        ...

    @property
    def overruns(self) -> int:
        """Rounds that took longer than the period."""
        ...

    @property
    def worst_overrun(self) -> float:
        """Longest delay of a round in seconds."""
        ...

    def start(self) -> None:
        """Begin the first round, or the first one after a pause."""
        ...

    def wait(self) -> None:
        """Wait for the end of the current round."""
        ...


class WallClock:
    """Rounds in real time.

    Rounds end at multiples of the period, so that small delays do not add up. A round that overruns ends at once and is
    counted. The next one ends at the first multiple at least half a period later: a long delay is not followed by a
    burst of short rounds.

    Attributes:
        period: Duration of a round in seconds.
        rounds: See `Clock`.
        overruns: See `Clock`.
        worst_overrun: See `Clock`.

    Args:
        period: Duration of a round in seconds.
        clock: Returns the time in seconds from any fixed moment.
        sleep: Waits for a number of seconds.

    Raises:
        ValueError: A period that is not positive.
    """

    def __init__(
        self,
        period: float,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        if not period > 0:
            raise ValueError(f"period is {period!r} s; allowed: a positive time")
        self.period = period
        self.rounds = self.overruns = 0
        self.worst_overrun = 0.0
        self._clock, self._sleep = clock, sleep
        self._due = clock() + period
        self._last_check = (0, 0)

    @property
    def beginning(self) -> float:
        """When the current round was due to begin, by `clock`; a round that overruns may begin later."""
        return self._due - self.period

    def start(self) -> None:
        """Begin the first round, or the first one after a pause."""
        self._due = self._clock() + self.period

    def wait(self) -> None:
        """Sleep until the end of the round; return at once if the round has overrun."""
        self.rounds += 1
        remaining = self._due - self._clock()
        if remaining > 0:
            self._sleep(remaining)
            self._due += self.period
        else:
            delay = -remaining
            self.overruns += 1
            self.worst_overrun = max(self.worst_overrun, delay)
            missed = int(delay / self.period + 0.5)
            self._due += (missed + 1) * self.period
        self._warn()

    def _warn(self) -> None:
        rounds_before, overruns_before = self._last_check
        if self.rounds - rounds_before < _WARNING_INTERVAL:
            return
        overruns = self.overruns - overruns_before
        self._last_check = self.rounds, self.overruns
        if overruns >= MANY_OVERRUNS:
            _LOG.warning(
                "%d of the last %d rounds took longer than %g ms; the worst so far was %.0f ms over",
                overruns,
                _WARNING_INTERVAL,
                1000 * self.period,
                1000 * self.worst_overrun,
            )


class SimulatedClock:
    """The clock of a virtual laboratory: `wait` advances the simulation by one round.

    Args:
        advance: Advances the simulation by one period.
        wall_clock: Also wait for this one; None runs as fast as possible.
    """

    def __init__(self, advance: Callable[[], None], wall_clock: WallClock | None = None) -> None:
        self.rounds = 0
        self._advance, self._wall_clock = advance, wall_clock

    @property
    def overruns(self) -> int:
        """Rounds that took longer than the period on the wall clock; 0 without one."""
        return 0 if self._wall_clock is None else self._wall_clock.overruns

    @property
    def worst_overrun(self) -> float:
        """Longest delay of a round in seconds; 0 without a wall clock."""
        return 0.0 if self._wall_clock is None else self._wall_clock.worst_overrun

    def start(self) -> None:
        """Begin the first round, or the first one after a pause."""
        if self._wall_clock is not None:
            self._wall_clock.start()

    def wait(self) -> None:
        """Wait for the wall clock, if there is one, then advance the simulation."""
        self.rounds += 1
        if self._wall_clock is not None:
            self._wall_clock.wait()
        self._advance()
