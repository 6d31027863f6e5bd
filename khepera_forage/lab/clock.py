"""The beat of a laboratory: rounds of 0.1 s on the wall clock, without drift."""

import logging
import time
from collections.abc import Callable
from typing import Protocol

from khepera_forage.robots.khepera import CONTROL_PERIOD

_log = logging.getLogger(__name__)
_WINDOW = 100
"""Rounds over which overruns are counted for a warning."""
MANY = 10
"""Overruns within these that are worth one."""


class Beat(Protocol):
    """What a laboratory waits for at the end of every round."""

    @property
    def rounds(self) -> int:
        """Rounds waited for since the beat was made."""
        ...

    @property
    def overruns(self) -> int:
        """Rounds that were over their time."""
        ...

    @property
    def worst(self) -> float:
        """The longest of these overruns in seconds."""
        ...

    def start(self) -> None:
        """The first round begins now; after a pause too."""
        ...

    def wait(self) -> None:
        """Until the present round is over."""
        ...


class WallBeat:
    """The beat on the wall clock.

    Rounds end on a grid of whole periods, so that small delays do not add up. A round that is over its time ends at
    once, is counted, and the next one ends at the first place of the grid that is at least half a period away: what was
    missed is not caught up in a burst of short rounds.

    Attributes:
        rounds: As `Beat` has it.
        overruns: As `Beat` has it.
        worst: As `Beat` has it.

    Args:
        period: Of a round in seconds.
        clock: Seconds from any fixed moment.
        sleep: Waits for so many seconds.

    Raises:
        ValueError: A period that is not positive.
    """

    def __init__(
        self,
        period: float = CONTROL_PERIOD,
        clock: Callable[[], float] = time.monotonic,
        sleep: Callable[[float], None] = time.sleep,
    ) -> None:
        if not period > 0:
            raise ValueError(f"period is {period!r} s; allowed: a positive time")
        self.period = period
        self.rounds = self.overruns = 0
        self.worst = 0.0
        self._clock, self._sleep = clock, sleep
        self._due = clock() + period
        self._counted_from = (0, 0)

    def start(self) -> None:
        """The first round begins now."""
        self._due = self._clock() + self.period

    def wait(self) -> None:
        """Sleep until the round is over; at once if it is already."""
        self.rounds += 1
        left = self._due - self._clock()
        if left > 0:
            self._sleep(left)
            self._due += self.period
        else:
            late = -left
            self.overruns += 1
            self.worst = max(self.worst, late)
            missed = int(late / self.period + 0.5)
            self._due += (missed + 1) * self.period
        self._warn()

    def _warn(self) -> None:
        since, before = self._counted_from
        if self.rounds - since < _WINDOW:
            return
        late = self.overruns - before
        self._counted_from = self.rounds, self.overruns
        if late >= MANY:
            _log.warning(
                "%d of the last %d rounds took longer than %g ms; the worst so far was %.0f ms over",
                late,
                _WINDOW,
                1000 * self.period,
                1000 * self.worst,
            )
