"""The sensors of a robot: which readings a round needs, and their confirmation."""

import time
from collections.abc import Sequence

from khepera_forage.robots.khepera import RobotLost, Senses
from khepera_forage.robots.serial.client import ProtocolClient
from khepera_forage.robots.serial.encoder_counters import EncoderCounters, agree
from khepera_forage.robots.serial.gripper_position import GripperPosition
from khepera_forage.robots.serial.protocol import Reply, Request, encode_request
from khepera_forage.robots.serial.readings import (
    ARM_LIMITS,
    JAW_LIMITS,
    MAX_READINGS,
    PRESENCE_LIMITS,
    PROXIMITY_LIMITS,
    Values,
    arm_position,
    jaw_position,
    object_presence,
    read_confirmed,
    within,
)

_PROXIMITY, _BARRIER, _COUNTERS = Request("N"), Request("T,1,G"), Request("H")
_JAW, _ARM = Request("T,1,H", (0,)), Request("T,1,H", (1,))
_LIMITS = {
    _PROXIMITY: PROXIMITY_LIMITS,
    _BARRIER: PRESENCE_LIMITS,
    _ARM: ARM_LIMITS,
    _JAW: JAW_LIMITS,
}


class SensorReader:
    """Reads the sensors of a robot, round by round.

    Args:
        client: The connection to the robot.
        period: Seconds of a round.

    Attributes:
        arm: Position of the arm.
        jaw: Position of the jaw.
        counters: Of the wheels.
    """

    def __init__(self, client: ProtocolClient, period: float) -> None:
        self.arm = GripperPosition(ARM_LIMITS, can_stall=False, phase=0)
        self.jaw = GripperPosition(JAW_LIMITS, can_stall=True, phase=5)
        self.counters = EncoderCounters(period)
        self._client = client
        self._proximity: Values | None = None
        self._presence: Values | None = None
        self._received: list[tuple[Request, Reply]] = []

    def begin_round(self) -> list[Request]:
        """Begin a round; returns its requests, in the first round twice, because nothing confirms its readings.

        Equal letters never follow each other: that would cost a synchronisation request.
        """
        arm = [_ARM] if self.arm.is_due() else []
        jaw = [_JAW] if self.jaw.is_due() else []
        requests = [_PROXIMITY, *arm, _BARRIER, *jaw, _COUNTERS]
        return requests if self._proximity is not None else 2 * requests

    def doubtful(
        self, requests: Sequence[Request], received: Sequence[Reply], speeds: Values
    ) -> list[Request]:
        """The pipelined requests whose replies are not plausible, so that `read` needs them once more."""
        if len(set(requests)) < len(requests):
            return []  # There are two replies to each.
        again = [
            request
            for request, reply in zip(requests, received, strict=True)
            if not self._plausible(request, _values(request, reply), speeds)
        ]
        # Equal letters must not follow each other: a repeated reply to one could be taken for the reply to the other.
        if again == [_COUNTERS]:  # The counters were the last reading, too.
            again.insert(0, _BARRIER)
        elif _ARM in again and _JAW in again and _BARRIER not in again:
            again.insert(again.index(_JAW), _BARRIER)
        return again

    def read(self, requests: Sequence[Request], received: Sequence[Reply], speeds: Values) -> Senses:
        """Read what `begin_round` returned.

        Args:
            requests: The requests of the round, and `doubtful` ones.
            received: The replies to these, if they were pipelined; otherwise none.
            speeds: Of the wheels, as commanded.

        Raises:
            RobotLost: The robot does not reply, or its first readings contradict each other.
        """
        self._received = [*zip(requests, received, strict=False)]
        a, b, c, d, e, f, g, h = self._proximity = self._read(_PROXIMITY, speeds, self._proximity)
        self._read_position(_ARM, self.arm, requests, speeds)
        (presence,) = self._presence = self._read(_BARRIER, speeds, self._presence)
        self._read_position(_JAW, self.jaw, requests, speeds)
        unknown = self._client.transport.statistics.unknown
        counts = self._read(_COUNTERS, speeds, self.counters.raw)
        if unknown == self._client.transport.statistics.unknown:
            # An unknown reading needs no replacement: the next one contains its travel.
            self.counters.update(counts)
        assert self.arm.value is not None, "is_due is true until there is a reading"
        assert self.jaw.value is not None, "is_due is true until there is a reading"
        arm, jaw = arm_position(self.arm.value), jaw_position(self.jaw.value)
        return Senses((a, b, c, d, e, f, g, h), *self.counters.total, arm, jaw, presence)

    def _read_position(
        self, request: Request, position: GripperPosition, requests: Sequence[Request], speeds: Values
    ) -> None:
        if request in requests:
            last = None if position.value is None else (position.value,)
            position.update(self._read(request, speeds, last)[0])

    def _read(self, request: Request, speeds: Values, last: Values | None) -> Values:
        """A confirmed reading; the last one if it is unknown."""
        read_at: list[float] = []

        def read() -> Values:
            values = _values(request, self._reply(request))
            read_at.append(time.monotonic())
            return values

        def same(first: Values, second: Values) -> bool:
            if request == _COUNTERS:
                return agree(first, second, speeds, read_at[-1] - read_at[-2])
            return within(first, second, _LIMITS[request].equal_within)

        values = read_confirmed(read, lambda values: self._plausible(request, values, speeds), same)
        if values is not None:
            return values
        if last is None:
            command = encode_request(request).decode().strip()
            raise RobotLost(self._client.port, command, MAX_READINGS, "the readings contradict each other")
        self._client.transport.statistics.unknown += 1
        return last

    def _reply(self, request: Request) -> Reply:
        place = next((i for i, (received, _) in enumerate(self._received) if received == request), None)
        return self._client.request(request) if place is None else self._received.pop(place)[1]

    def _plausible(self, request: Request, values: Values, speeds: Values) -> bool:
        # Raw positions: limiting them to the range of `Senses` could hide a lost digit.
        if request == _ARM:
            return self.arm.plausible(values)
        if request == _JAW:
            return self.jaw.plausible(values)
        if request == _COUNTERS:
            return self.counters.plausible(values, speeds)
        last = self._proximity if request == _PROXIMITY else self._presence
        return last is not None and within(values, last, _LIMITS[request].max_change)


def _values(request: Request, reply: Reply) -> Values:
    values = tuple(value for value in reply.values if isinstance(value, int))
    return (object_presence(values[0]),) if request == _BARRIER else values
