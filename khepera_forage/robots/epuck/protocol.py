"""The e-puck's commands ("sercom"), as its firmware executes them.

The letters D, E, N and O mean what they mean on a Khepera; the counters are Q, and there is no turret.
"""

from khepera_forage.robots.serial.protocol import Command, Protocol, Range, Request, Text

SPEED = Range(-1100, 1100)
"""Steps per second."""
INFRA_RED = Range(-4095, 4095)
"""Reflected minus ambient light: about 0 without an obstacle."""
COUNTER = Range(-(2**15), 2**16 - 1)
"""16 bits, which wrap."""

E_PUCK = Protocol(
    commands={
        "B": Command((Range(0, 2),), (), "body light: off, on, toggle"),
        "D": Command((SPEED,) * 2, (), "set the speeds, left and right"),
        "E": Command((), (SPEED,) * 2, "speeds as commanded"),
        "L": Command((Range(0, 8), Range(0, 2)), (), "switch a light, 8 for all: off, on, toggle"),
        "N": Command((), (INFRA_RED,) * 8, "proximity, clockwise from the front right"),
        "O": Command((), (Range(0, 4095),) * 8, "ambient light, in the same order"),
        "P": Command((COUNTER,) * 2, (), "set the step counters"),
        "Q": Command((), (COUNTER,) * 2, "read the step counters"),
        "S": Command((), (), "stop, and switch all lights off"),
        "V": Command(
            (),
            (Text(r"Version [ -+\--~]+", "a version"),),
            "version; a line with that of the hardware follows",
        ),
    },
    # As in the firmware of the e-puck1.
    banner=("WELCOME to the SerCom protocol on e-Puck", 'the EPFL education robot type "H" for help'),
    identity=Request("V"),
    queries=tuple(Request(letter) for letter in "EQONV"),
    baud_rates=(115200,),
    stop_bits=1,
    remark="HW version",
    end=b"\r",
    hint="is this the port of an e-puck2, switched on, with its selector in position 3 (Bluetooth) or 8 (USB)?",
)
