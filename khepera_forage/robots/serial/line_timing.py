"""The timing of a serial line: its latency, and the rounds that it allows."""

import math
from typing import NamedTuple

from khepera_forage.robots.serial.protocol import seconds_on_wire

MAX_ROUND_BYTES, MAX_ROUND_REQUESTS = 170, 8
"""Bytes and requests of a round in which arm and jaw move and all numbers have the maximum number of digits."""
FAST = 0.005
"""Seconds: up to this latency, a command is confirmed before the round goes on."""

_SHORTEST_ANSWERS, _LONGEST_ANSWERS = (3, 45), (5, 129)
"""Requests of `receive` and bytes both ways: without positions of the gripper and with numbers of one digit, or with
both positions and with all digits."""
_ROUND, _GRIPPER_ROUND = (4, 61), (6, 103)
"""The same for a round in which the gripper rests (D, N, T,1,G and H), or moves: medians of `benchmarks/wire.py`."""


class LineTooSlow(ConnectionError):  # noqa: N818
    """The latency of a line does not allow rounds of the required duration."""


class LineTiming(NamedTuple):
    """The timing of a line.

    Attributes:
        latency: Seconds that a reply takes in addition to the transmission of its bytes: under 2 ms on a serial port,
            up to 16 ms with a USB adapter, more over radio or a network.
        pipelined: Whether the robot answers requests that are sent together; if not, it gets them one by one.
    """

    baud: int
    stop_bits: int = 2
    latency: float = 0.0
    pipelined: bool = False

    @property
    def round_time(self) -> float:
        """Seconds that the exchange of a round takes while the gripper rests."""
        return self.duration(*_ROUND)

    def duration(self, requests: int, length: int) -> float:
        """Seconds that requests take whose bytes, with those of the replies, have this length."""
        waits = requests if not self.pipelined else 1 if self.latency > FAST else min(requests, 2)
        return waits * self.latency + seconds_on_wire(length, self.baud, self.stop_bits)

    @property
    def variation(self) -> float:
        """Seconds by which the first readings of one round may take longer than those of another."""
        return self.duration(*_LONGEST_ANSWERS) - self.duration(*_SHORTEST_ANSWERS)

    def longest_round(self, period: float) -> float:
        """Seconds from the end of a round to the end of the next one, at most, at a fixed rate without late replies."""
        usual = period + max(self.latency, self.variation)
        if self.duration(*_GRIPPER_ROUND) <= period:
            return usual
        # A clock that such rounds have delayed by half a period skips the rest of it.
        return max(usual, 1.5 * period + self.variation)

    def latest_end(self, period: float) -> float:
        """Seconds from the beginning of a period to the end of its exchange, at most: the period and one latency.

        The readings are requested at the beginning of each period; the exchange ends when the next commands have been
        sent. This holds without late replies if a round in which the gripper moves takes at most half a period and one
        latency.
        """
        return period + self.latency

    def check(self, port: str, period: float) -> None:
        """Raise `LineTooSlow` if a round does not fit into its period."""
        if self.round_time <= period:
            return
        waits = 1 if self.pipelined else _ROUND[0]
        possible = math.ceil(100 * self.round_time) / 100
        longest = max(0.0, (period - self._replace(latency=0.0).round_time) / waits)
        raise LineTooSlow(
            f"{port} is too slow for rounds of {period:g} s: a reply takes {1000 * self.latency:.0f} ms longer than "
            f"its transmission, and a round {1000 * self.round_time:.0f} ms; required: at most {1000 * longest:.0f} ms "
            f"for a reply at {self.baud} baud. Lengthen the period to {possible:.2f} s or more, raise the baud "
            "rate, or shorten the latency (latency timer of a USB adapter, radio, network)"
        )
