"""The driver of a real Khepera with a gripper."""

from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED, JAW_CLOSED, JAW_OPEN, PRESENT, Motors, Senses
from khepera_forage.robots.model import KHEPERA
from khepera_forage.robots.serial.protocol import KHEPERA as PROTOCOL
from khepera_forage.robots.serial.protocol import Request
from khepera_forage.robots.serial.serial_robot import LONGEST_ROUND, SerialRobot

BARRIER_THRESHOLD = 100
"""The optical barrier reads more than this with an object in it (PYRO)."""

_PROXIMITY, _BARRIER, _COUNTERS = Request("N"), Request("T,1,G"), Request("H")
_JAW, _ARM = Request("T,1,H", (0,)), Request("T,1,H", (1,))
_SHORT_EXCHANGE = 20
"""Bytes of a request and its reply with one number."""
_REFRESH_ROUNDS = 10
"""Rounds after which a position is requested although nothing moves."""
_AT_TARGET = 3
"""Positions within which a target counts as reached. Assumption."""


class SerialKhepera(SerialRobot):
    """A Khepera over a serial port. See `SerialRobot`.

    `transmit` sends the wheel speeds (D), and the targets of arm and jaw (T,1,E and T,1,D) when they change. `receive`
    always requests proximity (N), optical barrier (T,1,G) and counters (H). It requests the positions of arm and jaw
    (T,1,H) until they are at rest, then every tenth round.

    The barrier and the two positions enter the experience. A digit changed in transmission may leave a well-formed
    reply, so an unexpected value is requested again, and counts once two readings in a row agree.
    """

    model = KHEPERA
    protocol = PROTOCOL

    def turn_wheels(self, left: int, right: int) -> None:
        """See `RealRobot`."""
        self.request("D", int(self._limited(left)), int(self._limited(right)))

    def _begin_session(self) -> None:
        self._arm = GripperReading(max_change=8, can_stall=False, phase=0)
        self._jaw = GripperReading(max_change=45, can_stall=True, phase=5)
        self._barrier = GripperReading(max_change=0, can_stall=False, phase=0)
        super()._begin_session()

    def _requests(self, command: Motors) -> list[Request]:
        requests = [Request("D", (int(command.left), int(command.right)))]
        if command.arm != self._arm.target:
            requests.append(Request("T,1,E", (command.arm,)))
        if command.jaw != self._jaw.target:
            requests.append(Request("T,1,D", (0 if command.jaw == JAW_OPEN else 1,)))
        return requests

    def _note_sent(self, command: Motors | None) -> None:
        self._arm.set_target(None if command is None else command.arm)
        self._jaw.set_target(None if command is None else command.jaw)

    def _read_senses(self) -> Senses:
        begin = self._line.now()
        # Equal letters never follow each other: their replies could not be told apart.
        arm, jaw = [_ARM] * self._arm.is_due(), [_JAW] * self._jaw.is_due()
        values = self._read([_PROXIMITY, *arm, _BARRIER, *jaw, _COUNTERS])
        unconfirmed = self._unconfirmed(values)
        if unconfirmed:
            between = [_BARRIER] if unconfirmed == [_ARM, _JAW] else []
            again = [*unconfirmed[:1], *between, *unconfirmed[1:]]
            now, period = self._line.now(), self._period
            # That must not make a round late, unless a disturbance has delayed it already.
            is_late = now > begin + self.timing.duration(*LONGEST_ROUND)
            end = now + self.timing.duration(len(again), len(again) * _SHORT_EXCHANGE)
            if period is None or is_late or end <= begin + period:
                unconfirmed = self._unconfirmed(self._read(again))
            self.statistics.unknown += len(unconfirmed)
        left, right = values[_COUNTERS]
        self._count(left, right)
        a, b, c, d, e, f, g, h = values[_PROXIMITY]
        # A real arm can be raised further, or lie at the back.
        arm_position = max(ARM_RAISED, min(ARM_DOWN, self._arm.value))
        jaw_position = max(JAW_CLOSED, min(JAW_OPEN, self._jaw.value))
        presence = PRESENT if self._barrier.value else 0
        return Senses((a, b, c, d, e, f, g, h), *self._counts, arm_position, jaw_position, presence)

    def _read(self, requests: list[Request]) -> dict[Request, tuple[int, ...]]:
        """The values of replies, all numbers; 1 for an interrupted barrier."""
        replies = zip(requests, self._exchange(requests), strict=True)
        values = {request: tuple(map(int, reply.values)) for request, reply in replies}
        if _BARRIER in values:
            values[_BARRIER] = (int(values[_BARRIER][0] > BARRIER_THRESHOLD),)
        return values

    def _unconfirmed(self, values: dict[Request, tuple[int, ...]]) -> list[Request]:
        """Take readings; returns the requests of those that another reading must confirm."""
        readings = {_ARM: self._arm, _BARRIER: self._barrier, _JAW: self._jaw}
        return [r for r, reading in readings.items() if r in values and not reading.take(values[r][0])]


class GripperReading:
    """A reading of the gripper: its value, the commanded target (None: unknown), and when to request it.

    Args:
        max_change: Largest change from round to round that needs no confirmation.
        can_stall: Whether it may stop short of its target for good, as a jaw does that closes on food. An arm that
            rests on an obstacle moves on once there is room: it is requested until it reaches its target.
        phase: Round of `_REFRESH_ROUNDS` in which it is always requested.
    """

    def __init__(self, *, max_change: int, can_stall: bool, phase: int) -> None:
        self.value = 0
        self.target: int | None = None
        self._max_change, self._can_stall = max_change, can_stall
        self._doubt: int | None = None
        self._has_value = False
        self._rounds_at_rest = 0
        self._round = -phase

    def set_target(self, target: int | None) -> None:
        """Record a target; None if the robot has lost it in a restart."""
        if target != self.target:
            self.target = target
            self._rounds_at_rest = 0

    def is_due(self) -> bool:
        """Begin a round; returns whether the reading must be requested in it."""
        self._round += 1
        arrived = self.target is not None and abs(self.value - self.target) <= _AT_TARGET
        at_rest = self._rounds_at_rest >= (1 if arrived else 10)
        settled = at_rest and (arrived or self._can_stall or self.target is None)
        return not self._has_value or not settled or self._round % _REFRESH_ROUNDS == 0

    def take(self, value: int) -> bool:
        """Take a reading; returns whether it counts: it is expected, or agrees with the one before.

        Expected is a value between the last one and the target, and not too far from the last one.
        """
        target = self.value if self.target is None else self.target
        low, high = min(self.value, target), max(self.value, target)
        on_the_way = low - _AT_TARGET <= value <= high + _AT_TARGET
        expected = self._has_value and on_the_way and abs(value - self.value) <= self._max_change
        if not expected and (self._doubt is None or abs(value - self._doubt) > self._max_change):
            self.value = self.value if self._has_value else value
            self._doubt = value
            return False
        self._rounds_at_rest = self._rounds_at_rest + 1 if value == self.value else 0
        self.value, self._doubt, self._has_value = value, None, True
        return True
