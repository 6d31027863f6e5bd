"""The firmware of a Khepera in front of any `Robot`: executes requests and encodes the replies.

A simulated robot takes whole speed units up to 20 and moves its arm between 215 and 255, although the protocol allows
more. Like the real firmware, this one confirms any value that the protocol allows.
"""

import math
import threading
from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass

from khepera_forage.robots.khepera import (
    CONTROL_PERIOD,
    JAW_CLOSED,
    JAW_ON_FOOD,
    JAW_OPEN,
    PULSE,
    PULSES_PER_UNIT,
    SPEED_UNIT,
    Motors,
    Robot,
)
from khepera_forage.robots.serial.khepera_protocol import KHEPERA, PWM, SPEED
from khepera_forage.robots.serial.protocol import (
    NOT_FOUND_TEXT,
    PROTOCOL_ERROR_TEXT,
    RESTART,
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
        self,
        robot: Robot,
        lock: AbstractContextManager[object] | None = None,
        period: float = CONTROL_PERIOD,
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
            values = self._handler(request.command)(*request.values)
        return self.protocol.encode_reply(Reply(request.command, values))

    def tick(self) -> None:
        """End a control period, after each `World.advance`: measure the speeds, control wheels with a target."""
        with self._lock:
            senses = self._robot.sense()
            pulses = senses.left_pulses, senses.right_pulses
            left, right = self._last_pulses
            self._measured_speeds = self._speed(pulses[0] - left), self._speed(pulses[1] - right)
            self._last_pulses = pulses
            if self._position_control:
                left_count, right_count = self._counters()
                left_wheel, right_wheel = self._wheels
                self._drive(left=left_wheel.next_speed(left_count), right=right_wheel.next_speed(right_count))

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
        self._position_control = False
        self._wheels = (
            WheelPositionController(self._pulses_per_unit),
            WheelPositionController(self._pulses_per_unit),
        )
        self._last_pulses = self._pulses()
        self._offsets = -self._last_pulses[0], -self._last_pulses[1]
        self._measured_speeds = 0, 0
        self._bus = bytearray(64)  # no device is attached: a read returns the byte last written

    def _handler(self, command: str) -> Callable[..., Values]:
        sense = self._robot.sense
        handlers: dict[str, Callable[..., Values]] = {
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
        return handlers.get(command, lambda *_: ())

    def _write_bus(self, data: int, address: int) -> Values:
        self._bus[address] = data
        return ()

    def _drive(self, **changes: int) -> tuple[()]:
        """Change a part of the motor command and keep the rest."""
        self._command = self._robot.drive(self._command._replace(**changes))
        return ()

    def _pulses(self) -> tuple[int, int]:
        senses = self._robot.sense()
        return senses.left_pulses, senses.right_pulses

    def _counters(self) -> tuple[int, int]:
        left, right = self._pulses()
        return wrap_counter(left + self._offsets[0]), wrap_counter(right + self._offsets[1])

    def _set_targets(self, *targets: int) -> Values:
        self._position_control = True
        for wheel, target, speed in zip(self._wheels, targets, self._command[:2], strict=True):
            wheel.target, wheel.speed = target, speed
        return ()

    def _set_speeds(self, left: int, right: int) -> Values:
        self._position_control = False
        return self._drive(left=left, right=right)

    def _set_pwm(self, left: int, right: int) -> Values:
        # Assumption: proportional, 255 is 127 units, the maximum of the protocol.
        return self._set_speeds(round(left * SPEED.high / PWM.high), round(right * SPEED.high / PWM.high))

    def _set_counters(self, *counts: int) -> Values:
        left, right = self._pulses()
        self._offsets = counts[0] - left, counts[1] - right
        return ()

    def _set_profiles(self, *profiles: int) -> Values:
        for wheel, i in zip(self._wheels, (0, 2), strict=True):
            wheel.max_speed, wheel.acceleration = profiles[i : i + 2]
        return ()

    def _position_status(self) -> Values:
        if not self._position_control:
            left, right = self._measured_speeds
            errors = self._command.left - left, self._command.right - right
            return tuple(value for error in errors for value in (0, _SPEED_MODE, int(error)))
        return tuple(
            value
            for wheel, count in zip(self._wheels, self._counters(), strict=True)
            for value in (int(wheel.reached(count)), _POSITION_MODE, wrap_counter(wheel.target - count))
        )

    def _speed(self, pulses: int) -> int:
        """The speed, in speed units, of a wheel that turned by `pulses` in one control period."""
        return max(SPEED.low, min(SPEED.high, round(pulses / self._pulses_per_unit)))


@dataclass
class WheelPositionController:
    """Drives one wheel to a target count, at most at `max_speed` speed units.

    Args:
        pulses_per_unit: Pulses of a wheel in one control period at one speed unit.
        acceleration: In 1/256 speed unit in 10 ms; both defaults are KNET's and KH2PY's, 160 mm/s and 200 mm/s2.
    """

    pulses_per_unit: float = PULSES_PER_UNIT
    max_speed: int = 20
    acceleration: int = 64
    target: int = 0
    speed: float = 0.0

    def reached(self, count: int) -> bool:
        """Whether a wheel at this count has reached the target, as exactly as whole speed units allow."""
        return abs(self.target - count) <= 0.5 * self.pulses_per_unit

    def next_speed(self, count: int) -> int:
        """The speed for the next control period, in whole units, of a wheel at this count."""
        if self.reached(count):
            self.speed = 0.0
            return 0
        distance = abs(self.target - count) / self.pulses_per_unit
        step = self.acceleration / 256 * self.pulses_per_unit
        # From this speed the wheel stops within the distance; the last step may be slower still.
        braking_speed = math.sqrt(step * step / 4 + 2 * step * distance) - step / 2
        wanted = math.copysign(min(self.max_speed, braking_speed, distance), self.target - count)
        if distance > step or abs(self.speed) > 2 * step:
            wanted = max(self.speed - step, min(self.speed + step, wanted))
        self.speed = wanted
        # A speed below half a unit would leave the wheel short of its target.
        return round(wanted) or (wanted > 0) - (wanted < 0)
