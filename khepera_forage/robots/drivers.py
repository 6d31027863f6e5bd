"""The kinds of robots: their drivers, and the firmwares of their virtual ones."""

from typing import Any

from khepera_forage.robots.epuck.driver import SerialEPuck
from khepera_forage.robots.epuck.firmware import EPuckFirmware
from khepera_forage.robots.khepera import CONTROL_PERIOD
from khepera_forage.robots.model import E_PUCK, KHEPERA, model_of
from khepera_forage.robots.real_robot import RealRobot
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from khepera_forage.robots.serial.serial_robot import SerialRobot
from khepera_forage.robots.toio.driver import ToioRobot
from khepera_forage.robots.virtual.firmware import Firmware

DRIVERS: dict[str, type[RealRobot]] = {driver.model.name: driver for driver in (SerialKhepera, SerialEPuck, ToioRobot)}
"""By the name of the robot's model."""
FIRMWARES: dict[str, type[Firmware]] = {KHEPERA.name: Firmware, E_PUCK.name: EPuckFirmware}
"""Of the robots with a serial line."""


def open_robot(
    kind: str, port: str, *, max_speed: int | None = None, period: float | None = CONTROL_PERIOD, **options: Any
) -> RealRobot:
    """Open a robot; its driver explains the arguments and raises the errors.

    Args:
        kind: A name in `DRIVERS`.
        port: Serial port, or name or address of a cube.
        max_speed: Limit of the wheel speeds in speed units, and at most that of the robot.
        period: Seconds of a round.
        **options: Of a `SerialRobot`; a robot without a serial line ignores them.
    """
    model = model_of(kind)
    driver = DRIVERS[model.name]
    limit = None if max_speed is None else min(max_speed, model.max_speed)
    return driver(port, max_speed=limit, period=period, **(options if issubclass(driver, SerialRobot) else {}))
