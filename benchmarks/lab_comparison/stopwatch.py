"""One clock that always runs for exactly one part of a program."""

from collections import defaultdict
from collections.abc import Callable
from time import perf_counter
from typing import Any

Method = Callable[..., Any]
OUTSIDE = "outside"
"""The part that runs when no timed method does."""


class Sheet:
    """What a stopwatch has noted, by part.

    Attributes:
        seconds: Time that the clock ran for a part.
        entered: How often a part was called.
        left: How often a part called another.
    """

    def __init__(self) -> None:
        self.seconds: defaultdict[str, float] = defaultdict(float)
        self.entered: defaultdict[str, int] = defaultdict(int)
        self.left: defaultdict[str, int] = defaultdict(int)


class Stopwatch:
    """Times methods exclusively: a call switches the clock to the part called, its end switches it back.

    Switching itself costs time, some before and some behind the moment at which the clock is switched. Both are
    measured on a method that does nothing, and taken off by `exclusive`.

    Attributes:
        sheet: Where times are noted; it can be changed for another.
    """

    def __init__(self) -> None:
        self.sheet = Sheet()
        self._part = OUTSIDE
        self._since = perf_counter()
        self._inside, self._before = self._cost_of_switching()

    def timed(self, method: Method, part: str) -> Method:
        """The same function or method, with the clock running for its part."""

        def run(*args: Any, **kwargs: Any) -> Any:
            caller, sheet = self._part, self.sheet
            sheet.left[caller] += 1
            sheet.entered[part] += 1
            self._part = part
            now = perf_counter()
            sheet.seconds[caller] += now - self._since
            self._since = now
            try:
                return method(*args, **kwargs)
            finally:
                now = perf_counter()
                sheet.seconds[part] += now - self._since
                self._part = caller
                self._since = now

        return run

    def exclusive(self, part: str) -> float:
        """Seconds in a part and not in those it called, without what the switching cost."""
        sheet = self.sheet
        switching = sheet.entered[part] * self._inside + sheet.left[part] * self._before
        return max(sheet.seconds[part] - switching, 0.0)

    def _cost_of_switching(self, calls: int = 4_000, tries: int = 7) -> tuple[float, float]:
        """Seconds by which one timed call lengthens the part called, and the part that calls.

        The least of several tries, so that a machine busy for a moment does not pass for switching.
        """
        costs = [self._try_switching(calls) for _ in range(tries)]
        return min(inside for inside, _ in costs), min(before for _, before in costs)

    def _try_switching(self, calls: int) -> tuple[float, float]:
        def nothing() -> None:
            pass

        start = perf_counter()
        for _ in range(calls):
            nothing()
        plain = perf_counter() - start
        kept, self.sheet = self.sheet, Sheet()
        empty = self.timed(nothing, "nothing")
        self._since = perf_counter()
        for _ in range(calls):
            empty()
        seconds, self.sheet = self.sheet.seconds, kept
        return max(seconds["nothing"] - plain, 0.0) / calls, seconds[OUTSIDE] / calls
