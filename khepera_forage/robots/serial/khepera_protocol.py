"""The K-Team protocol: every command of a Khepera with a gripper.

As K-Team's manuals and drivers describe it. "Assumption" marks a range without a source.
"""

from khepera_forage.robots.serial.protocol import RESTART, VERSION, Command, Protocol, Range, Request

SPEED = Range(-127, 127)
"""Speed units, pulses in 10 ms: 8 mm/s (K-Team)."""
TARGET = Range(-(2**23 - 2), 2**23 - 2)
"""Pulses: range of position control, 671 m either way (RN)."""
COUNTER = Range(-(2**31), 2**31 - 1)
"""Pulses: 32 bits (RN)."""
GAIN = Range(0, 2**15 - 1)
"""A coefficient of a PID controller. Assumption: a positive 16-bit number. Kp, Ki, Kd at power-on: 3800, 800, 100 of
the speed controller, 3000, 20, 4000 of the position controller (KH2PY)."""
ACCELERATION = Range(0, 255)
"""1/256 speed unit in 10 ms: 3.125 mm/s2. Assumption: one byte; the default is 64 (KNET)."""
PWM = Range(-255, 255)
TEN_BITS = Range(0, 1023)
BYTE = Range(0, 255)
ADDRESS = Range(0, 63)
CHANNEL = Range(0, 5)
SWITCH = Range(0, 1)

BAUD_RATES = (9600, 19200, 38400, 57600, 115200)
"""Settings of a Khepera's mode switch."""

COMMANDS: dict[str, Command] = {
    "A": Command((GAIN,) * 3, (), "set the speed controller's Kp, Ki, Kd"),
    "B": Command((), (VERSION, VERSION), "versions of the BIOS and of the protocol"),
    "C": Command((TARGET,) * 2, (), "set the target counts, left and right (position control)"),
    "D": Command((SPEED,) * 2, (), "set the speeds, left and right (speed control)"),
    "E": Command((), (SPEED,) * 2, "measured speeds"),
    "F": Command((GAIN,) * 3, (), "set the position controller's Kp, Ki, Kd"),
    "G": Command((COUNTER,) * 2, (), "set the encoder counters"),
    "H": Command((), (COUNTER,) * 2, "read the encoder counters"),
    "I": Command((CHANNEL,), (TEN_BITS,), "read an analogue input, 4 mV a bit"),
    "J": Command((Range(0, 127), ACCELERATION) * 2, (), "maximum speed and acceleration of position control"),
    # No source defines the codes of mode and error, hence wide ranges.
    "K": Command(
        (), (SWITCH, BYTE, COUNTER) * 2, "position control: target reached, mode, error; left, right"
    ),
    "L": Command((SWITCH, Range(0, 2)), (), "switch an LED: off, on, toggle"),
    "N": Command((), (TEN_BITS,) * 8, "proximity, clockwise from the left"),
    "O": Command((), (TEN_BITS,) * 8, "ambient light, in the same order; low is bright"),
    "P": Command((PWM,) * 2, (), "pulse-width modulation of the motors"),
    "R": Command((ADDRESS,), (BYTE,), "read the extension bus"),
    # Data first: three sources of four (KMAT, RN and KH2PY against NIC-IF).
    "W": Command((BYTE, ADDRESS), (), "write to the extension bus: data, address"),
    "T,1,B": Command((), (BYTE, BYTE), "gripper: version and revision of its software"),
    "T,1,D": Command((SWITCH,), (), "gripper: open the jaw (0) or close it (1)"),
    "T,1,E": Command((BYTE,), (), "gripper: set the target position of the arm"),
    "T,1,F": Command((), (BYTE,), "gripper: resistivity sensor; above 20 if the fingers conduct (PYRO)"),
    "T,1,G": Command((), (BYTE,), "gripper: optical barrier; about 0 without an object, above 100 with one"),
    # The reply does not repeat the argument (NIC-IF, KNET): only the request distinguishes jaw and arm.
    "T,1,H": Command((SWITCH,), (BYTE,), "gripper: position of the jaw (0) or of the arm (1)"),
    "T,1,J": Command((), (BYTE,), "gripper: jumpers"),
    RESTART: Command((), (), "restart, as after power-on"),
}
"""By the command name of a `Request`: a letter, a gripper message, or the word restart."""

BANNER = (
    "ROM of minirobot KHEPERA, Edoardo Franzi",
    "K-Team S.A.",
    "October 22, 1998",
    "Rev. 5.01",
    "Serial Communication Protocol",
)
"""The text is K-Team's; the line breaks are an assumption."""

KHEPERA = Protocol(
    COMMANDS,
    BANNER,
    identity=Request("B"),
    queries=tuple(
        Request(*request) for request in (("E",), ("B",), ("K",), ("I", (0,)), ("H",), ("O",), ("N",))
    ),
    baud_rates=BAUD_RATES,
    stop_bits=2,
)
