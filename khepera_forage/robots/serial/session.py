"""What is said to a real Khepera in a round: which commands, in which order, and what is remembered meanwhile.

Runs in the thread that owns the port.
"""

from collections.abc import Callable

from khepera_forage.robots.khepera import JAW_OPEN, Motors, RobotLost, Senses
from khepera_forage.robots.serial.line_events import Restarted
from khepera_forage.robots.serial.link import SerialLink
from khepera_forage.robots.serial.protocol import Request
from khepera_forage.robots.serial.readings import (
    ARM,
    COUNTERS,
    JAW,
    PRESENCE,
    PROXIMITY,
    Counters,
    Kind,
    Position,
    Values,
    arm_of,
    confirmed,
    jaw_of,
    present,
)

_RESTARTS = 5
"""Restarts borne within one call: a supply that fails more often than that will not do."""


class Dialogue:
    """The rounds of one robot.

    Args:
        link: The line to it.
    """

    def __init__(self, link: SerialLink) -> None:
        self._link = link
        self._wheels = self._wheels_before = (0, 0)
        self._told: Motors | None = None
        self._sent_arm: int | None = None
        self._sent_jaw: int | None = None
        self._arm = Position(ARM, stalls=False, phase=0)
        self._jaw = Position(JAW, stalls=True, phase=5)
        self._counters = Counters()
        self._proximity: Values | None = None
        self._presence: Values | None = None
        self._must_set_up = False

    def greet(self) -> None:
        """See that a Khepera is there, and that it stands.

        B comes first: what is left of another program's last words is answered before it.
        """
        self.ask("B")
        self._say_wheels(0, 0)

    def ask(self, command: str, *values: int) -> tuple[int | str, ...]:
        """Ask one thing; returns the values of the reply."""
        return self._link.ask(Request(command, values)).values

    def transmit(self, command: Motors) -> None:
        """Tell wheels, and arm and jaw if they are to go elsewhere."""
        self._told = command
        self._say_wheels(int(command.left), int(command.right))
        if command.arm != self._sent_arm:
            self.ask("T,1,E", command.arm)
            self._sent_arm = command.arm
            self._arm.sent_to(command.arm)
        if command.jaw != self._sent_jaw:
            self.ask("T,1,D", 0 if command.jaw == JAW_OPEN else 1)
            self._sent_jaw = command.jaw
            self._jaw.sent_to(command.jaw)

    def receive(self) -> Senses:
        """Read what a step needs. The order keeps equal letters apart: two in a row would cost a fence."""
        ask_arm, ask_jaw = self._arm.due(), self._jaw.due()
        a, b, c, d, e, f, g, h = self._proximity = self._steady(
            PROXIMITY, self._proximity, lambda: self._numbers("N")
        )
        if ask_arm:
            self._look_at(self._arm, ARM, 1)
        (presence,) = self._presence = self._steady(
            PRESENCE, self._presence, lambda: (present(self._numbers("T,1,G")[0]),)
        )
        if ask_jaw:
            self._look_at(self._jaw, JAW, 0)
        self._count()
        assert self._arm.value is not None, "asked until there is one"
        assert self._jaw.value is not None, "asked until there is one"
        arm, jaw = arm_of(self._arm.value), jaw_of(self._jaw.value)
        return Senses((a, b, c, d, e, f, g, h), *self._counters.total, arm, jaw, presence)

    def stop(self, for_good: bool) -> None:
        """Wheels to zero.

        Args:
            for_good: Whether a restart, too, is followed by standing still; otherwise by what was told last.

        Raises:
            RobotLost: It is not confirmed.
        """
        if for_good and self._told is not None:
            self._told = self._told._replace(left=0, right=0)
        for _ in range(_RESTARTS):
            try:
                self._link.insist(Request("D", (0, 0)))
                self._wheels = (0, 0)
                return
            except Restarted:
                self.restarted()
        raise RobotLost(self._link.port, "D,0,0", _RESTARTS, "it starts anew again and again")

    def restarted(self) -> None:
        """The robot's banner came."""
        self._counters.restarted()
        self._must_set_up = True

    def set_up(self) -> None:
        """If the robot has started anew, tell it what it was told before."""
        if not self._must_set_up:
            return
        self._sent_arm = self._sent_jaw = None
        self._arm.sent_to(None)
        self._jaw.sent_to(None)
        if self._told is not None:
            self.transmit(self._told)
        self._must_set_up = False

    def _say_wheels(self, left: int, right: int) -> None:
        self.ask("D", left, right)
        self._wheels_before, self._wheels = self._wheels, (left, right)

    def _numbers(self, command: str, *values: int) -> Values:
        return tuple(value for value in self.ask(command, *values) if isinstance(value, int))

    def _steady(self, kind: Kind, last: Values | None, ask: Callable[[], Values]) -> Values:
        def surprising(values: Values) -> bool:
            return last is None or any(abs(a - b) > kind.step for a, b in zip(values, last, strict=True))

        return confirmed(ask, surprising, kind.alike)

    def _look_at(self, position: Position, kind: Kind, selector: int) -> None:
        # As the robot says it, and not yet brought into range: a lost digit would be hidden by that.
        (value,) = confirmed(lambda: self._numbers("T,1,H", selector), position.surprising, kind.alike)
        position.read(value)

    def _count(self) -> None:
        raw = confirmed(
            lambda: self._numbers("H"),
            lambda values: self._counters.surprising(values, self._wheels, self._wheels_before),
            COUNTERS.alike,
        )
        if self._counters.read(raw):
            self._must_set_up = True
