"""The driver of a toio cube, on Sony's library toio-py, and the printed mat on which cubes drive.

Requires the extra `toio`; it is imported when a cube is opened, not before.
"""

import asyncio
import contextlib
import math
import threading
import time
from collections.abc import Callable, Coroutine
from functools import cache
from typing import TYPE_CHECKING, Any, TypeVar

from khepera_forage.extras import require
from khepera_forage.robots.khepera import ARM_DOWN, CONTROL_PERIOD, JAW_OPEN, PRESENT, PULSE, RobotLost, Senses
from khepera_forage.robots.mat import COMMAND_DURATION, MatPose, MatRobot
from khepera_forage.robots.model import TOIO

if TYPE_CHECKING:
    from toio.device_interface import CubeInterface

_PLAN = 560 / 411 / TOIO.scale
"""Millimetres on the plan for one unit of the mat's positions (toio-sdk-for-unity)."""
_LEFT, _RIGHT, _TOP, _BOTTOM = 98, 402, 142, 358
"""Positions on the simple mat, the A3 sheet of 414 x 294 mm that comes with each cube; y points down."""


def to_plan(x: float, y: float, angle: float) -> MatPose:
    """Convert a position of the mat, whose angle is in degrees clockwise from x."""
    heading = math.remainder(-math.radians(angle), math.tau)
    return MatPose((x - _LEFT) * _PLAN, (_BOTTOM - y) * _PLAN, heading)


def to_mat(pose: MatPose) -> tuple[int, int, int] | None:
    """Convert a place on the plan; None off the mat."""
    x, y = round(_LEFT + pose.x / _PLAN), round(_BOTTOM - pose.y / _PLAN)
    is_on_mat = _LEFT <= x <= _RIGHT and _TOP <= y <= _BOTTOM
    return (x, y, round(math.degrees(-pose.heading)) % 360) if is_on_mat else None


T = TypeVar("T")

VIRTUAL = "virtual:"
"""A port that begins like this is a virtual cube; see `toio.virtual`."""
SLOWEST_UNIT, FASTEST_UNIT = 8, 115
"""Motor speeds that have an effect; a wheel does not turn below."""
_MAX_SILENCE = 0.5
"""Seconds without a position after which a cube on the mat counts as lost; it sends one every 10 ms."""
_SCAN_TIMEOUT = 10.0
_MOST_CUBES, _FIND_TIMEOUT = 50, 3.0
_WRITE_TIMEOUT = 2.0
_POLL = 0.002
_OFF_MAT = 0.02
"""Seconds to wait for a position of a cube that does not see the mat: it sends none."""
_FLASH = b"\x03\x64\x01\x01\xff\xff\xff"
"""Light for one second, white."""
_POSITION, _POSITION_MISSED = 0x01, 0x03
"""First bytes of a notification."""


class ToioRobot(MatRobot):
    """A cube on a mat. See `MatRobot`.

    Each command lasts 0.3 s, or two periods if they are longer, so that the wheels of a cube stop by themselves when
    the program ends in any way or the connection is lost; it has no watchdog process. A cube has neither gripper nor
    infra-reds. Its counters follow from its positions, and whether food is before it from those of the food.

    Args:
        port: Name of the cube as in "toio-A1b", its Bluetooth address, or "virtual:" and any name.
        max_speed: Limit of the wheel speeds in speed units.
        period: Seconds of a round, at most 0.5.

    Raises:
        ValueError: A speed that is not allowed.
        RobotLost: The cube was not found, or does not reply.
        ImportError: toio-py is missing.
    """

    model = TOIO
    mat_size = (_RIGHT - _LEFT) * _PLAN, (_BOTTOM - _TOP) * _PLAN
    """712 x 506 mm. Both corridors fit."""

    def __init__(self, port: str, *, max_speed: int | None = None, period: float | None = CONTROL_PERIOD) -> None:
        super().__init__(port, max_speed=max_speed, period=period)
        require("a toio cube", "toio")
        self._cube: Any = None
        self._notifications = 0
        self._open(self._connect)

    @property
    def longest_exchange(self) -> float:
        """See `RealRobot`."""
        return _MAX_SILENCE

    def turn_for(self, left: float, right: float, milliseconds: int) -> None:
        """Turn the wheels for a short time, at speeds in speed units or slower, within `max_speed`.

        Below the slowest speed of a cube, 4.8, the limit is this speed.
        """
        limit = max(float(self._max_speed), SLOWEST_UNIT / self.model.unit)
        factor = limit / max(abs(left), abs(right), limit)
        self.begin(lambda: self._write_motors(factor * left, factor * right, milliseconds)).result()

    @staticmethod
    def find() -> list[str]:
        """See `RealRobot`; none without Bluetooth."""
        require("a toio cube", "toio")
        from toio import BLEScanner

        try:
            found = _wait(BLEScanner.scan(_MOST_CUBES, timeout=_FIND_TIMEOUT), 2 * _FIND_TIMEOUT)
            return [cube.name for cube in found if cube.name]
        except Exception:  # bleak has an error for each system and kind of trouble
            return []

    def flash(self) -> None:
        """See `RealRobot`."""
        self.begin(lambda: self._send("light", lambda: self._cube.api.indicator._write(_FLASH))).result()

    # The methods below run in the cube's thread.

    def _connect(self) -> None:
        from toio import ToioCoreCube

        try:
            self._cube = ToioCoreCube(interface=self._interface())
            _wait(self._cube.connect(), _SCAN_TIMEOUT)
            api = self._cube.api
            _wait(api.id_information.register_notification_handler(self._note_position), _WRITE_TIMEOUT)
            # A position every 10 ms, also while the cube stands still; the default pauses.
            _wait(api.configuration._write(b"\x18\x00\x01\x00"), _WRITE_TIMEOUT)
        except RobotLost:
            raise
        except Exception as error:
            reason = f"it cannot be connected, or this computer has no Bluetooth: {_reason(error)}"
            raise RobotLost(self.port, "", 0, reason) from error
        self._stop_wheels()
        self._wait_for_position(_MAX_SILENCE)

    def _interface(self) -> "CubeInterface":
        """The cube of the port."""
        if self.port.startswith(VIRTUAL):
            from khepera_forage.robots.toio.virtual import the_table

            return the_table().cube(self.port.removeprefix(VIRTUAL))
        from toio import BLEScanner

        if ":" in self.port:
            search = BLEScanner.scan_with_address({self.port.upper()}, timeout=_SCAN_TIMEOUT)
        else:
            search = BLEScanner.scan_with_id({self.port.removeprefix("toio-")}, timeout=_SCAN_TIMEOUT)
        found = _wait(search, 2 * _SCAN_TIMEOUT)
        if not found:
            reason = "it was not found: is it switched on, near the computer, and not connected to another program?"
            raise RobotLost(self.port, "", 0, reason)
        interface: CubeInterface = found[0].interface
        return interface

    def _note_position(self, payload: bytearray) -> None:
        """Take a notification, in the thread of the Bluetooth connection."""
        if payload[0] == _POSITION:
            x, y, angle = (int.from_bytes(payload[i : i + 2], "little") for i in (1, 3, 5))
            self._note_place(to_plan(x, y, angle))
        elif payload[0] == _POSITION_MISSED:
            self.on_mat = False
        self._notifications += 1

    def _wait_for_position(self, patience: float) -> None:
        """Wait for a position that was taken after now; a cube that saw the mat is lost after so many seconds."""
        seen, end = self._notifications, time.monotonic() + patience
        while self._notifications == seen:
            self._check_interruption()
            if not self._cube.is_connect():
                raise RobotLost(self.port, "", 0, "the Bluetooth connection was lost")
            if time.monotonic() > end:
                if not self.on_mat:
                    return
                raise RobotLost(self.port, "", 0, f"it has sent no position for {_MAX_SILENCE:g} s")
            time.sleep(_POLL)

    def _transmit(self) -> None:
        if self._command is not None:
            left, right = self._along_walls(*self._command[:2])
            period = self._period or CONTROL_PERIOD
            # Wheels do not turn slower than the slowest speed: turn for a part of the round.
            part = min(1.0, max(abs(left), abs(right)) * self.model.unit / SLOWEST_UNIT)
            if 0.0 < part < 1.0:
                self._write_motors(left / part, right / part, 10 * max(1, round(100 * period * part)))
            else:
                self._write_motors(left, right, max(COMMAND_DURATION, round(2000 * period)))

    def _receive(self) -> None:
        self._wait_for_position(_MAX_SILENCE if self.on_mat else _OFF_MAT)
        left, right = (round(travel / PULSE) for travel in self._travel)
        self._senses = Senses((0,) * 8, left, right, ARM_DOWN, JAW_OPEN, PRESENT)

    def _stop_wheels(self) -> None:
        self._write_motors(0.0, 0.0, 0)

    def _write_motors(self, left: float, right: float, milliseconds: int) -> None:
        units = [_motor_unit(speed * self.model.unit) for speed in (left, right)]
        if any(units):
            self.stop_confirmed = False
        control = self._cube.api.motor.motor_control
        self._send(f"motors {units[0]}, {units[1]}", lambda: control(*units, milliseconds or None))
        self.stop_confirmed = not any(units)

    def _send(self, command: str, work: Callable[[], Coroutine[Any, Any, Any]]) -> None:
        """Let toio-py write something."""
        try:
            if not self._cube.is_connect():
                raise ConnectionError("the connection was lost")
            _wait(work(), _WRITE_TIMEOUT)
        except Exception as error:
            reason = f"Bluetooth failed: {_reason(error)}"
            raise RobotLost(self.port, command, 1, reason) from error

    def _disconnect(self) -> None:
        if self._cube is not None and self._cube.is_connect():
            with contextlib.suppress(Exception):  # a lost cube cannot be disconnected
                _wait(self._cube.disconnect(), _WRITE_TIMEOUT)


def _motor_unit(speed: float) -> int:
    """The nearest motor speed that has an effect."""
    unit = min(FASTEST_UNIT, round(abs(speed)))
    if 0 < unit < SLOWEST_UNIT:
        unit = SLOWEST_UNIT if 2 * unit >= SLOWEST_UNIT else 0
    return int(math.copysign(unit, speed))


def _reason(error: Exception) -> str:
    return str(error) or type(error).__name__


@cache
def _loop() -> asyncio.AbstractEventLoop:
    """The event loop of all Bluetooth connections, in a thread of its own."""
    loop = asyncio.new_event_loop()
    threading.Thread(target=loop.run_forever, name="bluetooth", daemon=True).start()
    return loop


_LOCK = threading.Lock()


def _wait(work: Coroutine[Any, Any, T], timeout: float) -> T:
    """Run work of toio-py in the event loop, and wait for its result."""
    with _LOCK:
        loop = _loop()
    return asyncio.run_coroutine_threadsafe(work, loop).result(timeout)
