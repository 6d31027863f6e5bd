"""Framing: splitting a stream of bytes into lines."""

import re

MAX_LINE = 256
"""Bytes of a line that `LineSplitter` keeps; the longest replies, of H and K, have fewer than 60."""


class LineSplitter:
    """Splits bytes, received in chunks of any size, into lines without their endings: LF, CR or CR LF.

    Empty lines are dropped. Of a longer line, the first `MAX_LINE` bytes are kept.
    """

    def __init__(self) -> None:
        self._incomplete = bytearray()

    def feed(self, data: bytes) -> list[bytes]:
        """Take the next chunk; returns the lines that it completes, oldest first. Never raises."""
        lines = []
        *ends, rest = re.split(rb"[\r\n]", data)
        for end in ends:
            line = (bytes(self._incomplete) + end)[:MAX_LINE]
            self._incomplete.clear()
            if line:
                lines.append(line)
        self._incomplete += rest[: MAX_LINE - len(self._incomplete)]
        return lines
