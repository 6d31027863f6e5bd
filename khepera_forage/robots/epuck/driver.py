"""The driver of a real e-puck2, over Bluetooth or USB, and the e-puck's commands ("sercom").

The letters D, E, N and O mean what they mean on a Khepera; the counters are Q, and there is no turret.
"""

from khepera_forage.robots.khepera import ARM_DOWN, JAW_OPEN, PRESENT, PULSE, Motors, Senses
from khepera_forage.robots.model import E_PUCK, KHEPERA_ORDER
from khepera_forage.robots.proximity import MAX_READING
from khepera_forage.robots.serial.protocol import Command, Protocol, Range, Request, Text
from khepera_forage.robots.serial.serial_robot import SerialRobot

SPEED = Range(-1100, 1100)
"""Steps per second."""
INFRA_RED = Range(-4095, 4095)
"""Reflected minus ambient light: about 0 without an obstacle."""
COUNTER = Range(-(2**15), 2**16 - 1)
"""16 bits, which wrap."""

PROTOCOL = Protocol(
    commands={
        "D": Command((SPEED,) * 2, ()),  # set the speeds, left and right
        "E": Command((), (SPEED,) * 2),  # speeds as commanded
        "L": Command((Range(0, 8), Range(0, 2)), ()),  # switch a light, 8 for all: off, on, toggle
        "N": Command((), (INFRA_RED,) * 8),  # proximity, clockwise from the front right
        "O": Command((), (Range(0, 4095),) * 8),  # ambient light, in the same order
        "Q": Command((), (COUNTER,) * 2),  # read the step counters
        "V": Command((), (Text(r"Version [ -+\--~]+", "a version"),)),  # a line with that of the hardware follows
    },
    # As in the firmware of the e-puck1.
    banner=("WELCOME to the SerCom protocol on e-Puck", 'the EPFL education robot type "H" for help'),
    identity=Request("V"),
    queries=tuple(map(Request, "EQONV")),
    baud_rates=(115200,),
    baud=115200,
    stop_bits=1,
    counters=("Q", 16),
    lamps=(8,),
    remark="HW version",
    end=b"\r",
    hint="is this the port of an e-puck2, switched on, with its selector in position 3 (Bluetooth) or 8 (USB)?",
)


_FULL_READING = 4096
TOUCHED = 300
"""Reading of the two front sensors from which an object is before the robot, about 30 mm away. Assumption: the response
of each sensor differs."""


class SerialEPuck(SerialRobot):
    """An e-puck2 over a serial port. See `SerialRobot`.

    `transmit` sends the wheel speeds (D); `receive` requests the infra-reds (N) and the step counters (Q). Readings are
    in the order and in the units of a Khepera's. An object is present while both front sensors see it, and the camera
    sees food before the robot.
    """

    model = E_PUCK
    protocol = PROTOCOL

    def _requests(self, command: Motors) -> list[Request]:
        return [Request("D", (round(command.left * self.model.unit), round(command.right * self.model.unit)))]

    def _read_senses(self) -> Senses:
        infra_reds, counters = (
            [int(value) for value in reply.values] for reply in self._exchange([Request("N"), Request("Q")])
        )
        self._count(*counters)
        readings = [max(0, infra_reds[i]) * (MAX_READING + 1) // _FULL_READING for i in KHEPERA_ORDER]
        a, b, c, d, e, f, g, h = readings
        step = self.model.pulse / self.model.scale / PULSE
        left, right = (round(count * step) for count in self._counts)
        presence = PRESENT if min(infra_reds[0], infra_reds[7]) >= TOUCHED else 0
        return Senses((a, b, c, d, e, f, g, h), left, right, ARM_DOWN, JAW_OPEN, presence)
