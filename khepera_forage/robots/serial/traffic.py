"""Records of the traffic on a serial line: the bytes, and counts of events."""

from dataclasses import dataclass
from typing import NamedTuple


class Traffic(NamedTuple):
    """Bytes on a line.

    Attributes:
        sent: Whether the host sent them; otherwise it received them.
        data: The bytes.
    """

    sent: bool
    data: bytes


@dataclass(slots=True)
class LineStatistics:
    """Counts of events on a line since it was opened.

    Attributes:
        sent: Requests sent.
        answered: Requests with a matching reply.
        timeouts: Requests without a reply in time.
        garbled: Received lines that are not part of the protocol.
        unmatched: Well-formed replies to another request, such as late and repeated ones.
        rejected: Error replies (`z,...`).
        restarts: Restart banners.
        unknown: Readings that contradicted each other, so that the previous one was kept.
    """

    sent: int = 0
    answered: int = 0
    timeouts: int = 0
    garbled: int = 0
    unmatched: int = 0
    rejected: int = 0
    restarts: int = 0
    unknown: int = 0
