"""The clock of a laboratory, in rounds without drift."""

import logging
import time
from collections.abc import Callable

_LOG = logging.getLogger(__name__)
_WARNING_INTERVAL, _MANY_OVERRUNS = 100, 10
"""So many overruns among so many rounds cause a warning."""


class WallClock:
    """Rounds in real time, of `period` seconds.

    Rounds end at multiples of the period, so that small delays do not add up. A round that overruns ends at once and is
    counted. The next one ends at the first multiple at least half a period later: a long delay is not followed by a
    burst of short rounds. In a virtual laboratory, `clock` is simulated time and `sleep` advances the simulation.

    Attributes:
        rounds: Since the clock was created.
        overruns: Rounds that took longer than the period.
        worst_overrun: Longest delay of a round in seconds.

    Raises:
        ValueError: A period that is not positive.
    """

    def __init__(
        self, period: float, clock: Callable[[], float] = time.monotonic, sleep: Callable[[float], None] = time.sleep
    ) -> None:
        if not period > 0:
            raise ValueError(f"period is {period!r} s; allowed: a positive time")
        self.period = period
        self.rounds = self.overruns = 0
        self.worst_overrun = 0.0
        self._clock, self._sleep = clock, sleep
        self._due = clock() + period
        self._overruns_before = 0

    @property
    def beginning(self) -> float:
        """When the current round was due to begin, by `clock`; a round that overruns may begin later."""
        return self._due - self.period

    def start(self) -> None:
        """Begin the first round, or the first one after a pause."""
        self._due = self._clock() + self.period

    def wait(self) -> None:
        """Sleep until the end of the round; for no time if the round has overrun."""
        self.rounds += 1
        remaining = self._due - self._clock()
        self._sleep(max(0.0, remaining))
        if remaining > 0:
            self._due += self.period
        else:
            self.overruns += 1
            self.worst_overrun = max(self.worst_overrun, -remaining)
            self._due += (int(-remaining / self.period + 0.5) + 1) * self.period
        if self.rounds % _WARNING_INTERVAL == 0:
            overruns, self._overruns_before = self.overruns - self._overruns_before, self.overruns
            if overruns >= _MANY_OVERRUNS:
                _LOG.warning(
                    "%d of the last %d rounds took longer than %g ms; the worst so far was %.0f ms over",
                    overruns,
                    _WARNING_INTERVAL,
                    1000 * self.period,
                    1000 * self.worst_overrun,
                )
