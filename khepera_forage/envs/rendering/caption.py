"""Content of the caption under the picture when a person teaches, as plain values."""

from collections.abc import Mapping
from typing import NamedTuple

from khepera_forage.task.states import Behaviour


class Caption(NamedTuple):
    """A message, and the keys of the behaviours.

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
