"""Settings that a Khepera's firmware stores: controller gains, LEDs, the extension bus, and analogue inputs."""

SPEED_GAINS = (3800, 800, 100)
POSITION_GAINS = (3000, 20, 4000)
"""Kp, Ki and Kd at power-on (KH2PY)."""


class Registers:
    """The settings at power-on, and the commands that write and read them.

    Attributes:
        speed_gains: Kp, Ki, Kd of the speed controller.
        position_gains: Kp, Ki, Kd of the position controller.
        leds: Whether each of the two LEDs is on.
        bus: The 64 bytes of the extension bus. No device is attached: a read returns the byte last written.
        analogue: Readings of the six analogue inputs, 0..1023; nothing is connected.
    """

    def __init__(self) -> None:
        self.speed_gains: tuple[int, ...] = SPEED_GAINS
        self.position_gains: tuple[int, ...] = POSITION_GAINS
        self.leds = [False, False]
        self.bus = bytearray(64)
        self.analogue = [0] * 6

    def set_speed_gains(self, *gains: int) -> tuple[()]:
        """Command A."""
        self.speed_gains = gains
        return ()

    def set_position_gains(self, *gains: int) -> tuple[()]:
        """Command F."""
        self.position_gains = gains
        return ()

    def read_analogue(self, channel: int) -> tuple[int]:
        """Command I."""
        return (self.analogue[channel],)

    def switch_led(self, led: int, action: int) -> tuple[()]:
        """Command L: off, on, toggle."""
        self.leds[led] = not self.leds[led] if action == 2 else action == 1
        return ()

    def read_bus(self, address: int) -> tuple[int]:
        """Command R."""
        return (self.bus[address],)

    def write_bus(self, data: int, address: int) -> tuple[()]:
        """Command W."""
        self.bus[address] = data
        return ()
