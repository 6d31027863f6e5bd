"""The firmware of a Khepera, or an e-puck2, in front of any `Robot`: executes requests and encodes the replies.

A simulated robot takes whole speed units up to 20 and moves its arm between 215 and 255, although the protocol allows
more. Like the real firmware, this one confirms any value that the protocol allows.
"""

import threading
from collections.abc import Callable
from contextlib import AbstractContextManager

from khepera_forage.robots.epuck.driver import PROTOCOL as E_PUCK_PROTOCOL
from khepera_forage.robots.khepera import (
    ARM_RAISED,
    CONTROL_PERIOD,
    JAW_CLOSED,
    JAW_ON_FOOD,
    JAW_OPEN,
    PULSE,
    SPEED_UNIT,
    Motors,
    Robot,
)
from khepera_forage.robots.model import E_PUCK
from khepera_forage.robots.model import KHEPERA as KHEPERA_MODEL
from khepera_forage.robots.serial.protocol import (
    KHEPERA,
    NOT_FOUND_TEXT,
    PROTOCOL_ERROR_TEXT,
    PWM,
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
_DEFAULT_SPEED = 20
"""Speed units: the highest in position control (KNET, KH2PY)."""
_SPEED_MODE, _POSITION_MODE = 0, 1
"""The mode in the reply to K, as KIKS has it."""

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
    """

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
        """End a control period, after each `World.advance`: measure the speeds, control wheels with a target."""
        with self._lock:
            pulses = self._pulses()
            limits = SPEED.high, SPEED.high
            self._measured_speeds = self._speeds_to(pulses, self._last_pulses, limits)
            self._last_pulses = pulses
            if self._targets is not None:
                left, right = self._speeds_to(self._targets, self._counters(), self._max_speeds)
                self._drive(left=left, right=right)

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
        self._targets: tuple[int, int] | None = None
        """Of position control; None in speed control."""
        self._max_speeds = _DEFAULT_SPEED, _DEFAULT_SPEED
        self._last_pulses = self._pulses()
        self._offsets = -self._last_pulses[0], -self._last_pulses[1]
        self._measured_speeds = 0, 0
        self._bus = bytearray(64)  # no device is attached: a read returns the byte last written

    def _handler(self, command: str) -> Handler:
        sense = self._robot.sense
        handlers: dict[str, Handler] = {
            "B": lambda: _VERSIONS,
            "C": self._set_targets,
            "D": self._set_speeds,
            "E": lambda: self._measured_speeds,
            "G": self._set_counters,
            "H": self._counters,
            "I": lambda channel: (0,),
            "J": self._set_profiles,
            "K": self._position_status,
            "N": lambda: sense().proximity,
            "O": lambda: (_DARK,) * 8,
            "P": self._set_pwm,
            "R": lambda address: (self._bus[address],),
            "W": self._write_bus,
            "T,1,B": lambda: _GRIPPER_VERSION,
            "T,1,D": lambda closed: self._drive(jaw=JAW_CLOSED if closed else JAW_OPEN),
            "T,1,E": lambda position: self._drive(arm=position),
            "T,1,F": lambda: (_CONDUCTING if sense().jaw <= _FINGERS_TOUCH else _INSULATED,),
            "T,1,G": lambda: (_BARRIER_CROSSED if sense().object_presence else _BARRIER_FREE,),
            "T,1,H": lambda arm: (sense().arm if arm else sense().jaw,),
            "T,1,J": lambda: (0,),
        }
        # The rest has no effect: gains, which the simulated motors do not need (A, F), and LEDs (L).
        return handlers.get(command, lambda *_: None)

    def _write_bus(self, data: int, address: int) -> None:
        self._bus[address] = data

    def _drive(self, **changes: int) -> None:
        """Change a part of the motor command and keep the rest."""
        self._command = self._robot.drive(self._command._replace(**changes))

    def _pulses(self) -> tuple[int, int]:
        senses = self._robot.sense()
        return senses.left_pulses, senses.right_pulses

    def _counters(self) -> tuple[int, int]:
        left, right = self._pulses()
        return wrap_counter(left + self._offsets[0]), wrap_counter(right + self._offsets[1])

    def _set_targets(self, *targets: int) -> None:
        self._targets = targets[0], targets[1]

    def _set_speeds(self, left: int, right: int) -> None:
        self._targets = None
        self._drive(left=left, right=right)

    def _set_pwm(self, left: int, right: int) -> None:
        # Assumption: proportional, 255 is 127 units, the maximum of the protocol.
        self._set_speeds(round(left * SPEED.high / PWM.high), round(right * SPEED.high / PWM.high))

    def _set_counters(self, *counts: int) -> None:
        left, right = self._pulses()
        self._offsets = counts[0] - left, counts[1] - right

    def _set_profiles(self, *profiles: int) -> None:
        self._max_speeds = profiles[0], profiles[2]  # the simulated motors reach any speed at once

    def _position_status(self) -> Values:
        if self._targets is None:
            left, right = self._measured_speeds
            left_error, right_error = int(self._command.left - left), int(self._command.right - right)
            return 0, _SPEED_MODE, left_error, 0, _SPEED_MODE, right_error
        errors = [wrap_counter(target - count) for target, count in zip(self._targets, self._counters(), strict=True)]
        left, right = self._speeds_to(self._targets, self._counters(), (1, 1))
        return int(left == 0), _POSITION_MODE, errors[0], int(right == 0), _POSITION_MODE, errors[1]

    def _speeds_to(self, targets: tuple[int, int], counts: tuple[int, int], limits: tuple[int, int]) -> tuple[int, int]:
        """The speeds at which wheels reach targets in one control period, as exactly as whole units allow."""
        left, right = (
            max(-limit, min(limit, round((target - count) / self._pulses_per_unit)))
            for target, count, limit in zip(targets, counts, limits, strict=True)
        )
        return left, right


_E_PUCK_VERSIONS = "Version 2.0 January 2018 GCtronic", "HW version: E"
_E_PUCK_DARK = 3900
"""Ambient light reading without a lamp. Assumption."""
_PULSES_PER_STEP = E_PUCK.pulse / E_PUCK.scale / PULSE
"""A Khepera's pulses for one step."""


class EPuckFirmware(Firmware):
    """The firmware of an e-puck2. See `Firmware`.

    The robot's speeds and counters are those of a Khepera; the firmware converts them into steps of the e-puck's
    wheels. A simulated gripper stays raised, where it touches nothing.
    """

    protocol = E_PUCK_PROTOCOL
    argument_error = NOT_FOUND_TEXT

    def handle(self, line: bytes) -> bytes:
        """Execute one request; returns the reply with its ending."""
        reply = super().handle(line)
        return reply + f"{_E_PUCK_VERSIONS[1]}\r\n".encode() if reply.startswith(b"v,") else reply

    def _initialise(self) -> None:
        super()._initialise()
        self._speeds = 0, 0
        self._drive(arm=ARM_RAISED, jaw=JAW_OPEN)

    def _handler(self, command: str) -> Handler:
        handlers: dict[str, Handler] = {
            "D": self._set_steps,
            "E": lambda: self._speeds,
            "N": self._infra_reds,
            "O": lambda: (_E_PUCK_DARK,) * 8,
            "P": lambda left, right: self._set_counters(*(round(n * _PULSES_PER_STEP) for n in (left, right))),
            "Q": lambda: tuple(wrap_counter(round(n / _PULSES_PER_STEP), 16) for n in self._counters()),
            "S": lambda: self._set_steps(0, 0),
            "V": lambda: (_E_PUCK_VERSIONS[0],),
        }
        return handlers.get(command, lambda *_: None)

    def _set_steps(self, left: int, right: int) -> None:
        self._speeds = left, right
        self._drive(left=round(left / E_PUCK.unit), right=round(right / E_PUCK.unit))

    def _infra_reds(self) -> Values:
        left90, left45, left10, right10, right45, right90, back_right, back_left = (
            4 * reading for reading in self._robot.sense().proximity
        )
        return right10, right45, right90, back_right, back_left, left90, left45, left10


FIRMWARES = {KHEPERA_MODEL.name: Firmware, E_PUCK.name: EPuckFirmware}
"""By the kind of robot."""
