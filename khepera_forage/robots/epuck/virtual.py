"""The firmware of a virtual e-puck2 in front of any simulated `Robot`.

The robot's speeds and counters are those of a Khepera; the firmware converts them into steps of the e-puck's wheels. A
simulated gripper stays raised, where it touches nothing.
"""

import threading
from contextlib import AbstractContextManager

from khepera_forage.robots.epuck.protocol import E_PUCK as PROTOCOL
from khepera_forage.robots.khepera import ARM_RAISED, JAW_OPEN, PULSE, Motors, Robot
from khepera_forage.robots.model import E_PUCK
from khepera_forage.robots.serial.protocol import (
    NOT_FOUND_TEXT,
    ErrorReply,
    ProtocolError,
    Reply,
    wrap_counter,
)

VERSIONS = "Version 2.0 January 2018 GCtronic", "HW version: E"
_DARK = 3900
"""Ambient light reading without a lamp. Assumption."""
_PULSE = E_PUCK.pulse / E_PUCK.scale / PULSE
"""A Khepera's pulses for one step."""


class EPuckFirmware:
    """The robot's end of the serial line. See `virtual.firmware.Firmware`, whose methods these are.

    Args:
        robot: The robot to drive and sense.
        lock: Held by others while they advance the robot's world; a new one by default.
    """

    protocol = PROTOCOL

    def __init__(self, robot: Robot, lock: AbstractContextManager[object] | None = None) -> None:
        self._robot = robot
        self._lock = threading.RLock() if lock is None else lock
        self._speeds = 0, 0
        self._offsets = 0.0, 0.0
        self.power_on()

    @property
    def turning(self) -> bool:
        """Whether a wheel is commanded to turn."""
        return any(self._speeds)

    def handle(self, line: bytes) -> bytes:
        """Execute one request; returns the reply with its ending."""
        try:
            request = PROTOCOL.decode_request(line)
        except ProtocolError:
            return PROTOCOL.encode_reply(ErrorReply(NOT_FOUND_TEXT))
        with self._lock:
            values = self._execute(request.command, request.values)
        reply = PROTOCOL.encode_reply(Reply(request.command, values))
        return reply + f"{VERSIONS[1]}\r\n".encode() if request.command == "V" else reply

    def tick(self) -> None:
        """End a control period: nothing to do."""

    def power_on(self) -> bytes:
        """Start the firmware after a power failure: wheels stopped, counters at 0; returns the banner."""
        with self._lock:
            self._drive(0, 0)
            self._set_counters(0, 0)
        return b"\x0c\x07" + b"".join(f"{line}\r\n".encode() for line in PROTOCOL.banner)

    def attach(self, robot: Robot) -> None:
        """Connect another simulated body; counters and speeds continue."""
        with self._lock:
            counters = self._counters()
            self._robot = robot
            self._set_counters(*counters)
            self._drive(*self._speeds)

    def _execute(self, command: str, values: tuple[int, ...]) -> tuple[int | str, ...]:
        if command == "D":
            self._drive(*values)
        elif command == "S":
            self._drive(0, 0)
        elif command == "P":
            self._set_counters(*values)
        elif command == "E":
            return self._speeds
        elif command == "Q":
            return self._counters()
        elif command == "N":
            left90, left45, left10, right10, right45, right90, back_right, back_left = (
                4 * reading for reading in self._robot.sense().proximity
            )
            return right10, right45, right90, back_right, back_left, left90, left45, left10
        elif command == "O":
            return (_DARK,) * 8
        elif command == "V":
            return (VERSIONS[0],)
        return ()

    def _drive(self, left: int, right: int) -> None:
        self._speeds = left, right
        self._robot.drive(Motors(left / E_PUCK.unit, right / E_PUCK.unit, ARM_RAISED, JAW_OPEN))

    def _steps(self) -> tuple[float, float]:
        senses = self._robot.sense()
        return senses.left_pulses / _PULSE, senses.right_pulses / _PULSE

    def _set_counters(self, left: int, right: int) -> None:
        steps = self._steps()
        self._offsets = left - steps[0], right - steps[1]

    def _counters(self) -> tuple[int, int]:
        steps = self._steps()
        left, right = (round(s + o) for s, o in zip(steps, self._offsets, strict=True))
        return wrap_counter(left, 16), wrap_counter(right, 16)
