"""What a person's keys say: a behaviour, round after round, for as long as the person wants it."""

import time
from collections.abc import Callable
from typing import NamedTuple, Protocol

from khepera_forage.task.states import Behaviour

LETTERS = {
    Behaviour.SEARCH_FOR_FOOD: "s",
    Behaviour.MOVE_SLOWLY: "m",
    Behaviour.ORIENT_WITH_FOOD: "o",
    Behaviour.EXPLORE_FOOD: "e",
    Behaviour.PICK_UP_FOOD: "p",
    Behaviour.PUSH_FOOD: "u",
    Behaviour.AVOID_FOOD: "a",
    Behaviour.GO_HOME: "g",
    Behaviour.AVOID_HOME: "v",
    Behaviour.RELEASE_FOOD: "r",
}
"""The key of each behaviour: a letter of its name. Its number in table 4.1 does the same."""
BEHAVIOUR_OF = {
    **{letter: behaviour for behaviour, letter in LETTERS.items()},
    **{str(int(behaviour)): behaviour for behaviour in LETTERS},
}
AGAIN, BEGIN_AGAIN, END = "space", "backspace", "escape"
GO_ON = ("return", "enter")


class KeyEvent(NamedTuple):
    """A key goes down or up.

    Attributes:
        key: A letter, a digit, or a name such as "space"; closing the window is "escape".
        down: Whether it went down.
    """

    key: str
    down: bool


class Keys(Protocol):
    """Where keys come from."""

    def wait(self, timeout: float | None = None) -> KeyEvent | None:
        """The next event; None if none comes within `timeout` seconds. Without a timeout it waits for ever."""
        ...


class BegunAgain(Exception):  # noqa: N818 (the person wants it so)
    """The person gives the attempt up, and begins again."""


class Ended(Exception):  # noqa: N818 (likewise)
    """The person ends the teaching."""


class Hand:
    """A hand on the keys: a tap is one round, a held key one after another, and with no key down nothing moves.

    Args:
        keys: Where the keys come from.
        period: Seconds from round to round while a key is held.
        changed: Called whenever another key is held, or none is any more.

    Attributes:
        last: The behaviour chosen last; what the space bar repeats.
    """

    def __init__(self, keys: Keys, period: float, changed: Callable[[], None]) -> None:
        self.last: Behaviour | None = None
        self._keys = keys
        self._period = period
        self._changed = changed
        self._held: dict[str, Behaviour] = {}  # the last one pressed stands last
        self._due = 0.0

    @property
    def held(self) -> Behaviour | None:
        """What the key says that is held; the last one pressed if there are several."""
        return next(reversed(self._held.values()), None)

    def choose(self) -> Behaviour:
        """The behaviour of the next round; waits for it.

        Raises:
            BegunAgain: Backspace.
            Ended: Escape, or the window was closed.
        """
        while True:
            event = self._keys.wait(self._left() if self._held else None)
            chosen = self.held if event is None else self._take(event)
            if chosen is not None:
                self.last = chosen
                self._due = time.monotonic() + self._period
                return chosen

    def rest(self) -> None:
        """Let one round's time go by, in which nothing is chosen.

        Raises:
            BegunAgain: Backspace.
            Ended: Escape, or the window was closed.
        """
        self._due = time.monotonic() + self._period
        while (event := self._keys.wait(self._left())) is not None:
            self._take(event)

    def confirm(self) -> None:
        """Wait for Enter; what is held until then counts no longer.

        Raises:
            Ended: Escape, or the window was closed.
        """
        while True:
            event = self._keys.wait()
            if event is not None and event.down and event.key == END:
                raise Ended
            if event is not None and event.down and event.key in GO_ON:
                self._held.clear()
                self.last = None
                return

    def _left(self) -> float:
        return max(0.0, self._due - time.monotonic())

    def _take(self, event: KeyEvent) -> Behaviour | None:
        """What an event chooses, if anything."""
        before, (key, down) = self.held, event
        if down and key == END:
            raise Ended
        if down and key == BEGIN_AGAIN:
            raise BegunAgain
        self._held.pop(key, None)
        chosen = (self.last if key == AGAIN else BEHAVIOUR_OF.get(key)) if down else None
        if chosen is not None:
            self._held[key] = chosen
        if self.held != before:
            self._changed()
        return chosen
