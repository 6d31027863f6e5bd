"""The firmware of a virtual e-puck2, in front of any `Robot`."""

from khepera_forage.robots.epuck.driver import PROTOCOL
from khepera_forage.robots.khepera import ARM_RAISED, JAW_OPEN, PULSE
from khepera_forage.robots.model import E_PUCK
from khepera_forage.robots.serial.protocol import NOT_FOUND_TEXT, wrap_counter
from khepera_forage.robots.virtual.firmware import Firmware, Handler, Values

_VERSIONS = "Version 2.0 January 2018 GCtronic", "HW version: E"
_DARK = 3900
"""Ambient light reading without a lamp. Assumption."""
_PULSES_PER_STEP = E_PUCK.pulse / E_PUCK.scale / PULSE
"""A Khepera's pulses for one step."""


class EPuckFirmware(Firmware):
    """The firmware of an e-puck2. See `Firmware`.

    The robot's speeds and counters are those of a Khepera; the firmware converts them into steps of the e-puck's
    wheels. A simulated gripper stays raised, where it touches nothing.
    """

    name = E_PUCK.name
    protocol = PROTOCOL
    argument_error = NOT_FOUND_TEXT

    def handle(self, line: bytes) -> bytes:
        """Execute one request; returns the reply with its ending."""
        reply = super().handle(line)
        return reply + f"{_VERSIONS[1]}\r\n".encode() if reply.startswith(b"v,") else reply

    def _initialise(self) -> None:
        super()._initialise()
        self._speeds = 0, 0
        self._drive(arm=ARM_RAISED, jaw=JAW_OPEN)

    def _handler(self, command: str) -> Handler:
        handlers: dict[str, Handler] = {
            "D": self._set_steps,
            "E": lambda: self._speeds,
            "N": self._infra_reds,
            "O": lambda: (_DARK,) * 8,
            "Q": lambda: tuple(wrap_counter(round(n / _PULSES_PER_STEP), 16) for n in self._counters()),
            "V": lambda: (_VERSIONS[0],),
        }
        return handlers.get(command, lambda *_: None)  # lights have no effect

    def _set_steps(self, left: int, right: int) -> None:
        self._speeds = left, right
        self._drive(left=round(left / E_PUCK.unit), right=round(right / E_PUCK.unit))

    def _infra_reds(self) -> Values:
        left90, left45, left10, right10, right45, right90, back_right, back_left = (
            4 * reading for reading in self._robot.sense().proximity
        )
        return right10, right45, right90, back_right, back_left, left90, left45, left10
