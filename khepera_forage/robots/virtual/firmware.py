"""The ROM of a Khepera, in front of any `Robot`: what it answers to each command, and what it does.

What the robot cannot do, the ROM cannot make it do: a simulated Khepera takes whole speed units up to 20 either way and
moves its arm between 215 and 255, whatever numbers the protocol allows; it answers as if all of them were fine, as the
real one does.
"""

import threading
from collections.abc import Callable
from contextlib import AbstractContextManager

from khepera_forage.robots.khepera import JAW_CLOSED, JAW_ON_FOOD, JAW_OPEN, Motors, Robot
from khepera_forage.robots.serial.command_table import PWM, RESTART, SPEED
from khepera_forage.robots.serial.protocol import (
    BANNER,
    NOT_FOUND,
    PROTOCOL_ERROR,
    ArgumentError,
    CodecError,
    Refusal,
    Reply,
    decode_request,
    encode_reply,
)
from khepera_forage.robots.virtual.position_control import PULSES_A_PERIOD, WheelPosition
from khepera_forage.robots.virtual.registers import Registers

VERSIONS = ("5.02", "5.01")
"""Of the BIOS and of the protocol (K-Team)."""
GRIPPER_VERSION = (2, 1)
"""Assumption: that of the gripper's manual."""
BARRIER_FREE, BARRIER_CROSSED = 0, 200
"""Readings of the optical barrier: nothing is 0 (KNET, KH2PY, WSU-R), an object more than 100 (PYRO)."""
INSULATOR = 255
"""Resistivity of anything that does not conduct. Assumption: the end of the scale."""
DARK = 500
"""Ambient light of a sensor that no lamp shines on (Khepera manual 3.1.7, by way of RN)."""
FULL_PWM, FULL_SPEED = PWM.high, SPEED.high
"""Command P is a speed here: proportional, 255 being the 127 units of the fastest motor. Assumption."""

_SPEED_MODE, _POSITION_MODE = 0, 1
"""The mode in the reply to K, as KIKS has it."""

Values = tuple[int | str, ...]


class Firmware:
    """A Khepera with a gripper as it behaves at the other end of its serial line.

    There is no watchdog: a speed holds until another is set. Gripper messages are answered at once, and the motion goes
    on afterwards. All methods may be called from any thread; each holds the lock while it touches the robot.

    Args:
        robot: What is driven and sensed.
        lock: Held whenever something else advances the robot; one that may be acquired again by its holder
            (`threading.RLock`) if `tick` is called with it held. One of its own by default.

    Attributes:
        registers: What was set and does nothing here: the simulated motors need no gains.
    """

    def __init__(self, robot: Robot, lock: AbstractContextManager[object] | None = None) -> None:
        self._robot = robot
        self._lock = threading.RLock() if lock is None else lock
        self._last_pulses = 0, 0
        with self._lock:
            senses = robot.sense()
            # A jaw that stands still half-way holds something: let go of nothing.
            still_open = senses.jaw > (JAW_ON_FOOD + JAW_OPEN) / 2
            self._command = Motors(0, 0, senses.arm, JAW_OPEN if still_open else JAW_CLOSED)
            self._begin()

    def answer(self, line: bytes) -> bytes:
        """Carry out one request.

        Args:
            line: With or without its ending; any bytes.

        Returns:
            The whole reply with its ending: several lines for `restart`.
        """
        try:
            request = decode_request(line)
        except ArgumentError:
            return encode_reply(Refusal(PROTOCOL_ERROR))
        except CodecError:
            return encode_reply(Refusal(NOT_FOUND))
        if request.command == RESTART:
            return self.power_on()
        with self._lock:
            values = self._handler(request.command)(*request.values)
        return encode_reply(Reply(request.command, values))

    def tick(self) -> None:
        """A control period has passed: measure the speeds, and steer the wheels that go to a position.

        To be called once after each `World.advance`.
        """
        with self._lock:
            senses = self._robot.sense()
            pulses = senses.left_pulses, senses.right_pulses
            left, right = self._last_pulses
            self._measured = _speed(pulses[0] - left), _speed(pulses[1] - right)
            self._last_pulses = pulses
            if self._positioning:
                left_count, right_count = self._counters()
                left_wheel, right_wheel = self._wheels
                self._drive(left=left_wheel.speed(left_count), right=right_wheel.speed(right_count))

    def power_on(self) -> bytes:
        """What happens when the supply returns: wheels stopped, everything that was set forgotten, counters at 0.

        The gripper stays as it is and finishes what it was told; what a real one does then is not established.

        Returns:
            The banner, with line endings.
        """
        with self._lock:
            self._robot.stop()
            self._begin()
        return b"".join(f"{line}\r\n".encode() for line in BANNER)

    def attach(self, robot: Robot) -> None:
        """Stand in front of another body: a simulated world builds new ones at a reset, the real one is the same.

        Counters go on from where they are, and the new body is told what the old one was.
        """
        with self._lock:
            left, right = self._counters()
            self._robot = robot
            self._last_pulses = self._pulses()
            self._offsets = left - self._last_pulses[0], right - self._last_pulses[1]
            self._drive()

    def _begin(self) -> None:
        """The state at power-on."""
        self._command = self._command._replace(left=0, right=0)
        self._positioning = False
        self._wheels = WheelPosition(), WheelPosition()
        self._last_pulses = self._pulses()
        self._offsets = -self._last_pulses[0], -self._last_pulses[1]
        self._measured = 0, 0
        self.registers = Registers()

    def _handler(self, command: str) -> Callable[..., Values]:
        registers = self.registers
        handlers: dict[str, Callable[..., Values]] = {
            "A": registers.set_speed_gains,
            "B": lambda: VERSIONS,
            "C": self._go_to,
            "D": self._set_speeds,
            "E": lambda: self._measured,
            "F": registers.set_position_gains,
            "G": self._set_counters,
            "H": self._counters,
            "I": registers.read_analogue,
            "J": self._set_profile,
            "K": self._control_state,
            "L": registers.switch_led,
            "N": lambda: self._robot.sense().proximity,
            "O": lambda: (DARK,) * 8,
            "P": self._set_pwm,
            "R": registers.read_bus,
            "W": registers.write_bus,
            "T,1,B": lambda: GRIPPER_VERSION,
            "T,1,D": lambda closed: self._drive(jaw=JAW_CLOSED if closed else JAW_OPEN),
            "T,1,E": lambda position: self._drive(arm=position),
            "T,1,F": lambda: (INSULATOR,),
            "T,1,G": lambda: (BARRIER_CROSSED if self._robot.sense().object_presence else BARRIER_FREE,),
            "T,1,H": lambda arm: (self._robot.sense().arm if arm else self._robot.sense().jaw,),
            "T,1,J": lambda: (0,),
        }
        return handlers[command]

    def _drive(self, **changes: int) -> tuple[()]:
        """Command a part of the motors and leave the others as they are."""
        self._command = self._robot.drive(self._command._replace(**changes))
        return ()

    def _pulses(self) -> tuple[int, int]:
        senses = self._robot.sense()
        return senses.left_pulses, senses.right_pulses

    def _counters(self) -> tuple[int, int]:
        left, right = self._pulses()
        return _wrapped(left + self._offsets[0]), _wrapped(right + self._offsets[1])

    def _go_to(self, *targets: int) -> Values:
        self._positioning = True
        for wheel, target, count, speed in zip(
            self._wheels, targets, self._counters(), self._command[:2], strict=True
        ):
            wheel.aim(target, count, speed)
        return ()

    def _set_speeds(self, left: int, right: int) -> Values:
        self._positioning = False
        return self._drive(left=left, right=right)

    def _set_pwm(self, left: int, right: int) -> Values:
        return self._set_speeds(round(left * FULL_SPEED / FULL_PWM), round(right * FULL_SPEED / FULL_PWM))

    def _set_counters(self, *counts: int) -> Values:
        for wheel, count, before in zip(self._wheels, counts, self._counters(), strict=True):
            wheel.shift(count - before)
        left, right = self._pulses()
        self._offsets = counts[0] - left, counts[1] - right
        return ()

    def _set_profile(self, left_speed: int, left_growth: int, right_speed: int, right_growth: int) -> Values:
        self._wheels[0].set_profile(left_speed, left_growth)
        self._wheels[1].set_profile(right_speed, right_growth)
        return ()

    def _control_state(self) -> Values:
        if not self._positioning:
            errors = self._command.left - self._measured[0], self._command.right - self._measured[1]
            return tuple(value for error in errors for value in (0, _SPEED_MODE, int(error)))
        return tuple(
            value
            for wheel, count in zip(self._wheels, self._counters(), strict=True)
            for value in (int(wheel.reached(count)), _POSITION_MODE, _wrapped(wheel.target - count))
        )


def _wrapped(count: int) -> int:
    """A count as 32 bits with a sign hold it."""
    return (count + 2**31) % 2**32 - 2**31


def _speed(pulses: int) -> int:
    """The speed of a wheel that turned so far in a control period."""
    return max(SPEED.low, min(SPEED.high, round(pulses / PULSES_A_PERIOD)))
