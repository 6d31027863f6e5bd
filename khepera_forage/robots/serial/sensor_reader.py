"""The sensors of a robot: which readings a round needs, and their confirmation."""

import time
from collections.abc import Mapping

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
    Limits,
    Values,
    arm_position,
    jaw_position,
    object_presence,
    read_confirmed,
    within,
)

_PROXIMITY, _BARRIER, _COUNTERS = Request("N"), Request("T,1,G"), Request("H")
_JAW, _ARM = Request("T,1,H", (0,)), Request("T,1,H", (1,))


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
        self._received: dict[Request, Reply] = {}

    def begin_round(self) -> list[Request]:
        """Begin a round; returns its requests. Equal letters never follow each other: that would cost another one."""
        arm = [_ARM] if self.arm.is_due() else []
        jaw = [_JAW] if self.jaw.is_due() else []
        return [_PROXIMITY, *arm, _BARRIER, *jaw, _COUNTERS]

    def read(self, requests: list[Request], received: Mapping[Request, Reply], speeds: Values) -> Senses:
        """Read what `begin_round` returned.

        Args:
            requests: The requests of the round.
            received: Replies that have arrived already; the other requests are sent.
            speeds: Of the wheels, as commanded.

        Raises:
            RobotLost: The robot does not reply, or its first readings contradict each other.
        """
        self._received = dict(received)
        a, b, c, d, e, f, g, h = self._proximity = self._read(_PROXIMITY, PROXIMITY_LIMITS, self._proximity)
        if _ARM in requests:
            self._read_position(_ARM, self.arm, ARM_LIMITS)
        (presence,) = self._presence = self._read(_BARRIER, PRESENCE_LIMITS, self._presence)
        if _JAW in requests:
            self._read_position(_JAW, self.jaw, JAW_LIMITS)
        self._read_counters(speeds)
        assert self.arm.value is not None, "is_due is true until there is a reading"
        assert self.jaw.value is not None, "is_due is true until there is a reading"
        arm, jaw = arm_position(self.arm.value), jaw_position(self.jaw.value)
        return Senses((a, b, c, d, e, f, g, h), *self.counters.total, arm, jaw, presence)

    def _values(self, request: Request) -> Values:
        reply = self._received.pop(request, None) or self._client.request(request)
        values = tuple(value for value in reply.values if isinstance(value, int))
        return (object_presence(values[0]),) if request == _BARRIER else values

    def _read(self, request: Request, limits: Limits, last: Values | None) -> Values:
        values = read_confirmed(
            lambda: self._values(request),
            lambda values: last is not None and within(values, last, limits.max_change),
            lambda first, second: within(first, second, limits.equal_within),
        )
        return self._known(request, values, last)

    def _read_position(self, request: Request, position: GripperPosition, limits: Limits) -> None:
        # Compare raw readings: limiting them to the range of `Senses` could hide a lost digit.
        values = read_confirmed(
            lambda: self._values(request),
            position.plausible,
            lambda first, second: within(first, second, limits.equal_within),
        )
        last = None if position.value is None else (position.value,)
        position.update(self._known(request, values, last)[0])

    def _read_counters(self, speeds: Values) -> None:
        read_at: list[float] = []

        def read() -> Values:
            values = self._values(_COUNTERS)
            read_at.append(time.monotonic())
            return values

        values = read_confirmed(
            read,
            lambda values: self.counters.plausible(values, speeds),
            lambda first, second: agree(first, second, speeds, read_at[-1] - read_at[-2]),
        )
        if values is not None or self.counters.raw is None:
            # An unknown reading needs no replacement: the next one contains its travel.
            self.counters.update(self._known(_COUNTERS, values, None))
        else:
            self._client.transport.statistics.unknown += 1

    def _known(self, request: Request, values: Values | None, last: Values | None) -> Values:
        """The reading, or the last one if it is unknown."""
        if values is not None:
            return values
        if last is None:
            command = encode_request(request).decode().strip()
            raise RobotLost(self._client.port, command, MAX_READINGS, "the readings contradict each other")
        self._client.transport.statistics.unknown += 1
        return last
