"""The driver of a real e-puck2, over Bluetooth or USB."""

from khepera_forage.robots.epuck import protocol
from khepera_forage.robots.khepera import ARM_DOWN, JAW_OPEN, PRESENT, PULSE, Motors, Senses
from khepera_forage.robots.model import E_PUCK, KHEPERA_ORDER
from khepera_forage.robots.proximity import MAX_READING
from khepera_forage.robots.serial.protocol import Request
from khepera_forage.robots.serial.serial_robot import Counters, SerialRobot

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
    protocol = protocol.E_PUCK
    default_baud = 115200
    motion_commands = ("D",)
    lamps = (8,)

    def _prepare(self) -> None:
        self._counters = Counters(bits=16)

    def _requests(self, command: Motors) -> list[Request]:
        return [Request("D", (round(command.left * self.model.unit), round(command.right * self.model.unit)))]

    def _on_restart(self) -> None:
        self._counters.restarted()

    def _receive(self) -> None:
        self._begin_call()
        infra_reds, counters = (
            [int(value) for value in reply.values] for reply in self._exchange([Request("N"), Request("Q")])
        )
        if self._counters.update(*counters):
            self._must_restore = True
        readings = [max(0, infra_reds[i]) * (MAX_READING + 1) // _FULL_READING for i in KHEPERA_ORDER]
        a, b, c, d, e, f, g, h = readings
        step = self.model.pulse / self.model.scale / PULSE
        left, right = (round(count * step) for count in self._counters.total)
        presence = PRESENT if min(infra_reds[0], infra_reds[7]) >= TOUCHED else 0
        self._senses = Senses((a, b, c, d, e, f, g, h), left, right, ARM_DOWN, JAW_OPEN, presence)
