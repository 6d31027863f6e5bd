"""The drivers of all kinds of robots."""

from khepera_forage.robots.epuck.driver import SerialEPuck
from khepera_forage.robots.khepera import CONTROL_PERIOD
from khepera_forage.robots.model import E_PUCK, KHEPERA, model_of
from khepera_forage.robots.real_robot import RealRobot
from khepera_forage.robots.serial.line import DEFAULT_TIMEOUT
from khepera_forage.robots.serial.serial_khepera import SerialKhepera
from khepera_forage.robots.serial.serial_robot import SerialRobot
from khepera_forage.robots.toio.driver import ToioRobot

_SERIAL: dict[str, type[SerialRobot]] = {KHEPERA.name: SerialKhepera, E_PUCK.name: SerialEPuck}


def serial_driver(kind: str) -> type[SerialRobot] | None:
    """The driver of a kind of robot with a serial line, None for others; raises `ValueError` for an unknown kind."""
    return _SERIAL.get(model_of(kind).name)


def open_robot(
    kind: str,
    port: str,
    *,
    baud: int | None = None,
    max_speed: int | None = None,
    timeout: float = DEFAULT_TIMEOUT,
    watchdog: bool = True,
    period: float | None = CONTROL_PERIOD,
) -> RealRobot:
    """Open a robot; arguments and errors are those of its driver.

    Args:
        kind: A name in `MODELS`.
        port: Serial port, or name or address of a cube.
        baud: Of a serial line; the usual one of the robot by default.
        max_speed: Limit of the wheel speeds in speed units, and at most that of the robot.
        timeout: Of a serial line.
        watchdog: Whether a process stops the robot if this one is killed or frozen; toio cubes stop by themselves.
        period: Seconds of a round, which a serial line must keep; None accepts any line.
    """
    driver = serial_driver(kind)
    limit = None if max_speed is None else min(max_speed, model_of(kind).max_speed)
    if driver is not None:
        return driver(port, baud=baud, max_speed=limit, timeout=timeout, watchdog=watchdog, period=period)
    return ToioRobot(port, max_speed=limit, period=period or CONTROL_PERIOD)
