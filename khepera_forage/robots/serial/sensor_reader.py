"""The sensors of a robot: which readings a round needs, and their confirmation."""

import time
from collections.abc import Callable, Sequence

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
    arm_passed,
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
        self._period = period
        self._proximity: Values | None = None
        self._presence: Values | None = None
        self._received: list[tuple[Request, Reply]] = []
        self._unconfirmed: dict[Request, tuple[float, Values]] = {}
        """Readings of the last round that were neither plausible nor confirmed, with their times."""

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
        """The requests whose replies are not plausible and do not confirm the last ones: `read` needs them again."""
        if len(set(requests)) < len(requests):
            return []  # There are two replies to each.
        now = time.monotonic()
        again = []
        for request, reply in zip(requests, received, strict=True):
            values = _values(request, reply)
            read_at, before = self._unconfirmed.get(request, (now, None))
            confirmed = before is not None and self._same(request, before, values, speeds, now - read_at)
            if not confirmed and not self._plausible(request, values, speeds):
                again.append(request)
        # Equal letters must not follow each other: a repeated reply to one could be taken for the reply to the other.
        if again == [_COUNTERS]:  # The counters were the last reading, too.
            again.insert(0, _BARRIER)
        elif _ARM in again and _JAW in again and _BARRIER not in again:
            again.insert(again.index(_JAW), _BARRIER)
        return again

    def read(
        self,
        requests: Sequence[Request],
        received: Sequence[Reply],
        speeds: Values,
        may_repeat: Callable[[Request], bool],
    ) -> Senses:
        """Read what `begin_round` returned.

        Args:
            requests: The requests of the round, and `doubtful` ones.
            received: The replies to these.
            speeds: Of the wheels, as commanded.
            may_repeat: Whether there is time to send a request again. Otherwise an implausible reading is unknown; the
                reading of the next round may confirm it.

        Raises:
            RobotLost: The robot does not reply, or its first readings contradict each other.
        """
        self._received = [*zip(requests, received, strict=True)]
        self._may_repeat = may_repeat
        self._proximity = self._read(_PROXIMITY, speeds, self._proximity) or self._proximity
        self._read_position(_ARM, self.arm, requests, speeds)
        self._presence = self._read(_BARRIER, speeds, self._presence) or self._presence
        self._read_position(_JAW, self.jaw, requests, speeds)
        # Unknown counters need no replacement: the next reading contains their travel.
        if (counts := self._read(_COUNTERS, speeds, self.counters.raw)) is not None:
            self.counters.update(counts)
        assert self._proximity is not None, "a first reading is never unknown"
        assert self._presence is not None, "a first reading is never unknown"
        a, b, c, d, e, f, g, h = self._proximity
        (presence,) = self._presence
        assert self.arm.value is not None, "is_due is true until there is a reading"
        assert self.jaw.value is not None, "is_due is true until there is a reading"
        arm, jaw = arm_position(self.arm.value), jaw_position(self.jaw.value)
        return Senses((a, b, c, d, e, f, g, h), *self.counters.total, arm, jaw, presence)

    def _read_position(
        self, request: Request, position: GripperPosition, requests: Sequence[Request], speeds: Values
    ) -> None:
        if request in requests:
            last = None if position.value is None else (position.value,)
            values = self._read(request, speeds, last)
            if values is not None:
                position.update(values[0])

    def _read(self, request: Request, speeds: Values, last: Values | None) -> Values | None:
        """A confirmed reading; None if it is unknown."""
        unconfirmed = self._unconfirmed.pop(request, None)
        readings = [] if unconfirmed is None else [unconfirmed]

        def read() -> Values | None:
            reply = self._reply(request, last is None)
            if reply is None:
                return None
            readings.append((time.monotonic(), _values(request, reply)))
            return readings[-1][1]

        def same(first: Values, second: Values) -> bool:
            return self._same(request, first, second, speeds, readings[-1][0] - readings[-2][0])

        before = None if unconfirmed is None else unconfirmed[1]
        values = read_confirmed(read, lambda values: self._plausible(request, values, speeds), same, before)
        if values is not None:
            return values
        if last is None:
            command = encode_request(request).decode().strip()
            raise RobotLost(self._client.port, command, MAX_READINGS, "the readings contradict each other")
        self._client.transport.statistics.unknown += 1
        self._unconfirmed[request] = readings[-1]
        return None

    def _reply(self, request: Request, is_first: bool) -> Reply | None:
        """A reply that was already received, or a new one if there is time, or if there was no reading before."""
        place = next((i for i, (received, _) in enumerate(self._received) if received == request), None)
        if place is not None:
            return self._received.pop(place)[1]
        return self._client.request(request) if is_first or self._may_repeat(request) else None

    def _same(self, request: Request, first: Values, second: Values, speeds: Values, seconds: float) -> bool:
        """Whether two consecutive readings show the same."""
        if request == _COUNTERS:
            # A simulation advances by one period even if it takes longer to compute.
            return any(agree(first, second, speeds, time) for time in {seconds, min(seconds, self._period)})
        return within(first, second, _LIMITS[request].equal_within)

    def _plausible(self, request: Request, values: Values, speeds: Values) -> bool:
        # Raw positions: limiting them to the range of `Senses` could hide a lost digit.
        if request == _ARM:
            return self.arm.plausible(values)
        if request == _JAW:
            return self.jaw.plausible(values)
        if request == _COUNTERS:
            return self.counters.plausible(values, speeds)
        if request == _BARRIER:
            return values == self._presence
        last = self._proximity
        if last is None:
            return False
        return within(values, last, PROXIMITY_LIMITS.max_change) or arm_passed(last, values)


def _values(request: Request, reply: Reply) -> Values:
    values = tuple(value for value in reply.values if isinstance(value, int))
    return (object_presence(values[0]),) if request == _BARRIER else values
