"""Keys and the behaviours that they choose, round by round."""

import time
from collections.abc import Callable, Mapping
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
"""The key of each behaviour: a letter of its name. The digit of its number in table 4.1 works too."""
BEHAVIOUR_OF = {
    **{letter: behaviour for behaviour, letter in LETTERS.items()},
    **{str(int(behaviour)): behaviour for behaviour in LETTERS},
}
REPEAT, RESTART, QUIT = "space", "backspace", "escape"
CONFIRM = ("return", "enter")


class Caption(NamedTuple):
    """What is written under the picture: a message, and the keys of the behaviours.

    Attributes:
        letters: The key of each behaviour; its number in table 4.1 is shown beside it.
        message: What happens now, and which keys to press.
        hint: Other keys; left out if the message leaves no room.
        warning: Whether the message is a warning.
        held: The behaviour whose key is held, if any.
        last: The behaviour chosen last, if any.
    """

    letters: Mapping[Behaviour, str]
    message: str = ""
    hint: str = ""
    warning: bool = False
    held: Behaviour | None = None
    last: Behaviour | None = None


class KeyEvent(NamedTuple):
    """A key was pressed or released.

    Attributes:
        key: A letter, a digit, or a name such as "space"; closing the window counts as "escape".
        down: Whether the key was pressed.
    """

    key: str
    down: bool


class Keys(Protocol):
    """A source of key events."""

    def wait(self, timeout: float | None = None) -> KeyEvent | None:
        """Wait for the next event.

        Args:
            timeout: Seconds to wait; None waits without limit.

        Returns:
            The event, or None after the timeout.
        """
        ...


class RestartRequest(Exception):  # noqa: N818 (a wish of the person, not an error)
    """The person discards this attempt and begins again."""


class QuitRequest(Exception):  # noqa: N818 (a wish of the person, not an error)
    """The person ends the teaching."""


class BehaviourKeys:
    """Chooses behaviours from key events: a tap is one round, a held key repeats, without a key nothing moves.

    Args:
        keys: The source of key events.
        period: Seconds between rounds while a key is held.
        on_change: Called when the held behaviour changes.

    Attributes:
        last: The last chosen behaviour, which the space bar repeats; None before the first.
    """

    def __init__(self, keys: Keys, period: float, on_change: Callable[[], None]) -> None:
        self.last: Behaviour | None = None
        self._keys = keys
        self._period = period
        self._on_change = on_change
        self._held: dict[str, Behaviour] = {}  # by key, in the order in which the keys were pressed
        self._due = 0.0

    @property
    def held(self) -> Behaviour | None:
        """The behaviour of the held key; of several keys, the one pressed last; None without a key."""
        return next(reversed(self._held.values()), None)

    def choose(self) -> Behaviour:
        """Wait for the behaviour of the next round.

        Raises:
            RestartRequest: Backspace.
            QuitRequest: Escape, or the window was closed.
        """
        while True:
            event = self._keys.wait(self._left() if self._held else None)
            chosen = self.held if event is None else self._take(event)
            if chosen is not None:
                self.last = chosen
                self._due = time.monotonic() + self._period
                return chosen

    def rest(self) -> None:
        """Wait for the duration of one round; keys choose nothing.

        Raises:
            RestartRequest: Backspace.
            QuitRequest: Escape, or the window was closed.
        """
        self._due = time.monotonic() + self._period
        while (event := self._keys.wait(self._left())) is not None:
            self._take(event)

    def confirm(self) -> None:
        """Wait for Enter, and forget the keys pressed before it.

        Raises:
            QuitRequest: Escape, or the window was closed.
        """
        while True:
            event = self._keys.wait()
            if event is not None and event.down and event.key == QUIT:
                raise QuitRequest
            if event is not None and event.down and event.key in CONFIRM:
                self._held.clear()
                self.last = None
                return

    def _left(self) -> float:
        return max(0.0, self._due - time.monotonic())

    def _take(self, event: KeyEvent) -> Behaviour | None:
        """Process an event; returns the behaviour that it chooses, if any."""
        before, (key, down) = self.held, event
        if down and key == QUIT:
            raise QuitRequest
        if down and key == RESTART:
            raise RestartRequest
        self._held.pop(key, None)
        chosen = (self.last if key == REPEAT else BEHAVIOUR_OF.get(key)) if down else None
        if chosen is not None:
            self._held[key] = chosen
        if self.held != before:
            self._on_change()
        return chosen
