"""The kinds of robots are known by their drivers."""

import pytest

from khepera_forage.robots.drivers import DRIVERS, FIRMWARES, open_robot
from khepera_forage.robots.model import MODELS
from khepera_forage.robots.serial.serial_robot import SerialRobot


def test_every_robot_has_a_driver_and_every_serial_one_a_firmware() -> None:
    assert DRIVERS.keys() == MODELS.keys()
    assert all(driver.model is MODELS[kind] for kind, driver in DRIVERS.items())
    serial = {kind: driver.protocol for kind, driver in DRIVERS.items() if issubclass(driver, SerialRobot)}
    assert {kind: firmware.protocol for kind, firmware in FIRMWARES.items()} == serial


def test_unknown_robot_is_rejected() -> None:
    with pytest.raises(ValueError, match="robot is 'cube'; allowed: 'khepera', 'e-puck2', 'toio'"):
        open_robot("cube", "/dev/null")
