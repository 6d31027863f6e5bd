"""The drivers of all kinds of robots."""

from typing import Any

from khepera_forage.robots.epuck.driver import SerialEPuck
from khepera_forage.robots.khepera import CONTROL_PERIOD
from khepera_forage.robots.model import E_PUCK, KHEPERA, model_of
from khepera_forage.robots.real_robot import RealRobot
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from khepera_forage.robots.serial.serial_robot import SerialRobot
from khepera_forage.robots.toio.driver import ToioRobot

_SERIAL: dict[str, type[SerialRobot]] = {KHEPERA.name: SerialKhepera, E_PUCK.name: SerialEPuck}


def serial_driver(kind: str) -> type[SerialRobot] | None:
    """The driver of a kind of robot with a serial line, None for others; raises `ValueError` for an unknown kind."""
    return _SERIAL.get(model_of(kind).name)


def open_robot(
    kind: str, port: str, *, max_speed: int | None = None, period: float | None = CONTROL_PERIOD, **options: Any
) -> RealRobot:
    """Open a robot; its driver explains the arguments and raises the errors.

    Args:
        kind: A name in `MODELS`.
        port: Serial port, or name or address of a cube.
        max_speed: Limit of the wheel speeds in speed units, and at most that of the robot.
        period: Seconds of a round.
        **options: Of a `SerialRobot`; a cube, which has no serial line, ignores them.
    """
    driver = serial_driver(kind)
    limit = None if max_speed is None else min(max_speed, model_of(kind).max_speed)
    if driver is not None:
        return driver(port, max_speed=limit, period=period, **options)
    return ToioRobot(port, max_speed=limit, period=period or CONTROL_PERIOD)
