"""The latency of a line, how requests are sent on it, and the control rate that it allows.

The latency is what a reply takes in addition to the transmission of its bytes: under 2 ms on a serial port, up to 16 ms
with a USB adapter, more over radio or a network.

On a line with a noticeable latency, the requests of a round are *pipelined*: sent without waiting for each reply, so
that the latency counts once a round and not once a request. PYRO controls real Kheperas in this way; other drivers wait
for each reply, as this one does on a fast line without late replies. If a robot does not answer pipelined requests
together when its port is opened, it receives all requests one by one.
"""

import math
import statistics
import time
from typing import NamedTuple

from khepera_forage.robots.khepera import RobotLost
from khepera_forage.robots.serial.client import ProtocolClient
from khepera_forage.robots.serial.errors import LineTooSlow
from khepera_forage.robots.serial.port import seconds_on_wire
from khepera_forage.robots.serial.protocol import Request, encode_reply, encode_request

OPENING_TIMEOUT = 1.9
"""Seconds for opening: then the robot counts as lost, or its line as too slow."""
MAX_ROUND_BYTES, MAX_ROUND_REQUESTS = 170, 8
"""Bytes and requests of a round in which arm and jaw move and all numbers have the maximum number of digits."""

_SHORTEST_ANSWERS, _LONGEST_ANSWERS = (3, 45), (5, 129)
"""Requests of `receive` and bytes both ways: without positions of the gripper and with numbers of one digit, or with
both positions and with all digits."""
_ROUND_REQUESTS = 4
"""D, N, T,1,G and H: a round in which the gripper rests."""
_ROUND_BYTES = 61
"""Bytes of such a round, both ways: the median of `benchmarks/wire.py`."""
_GRIPPER_REQUESTS, _GRIPPER_BYTES = 6, 103
"""The same for a round in which the gripper moves."""
_MEASUREMENTS = 5
_MEASURING_TIMEOUT = 1.2
"""Seconds after which no further measurement begins."""
_PATIENCE = 0.6
"""Seconds to wait for a reply before the latency is known: a repeated request would distort the measurement."""
_FAST = 0.005
"""Seconds: up to this latency, requests are sent one by one."""
_BATCH = tuple(Request(command) for command in ("N", "E", "H"))
"""Requests that a robot without a gripper answers, too."""


class LineTiming(NamedTuple):
    """The timing of a line.

    Attributes:
        baud: Its baud rate.
        latency: Seconds that a reply takes in addition to the transmission of its bytes.
        pipelined: Whether the requests of a round are sent without waiting for each reply.
        can_pipeline: Whether the robot answers requests that are sent in this way.
    """

    baud: int
    latency: float = 0.0
    pipelined: bool = False
    can_pipeline: bool = False

    @property
    def round_time(self) -> float:
        """Seconds that the exchange of a round takes while the gripper rests."""
        return self.duration(_ROUND_REQUESTS, _ROUND_BYTES)

    def duration(self, requests: int, length: int) -> float:
        """Seconds that requests take whose bytes, with those of the replies, have this length."""
        waits = 1 if self.pipelined else requests
        return waits * self.latency + seconds_on_wire(length, self.baud)

    @property
    def variation(self) -> float:
        """Seconds by which the first readings of one round may take longer than those of another."""
        return self.duration(*_LONGEST_ANSWERS) - self.duration(*_SHORTEST_ANSWERS)

    def longest_round(self, period: float) -> float:
        """Seconds from the end of a round to the end of the next one, at most, at a fixed rate without late replies."""
        usual = period + max(self.latency, self.variation)
        if self.duration(_GRIPPER_REQUESTS, _GRIPPER_BYTES) <= period:
            return usual
        # A clock that such rounds have delayed by half a period skips the rest of it.
        return max(usual, 1.5 * period + self.variation)

    def latest_end(self, period: float) -> float:
        """Seconds from the beginning of a period to the end of its exchange, at most: the period and one latency.

        At the beginning of each period, the readings are requested. The exchange ends when they have arrived and the
        next commands have been sent. This holds without late replies if the exchange of a round in which the gripper
        moves takes at most half a period and one latency; `longest_round` limits the time between two such ends.
        """
        return period + self.latency

    def check(self, port: str, period: float) -> None:
        """Check that a round fits into its period.

        Raises:
            LineTooSlow: It does not.
        """
        if self.round_time <= period:
            return
        waits = 1 if self.pipelined else _ROUND_REQUESTS
        possible = math.ceil(100 * self.round_time) / 100
        longest = max(0.0, (period - seconds_on_wire(_ROUND_BYTES, self.baud)) / waits)
        raise LineTooSlow(
            f"{port} is too slow for rounds of {period:g} s: a reply takes {1000 * self.latency:.0f} ms longer than "
            f"its transmission, and a round {1000 * self.round_time:.0f} ms; required: at most {1000 * longest:.0f} ms "
            f"for a reply at {self.baud} baud. Lengthen the period to {possible:.2f} s or more, raise the baud "
            "rate, or shorten the latency (latency timer of a USB adapter, radio, network)"
        )


class LineTimer:
    """Measures a line while it is opened.

    Args:
        client: The connection to the robot.
    """

    def __init__(self, client: ProtocolClient) -> None:
        self._client = client
        self._begin = time.monotonic()
        self._latencies: list[float] = []
        client.timeout = max(client.base_timeout, _PATIENCE)
        client.exchange.deadline = self._begin + max(OPENING_TIMEOUT, client.tries * client.base_timeout)

    @property
    def is_late(self) -> bool:
        """Whether no further request fits into the time for opening, unless all replies so far had stalled."""
        return min(self._latencies) > _PATIENCE or time.monotonic() > self._begin + _MEASURING_TIMEOUT

    def request(self, request: Request) -> None:
        """Send a request, and measure the latency of its reply.

        Raises:
            RobotLost: No reply.
        """
        begin = time.monotonic()
        reply = self._client.request(request)
        length = len(encode_request(request)) + len(encode_reply(reply))
        self._latencies.append(time.monotonic() - begin - seconds_on_wire(length, self._client.baud))

    def request_after_late_reply(self, request: Request) -> bool:
        """Send a request and measure again: a single stall of the computer, the line or the robot is not a slow line.

        Returns:
            Whether a reply arrived in time. If not, the line is slow, with the latency measured before.

        Raises:
            RobotLost: The port failed, or the robot rejects the request.
        """
        exchange, deadline = self._client.exchange, self._client.exchange.deadline
        exchange.deadline = min(deadline, time.monotonic() + _PATIENCE)
        try:
            self.request(request)
        except RobotLost:
            if time.monotonic() < exchange.deadline:
                raise
            return False
        finally:
            exchange.deadline = deadline
        return True

    def finish(self) -> LineTiming:
        """Measure the rest, and adapt the client's timeout.

        Returns:
            The timing. Its latency is the shortest measured one: the others may contain disturbances.
        """
        client = self._client
        for number in range(len(self._latencies), _MEASUREMENTS):
            if self.is_late:
                break
            self.request(Request("E" if number % 2 == 0 else "B"))
        latency = max(0.0, min(self._latencies))
        # The lower of two medians: a stall must not count if there was time for two measurements only.
        client.adapt(latency, max(0.0, statistics.median_low(self._latencies)))
        can_pipeline = self._answers_a_batch(latency) or self._answers_a_batch(latency)
        return LineTiming(client.baud, latency, can_pipeline and latency > _FAST, can_pipeline)

    def _answers_a_batch(self, latency: float) -> bool:
        """Whether all replies to pipelined requests arrive, and together after one latency."""
        client = self._client
        if self.is_late:
            return True  # The line is too slow in any case, or there is no time to test it.
        begin = time.monotonic()
        replies = client.exchange.batch(_BATCH, client.timeout)
        taken = time.monotonic() - begin
        length = len(b"".join(encode_reply(reply) for reply in replies if reply is not None))
        length += len(b"".join(map(encode_request, _BATCH)))
        allowed = 1.5 * latency + 0.01 + seconds_on_wire(length, client.baud)
        return None not in replies and taken <= allowed
