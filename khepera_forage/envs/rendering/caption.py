"""What stands under a picture for a person at the keyboard, as plain values."""

from collections.abc import Mapping
from typing import NamedTuple

from khepera_forage.task.states import Behaviour


class Caption(NamedTuple):
    """A message, and the keys of the behaviours.

    Attributes:
        letters: The key of each behaviour; its number in table 4.1 is shown beside it.
        message: What is going on, and what to press.
        aside: What else can be pressed; left out where there is no room.
        warning: Whether something is wrong.
        lit: The behaviour whose key is held, if any.
        last: The one that was chosen last.
    """

    letters: Mapping[Behaviour, str]
    message: str = ""
    aside: str = ""
    warning: bool = False
    lit: Behaviour | None = None
    last: Behaviour | None = None
