"""The firmware of a Khepera in front of any `Robot`: executes requests and encodes the replies.

A simulated robot takes whole speed units up to 20 and moves its arm between 215 and 255, although the protocol allows
more. Like the real firmware, this one confirms any value that the protocol allows.
"""

import threading
from collections.abc import Callable
from contextlib import AbstractContextManager

from khepera_forage.robots.khepera import (
    CONTROL_PERIOD,
    JAW_CLOSED,
    JAW_ON_FOOD,
    JAW_OPEN,
    PULSE,
    SPEED_UNIT,
    Motors,
    Robot,
)
from khepera_forage.robots.serial.protocol import (
    KHEPERA,
    NOT_FOUND_TEXT,
    PROTOCOL_ERROR_TEXT,
    RESTART,
    SPEED,
    ArgumentError,
    ErrorReply,
    Protocol,
    ProtocolError,
    Reply,
    wrap_counter,
)

_VERSIONS = ("5.02", "5.01")
"""Of the BIOS and of the protocol (K-Team)."""
_GRIPPER_VERSION = (2, 1)
"""Assumption: the version of the gripper's manual."""

_BARRIER_FREE, _BARRIER_CROSSED = 0, 200
"""Readings of the optical barrier: 0 without an object (KNET, KH2PY, WSU-R), more than 100 with one (PYRO)."""
_INSULATED, _CONDUCTING = 0, 255
"""Replies to T,1,F. The only source is PYRO, which takes more than 20 for closed fingers and less for open ones: the
reading is high while a current flows from finger to finger. The food is of wood, so only closed, empty fingers conduct.
Assumption: the ends of the scale, and that PYRO's threshold is right; the text of K-Team's manual was not found."""
_DARK = 500
"""Ambient light reading without a lamp (Khepera manual 3.1.7, by way of RN)."""
_FINGERS_TOUCH = 3
"""Jaw position up to which the fingers touch each other: 0 but for the noise of the position. Assumption."""

Values = tuple[int | str, ...]
Handler = Callable[..., Values | None]
"""Executes a request with its values; returns the values of the reply, None for none."""


class Firmware:
    """The robot's end of the serial protocol.

    There is no watchdog: a speed holds until another is set. Gripper requests are confirmed at once; the motion takes
    place afterwards. All methods are thread-safe: each holds the lock while it accesses the robot.

    Args:
        robot: The robot to drive and sense.
        lock: Held by others while they advance the robot's world; reentrant (`threading.RLock`) if `tick` is called
            with the lock held. A new one by default.
        period: Seconds of a control period, from one `tick` to the next.

    Attributes:
        name: Of the robot, for messages.
        protocol: Of the robot.
        argument_error: The text of its reply to a request with wrong values.
    """

    name = "Khepera"
    protocol: Protocol = KHEPERA
    argument_error = PROTOCOL_ERROR_TEXT

    def __init__(
        self, robot: Robot, lock: AbstractContextManager[object] | None = None, period: float = CONTROL_PERIOD
    ) -> None:
        self._robot = robot
        self._lock = threading.RLock() if lock is None else lock
        self._pulses_per_unit = SPEED_UNIT / PULSE * period
        self._last_pulses = 0, 0
        with self._lock:
            senses = robot.sense()
            # A jaw at rest half-way holds an object: keep it closed.
            is_open = senses.jaw > (JAW_ON_FOOD + JAW_OPEN) / 2
            self._command = Motors(0, 0, senses.arm, JAW_OPEN if is_open else JAW_CLOSED)
            self._initialise()

    @property
    def turning(self) -> bool:
        """Whether a wheel is commanded to turn."""
        return any(self._command[:2])

    def handle(self, line: bytes) -> bytes:
        """Execute one request, any bytes with or without an ending; returns the whole reply with its ending."""
        try:
            request = self.protocol.decode_request(line)
        except ArgumentError:
            return self.protocol.encode_reply(ErrorReply(self.argument_error))
        except ProtocolError:
            return self.protocol.encode_reply(ErrorReply(NOT_FOUND_TEXT))
        if request.command == RESTART:
            return self.power_on()
        with self._lock:
            values = self._handler(request.command)(*request.values) or ()
        return self.protocol.encode_reply(Reply(request.command, values))

    def tick(self) -> None:
        """End a control period, after each `World.advance`: measure the speeds."""
        with self._lock:
            pulses = self._pulses()
            left, right = (
                max(SPEED.low, min(SPEED.high, round((now - then) / self._pulses_per_unit)))
                for now, then in zip(pulses, self._last_pulses, strict=True)
            )
            self._measured_speeds, self._last_pulses = (left, right), pulses

    def power_on(self) -> bytes:
        """Start after a power failure: wheels stopped, settings reset, counters at 0; returns the banner.

        The gripper completes its last motion; the behaviour of a real one is not documented.
        """
        with self._lock:
            self._robot.stop()
            self._initialise()
        return b"".join(f"{line}\r\n".encode() for line in self.protocol.banner)

    def attach(self, robot: Robot) -> None:
        """Connect a new body of a world that was reset; counters continue, and it receives the last command."""
        with self._lock:
            left, right = self._counters()
            self._robot = robot
            self._last_pulses = self._pulses()
            self._offsets = left - self._last_pulses[0], right - self._last_pulses[1]
            self._drive()

    def _initialise(self) -> None:
        """Set the state at power-on."""
        self._command = self._command._replace(left=0, right=0)
        self._last_pulses = self._pulses()
        self._offsets = -self._last_pulses[0], -self._last_pulses[1]
        self._measured_speeds = 0, 0

    def _handler(self, command: str) -> Handler:
        sense = self._robot.sense
        handlers: dict[str, Handler] = {
            "B": lambda: _VERSIONS,
            "D": lambda left, right: self._drive(left=left, right=right),
            "E": lambda: self._measured_speeds,
            "G": self._set_counters,
            "H": self._counters,
            "I": lambda channel: (0,),
            "K": lambda: (0,) * 6,
            "N": lambda: sense().proximity,
            "O": lambda: (_DARK,) * 8,
            "T,1,B": lambda: _GRIPPER_VERSION,
            "T,1,D": lambda closed: self._drive(jaw=JAW_CLOSED if closed else JAW_OPEN),
            "T,1,E": lambda position: self._drive(arm=position),
            "T,1,F": lambda: (_CONDUCTING if sense().jaw <= _FINGERS_TOUCH else _INSULATED,),
            "T,1,G": lambda: (_BARRIER_CROSSED if sense().object_presence else _BARRIER_FREE,),
            "T,1,H": lambda arm: (sense().arm if arm else sense().jaw,),
            "T,1,J": lambda: (0,),
        }
        return handlers.get(command, lambda *_: None)  # LEDs have no effect

    def _drive(self, **changes: int) -> None:
        """Change a part of the motor command and keep the rest."""
        self._command = self._robot.drive(self._command._replace(**changes))

    def _pulses(self) -> tuple[int, int]:
        senses = self._robot.sense()
        return senses.left_pulses, senses.right_pulses

    def _counters(self) -> tuple[int, int]:
        left, right = self._pulses()
        return wrap_counter(left + self._offsets[0]), wrap_counter(right + self._offsets[1])

    def _set_counters(self, *counts: int) -> None:
        left, right = self._pulses()
        self._offsets = counts[0] - left, counts[1] - right
