"""What can happen on a robot's line: traffic, troubles and their count, and how a banner is told from garbage."""

import re
from dataclasses import dataclass
from typing import NamedTuple

from khepera_forage.robots.khepera import RobotLost
from khepera_forage.robots.serial.protocol import BANNER

_WORD = re.compile(r"[A-Za-z-]{4,}")
_WORDS = frozenset(word for line in BANNER for word in _WORD.findall(line))


class Restarted(Exception):  # noqa: N818 (an event, not a mistake)
    """The robot's restart banner came: it stands, and has forgotten what it was told."""


class Interrupted(Exception):  # noqa: N818
    """Something more urgent wants the line; what was asked is to be asked again."""


class Refused(RobotLost):
    """The robot answers, but only with an error: the command, or the turret it is for, is not there."""


class Traffic(NamedTuple):
    """Bytes on a line.

    Attributes:
        sent: Whether the host sent them; otherwise it received them.
        data: The bytes.
    """

    sent: bool
    data: bytes


@dataclass(slots=True)
class LineCounts:
    """What happened on a line since it was opened.

    Attributes:
        sent: Requests written.
        answered: Replies that matched a request.
        unanswered: Requests whose time ran out.
        garbled: Lines that are nothing of the protocol.
        foreign: Well-formed replies to something else, late and repeated ones among them.
        refused: Error replies (`z,...`).
        restarts: Restart banners.
    """

    sent: int = 0
    answered: int = 0
    unanswered: int = 0
    garbled: int = 0
    foreign: int = 0
    refused: int = 0
    restarts: int = 0


def is_of_banner(text: str) -> bool:
    """Whether a line has a whole word of the restart banner; its lines may end elsewhere than we think."""
    return not _WORDS.isdisjoint(_WORD.findall(text))
