"""Every command of a Khepera with a gripper, in one table: what goes with it, what comes back, in which ranges.

From the K-Team protocol as its drivers and manuals have it. "Assumption" marks a range that no source gives.
"""

from typing import NamedTuple


class Range(NamedTuple):
    """Whole numbers from `low` to `high`, both allowed."""

    low: int
    high: int


class Version(NamedTuple):
    """A version number in dotted decimals, such as 5.02."""


class Command(NamedTuple):
    """One command.

    Attributes:
        arguments: What goes with the request.
        results: What comes back.
        meaning: In a few words.
    """

    arguments: tuple[Range, ...]
    results: tuple[Range | Version, ...]
    meaning: str


SPEED = Range(-127, 127)
"""Speed units, pulses in 10 ms: 8 mm/s (K-Team)."""
TARGET = Range(-(2**23 - 2), 2**23 - 2)
"""Pulses: what position control can reach, 671 m either way (RN)."""
COUNTER = Range(-(2**31), 2**31 - 1)
"""Pulses: 32 bits (RN)."""
GAIN = Range(0, 2**15 - 1)
"""A coefficient of a PID controller. Assumption: a positive 16-bit number; defaults are up to 4000 (KH2PY)."""
ACCELERATION = Range(0, 255)
"""1/256 speed unit in 10 ms: 3.125 mm/s2. Assumption: one byte; the default is 64 (KNET)."""
PWM = Range(-255, 255)
TEN_BITS = Range(0, 1023)
BYTE = Range(0, 255)
ADDRESS = Range(0, 63)
CHANNEL = Range(0, 5)
SWITCH = Range(0, 1)

RESTART = "restart"
"""The one command that is a word; the banner is its answer (WEP)."""
COMMANDS: dict[str, Command] = {
    "A": Command((GAIN,) * 3, (), "set the speed controller's Kp, Ki, Kd"),
    "B": Command((), (Version(), Version()), "versions of the BIOS and of the protocol"),
    "C": Command((TARGET,) * 2, (), "go to these counts, left and right (position control)"),
    "D": Command((SPEED,) * 2, (), "set the speeds, left and right (speed control)"),
    "E": Command((), (SPEED,) * 2, "measured speeds"),
    "F": Command((GAIN,) * 3, (), "set the position controller's Kp, Ki, Kd"),
    "G": Command((COUNTER,) * 2, (), "set the counters"),
    "H": Command((), (COUNTER,) * 2, "read the counters"),
    "I": Command((CHANNEL,), (TEN_BITS,), "read an analogue input, 4 mV a bit"),
    "J": Command((Range(0, 127), ACCELERATION) * 2, (), "position control's largest speed and acceleration"),
    # M is the mode and E the error of position control; what they are coded as is not established, hence wide ranges.
    "K": Command(
        (), (SWITCH, BYTE, COUNTER) * 2, "position control: target reached, mode, error; left, right"
    ),
    "L": Command((SWITCH, Range(0, 2)), (), "a light-emitting diode: off, on, toggle"),
    "N": Command((), (TEN_BITS,) * 8, "proximity, clockwise from the left"),
    "O": Command((), (TEN_BITS,) * 8, "ambient light, in the same order; low is bright"),
    "P": Command((PWM,) * 2, (), "pulse-width modulation of the motors"),
    "R": Command((ADDRESS,), (BYTE,), "read the extension bus"),
    # Data first: three sources of four (KMAT, RN and KH2PY against NIC-IF).
    "W": Command((BYTE, ADDRESS), (), "write to the extension bus: data, address"),
    "T,1,B": Command((), (BYTE, BYTE), "gripper: version and revision of its software"),
    "T,1,D": Command((SWITCH,), (), "gripper: open the jaw (0) or close it (1)"),
    "T,1,E": Command((BYTE,), (), "gripper: where the arm shall go"),
    "T,1,F": Command((), (BYTE,), "gripper: resistivity of what is held"),
    "T,1,G": Command((), (BYTE,), "gripper: optical barrier; about 0 nothing, above 100 an object"),
    # The reply does not repeat the selector (NIC-IF, KNET): jaw and arm can only be told apart by what was asked.
    "T,1,H": Command((SWITCH,), (BYTE,), "gripper: position of the jaw (0) or of the arm (1)"),
    "T,1,J": Command((), (BYTE,), "gripper: jumpers"),
    RESTART: Command((), (), "start anew, as after power-on"),
}
"""By the name that a `Request` gives: a letter, a gripper message, or the word restart."""
