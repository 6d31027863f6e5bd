"""The session with a Khepera: the requests of a round, in their order, and the state kept between rounds.

Runs in the thread that owns the port.
"""

from collections.abc import Callable

from khepera_forage.robots.khepera import JAW_OPEN, Motors, RobotLost, Senses
from khepera_forage.robots.serial.client import ProtocolClient
from khepera_forage.robots.serial.encoder_counters import EncoderCounters
from khepera_forage.robots.serial.errors import RobotRestarted
from khepera_forage.robots.serial.gripper_position import GripperPosition
from khepera_forage.robots.serial.protocol import Request
from khepera_forage.robots.serial.readings import (
    ARM_LIMITS,
    COUNTER_LIMITS,
    JAW_LIMITS,
    PRESENCE_LIMITS,
    PROXIMITY_LIMITS,
    Limits,
    Values,
    arm_position,
    jaw_position,
    object_presence,
    read_confirmed,
)

MAX_RESTARTS = 5
"""Restarts tolerated within one call; after more, the robot counts as lost: its power supply is unusable."""
TOO_MANY_RESTARTS = "it restarts again and again"

_JAW, _ARM = 0, 1
"""Argument of T,1,H."""


class Session:
    """The exchange with one robot, round by round.

    Args:
        client: The connection to the robot.
    """

    def __init__(self, client: ProtocolClient) -> None:
        self._client = client
        self._speeds = self._speeds_before = (0, 0)
        self._command: Motors | None = None
        self._sent_arm: int | None = None
        self._sent_jaw: int | None = None
        self._arm = GripperPosition(ARM_LIMITS, can_stall=False, phase=0)
        self._jaw = GripperPosition(JAW_LIMITS, can_stall=True, phase=5)
        self._counters = EncoderCounters()
        self._proximity: Values | None = None
        self._presence: Values | None = None
        self._must_restore = False

    def begin(self) -> None:
        """Check that a Khepera replies, and stop its wheels.

        Request B comes first: it is sent again if the robot rejects it because another program left an unfinished
        request on the line.
        """
        self.request("B")
        self._set_speeds(0, 0)

    def request(self, command: str, *values: int) -> tuple[int | str, ...]:
        """Send one request; returns the values of the reply."""
        return self._client.request(Request(command, values)).values

    def transmit(self, command: Motors) -> None:
        """Send the wheel speeds, and the targets of arm and jaw if they have changed."""
        self._command = command
        self._set_speeds(int(command.left), int(command.right))
        if command.arm != self._sent_arm:
            self.request("T,1,E", command.arm)
            self._sent_arm = command.arm
            self._arm.set_target(command.arm)
        if command.jaw != self._sent_jaw:
            self.request("T,1,D", 0 if command.jaw == JAW_OPEN else 1)
            self._sent_jaw = command.jaw
            self._jaw.set_target(command.jaw)

    def receive(self) -> Senses:
        """Read the sensors. Equal letters never follow each other: that would cost a synchronisation request."""
        arm_due, jaw_due = self._arm.is_due(), self._jaw.is_due()
        a, b, c, d, e, f, g, h = self._proximity = self._read(
            PROXIMITY_LIMITS, self._proximity, lambda: self._numbers("N")
        )
        if arm_due:
            self._read_position(self._arm, ARM_LIMITS, _ARM)
        (presence,) = self._presence = self._read(
            PRESENCE_LIMITS, self._presence, lambda: (object_presence(self._numbers("T,1,G")[0]),)
        )
        if jaw_due:
            self._read_position(self._jaw, JAW_LIMITS, _JAW)
        self._read_counters()
        assert self._arm.value is not None, "is_due is true until there is a reading"
        assert self._jaw.value is not None, "is_due is true until there is a reading"
        arm, jaw = arm_position(self._arm.value), jaw_position(self._jaw.value)
        return Senses((a, b, c, d, e, f, g, h), *self._counters.total, arm, jaw, presence)

    def stop(self, discard_command: bool) -> None:
        """Stop the wheels.

        Args:
            discard_command: Whether the wheels also remain stopped after a restart of the robot; otherwise the last
                command is then restored.

        Raises:
            RobotLost: The robot does not confirm.
        """
        if discard_command and self._command is not None:
            self._command = self._command._replace(left=0, right=0)
        for _ in range(MAX_RESTARTS):
            try:
                self._client.request_at_once(Request("D", (0, 0)))
                self._speeds = (0, 0)
                return
            except RobotRestarted:
                self.on_restart()
        raise RobotLost(self._client.port, "D,0,0", MAX_RESTARTS, TOO_MANY_RESTARTS)

    def on_restart(self) -> None:
        """Record that the robot sent its banner."""
        self._counters.restarted()
        self._must_restore = True

    def restore(self) -> None:
        """After a restart of the robot, send the last command again."""
        if not self._must_restore:
            return
        self._sent_arm = self._sent_jaw = None
        self._arm.set_target(None)
        self._jaw.set_target(None)
        if self._command is not None:
            self.transmit(self._command)
        self._must_restore = False

    def _set_speeds(self, left: int, right: int) -> None:
        self.request("D", left, right)
        self._speeds_before, self._speeds = self._speeds, (left, right)

    def _numbers(self, command: str, *values: int) -> Values:
        return tuple(value for value in self.request(command, *values) if isinstance(value, int))

    def _read(self, limits: Limits, last: Values | None, read: Callable[[], Values]) -> Values:
        def implausible(values: Values) -> bool:
            return last is None or any(
                abs(a - b) > limits.max_change for a, b in zip(values, last, strict=True)
            )

        return read_confirmed(read, implausible, limits.equal_within)

    def _read_position(self, position: GripperPosition, limits: Limits, part: int) -> None:
        # Compare raw readings: limiting them to the range of `Senses` could hide a lost digit.
        (value,) = read_confirmed(
            lambda: self._numbers("T,1,H", part), position.implausible, limits.equal_within
        )
        position.update(value)

    def _read_counters(self) -> None:
        raw = read_confirmed(
            lambda: self._numbers("H"),
            lambda values: self._counters.implausible(values, self._speeds, self._speeds_before),
            COUNTER_LIMITS.equal_within,
        )
        if self._counters.update(raw):
            self._must_restore = True
