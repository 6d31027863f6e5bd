"""Virtual cubes on a virtual mat, below toio-py's `CubeInterface`.

A cube is a disc on the plan of an arena that drives as commanded and pushes other cubes. A mat has no walls.
"""

import asyncio
import math
import threading
import time
from collections import deque
from collections.abc import Awaitable, Callable
from typing import Any
from uuid import UUID

from khepera_forage.extras import require
from khepera_forage.robots.khepera import SPEED_UNIT
from khepera_forage.robots.mat import MatPose
from khepera_forage.robots.model import TOIO
from khepera_forage.robots.toio.driver import FASTEST_UNIT, SLOWEST_UNIT, ToioRobot, to_mat

require("a virtual cube", "toio")

from toio.device_interface.dummy import DummyCube  # noqa: E402 (after the check)
from toio.toio_uuid import ToioUuid  # noqa: E402

RADIUS = TOIO.radius / TOIO.scale
"""Of a cube on the plan, in mm."""
_SPEED = SPEED_UNIT / TOIO.unit
"""mm/s on the plan for one unit of the motor speed."""
_STEP = 0.01
"""Seconds."""
_VERSION = b"\x81\x002.4.0"


class VirtualTable:
    """A mat with cubes, of which some are `unplugged` (their names): they have lost their connection.

    A clock of its own makes it independent of the machine's load; `interval` is the computer's time in seconds from one
    position of a cube to the next. Motor commands take effect after `latency`, in seconds of the clock.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic, interval: float = 0.01) -> None:
        self.unplugged: set[str] = set()
        self.clock, self.interval, self.latency = clock, interval, 0.0
        self._now = clock()
        self._lock = threading.RLock()
        self._cubes: dict[str, VirtualCube] = {}

    def cube(self, name: str, pose: MatPose | None = None) -> "VirtualCube":
        """The cube with a name; a new one stands at a free place unless one is given."""
        with self._lock:
            if name not in self._cubes:
                self._cubes[name] = VirtualCube(self, name, self._free_place() if pose is None else pose)
            elif pose is not None:
                self._cubes[name].pose = pose
            return self._cubes[name]

    def advance(self) -> None:
        """Let the cubes drive until now."""
        with self._lock:
            now = self.clock()
            while self._now + _STEP <= now:
                self._now += _STEP
                for cube in self._cubes.values():
                    cube.drive(self._now, _STEP)
                self._separate()

    def _free_place(self) -> MatPose:
        """A place beside the others, in a row along the upper border."""
        width, height = ToioRobot.mat_size
        number = len(self._cubes)
        columns = int(width // (3 * RADIUS))
        row, column = divmod(number, columns)
        return MatPose(1.5 * RADIUS * (2 * column + 1), height - 1.5 * RADIUS * (2 * row + 1), 0.0)

    def _separate(self) -> None:
        """Push cubes apart that overlap; a cube that drives moves one that stands."""
        cubes = list(self._cubes.values())
        for i, first in enumerate(cubes):
            for second in cubes[i + 1 :]:
                dx, dy = second.pose.x - first.pose.x, second.pose.y - first.pose.y
                distance = math.hypot(dx, dy) or 1e-6
                overlap = 2 * RADIUS - distance
                if overlap > 0:
                    share = 0.5 if first.turning == second.turning else float(second.turning)
                    for cube, part in ((first, -share), (second, 1.0 - share)):
                        x, y, heading = cube.pose
                        push = overlap * part / distance
                        cube.pose = MatPose(x + push * dx, y + push * dy, heading)


class VirtualCube(DummyCube):
    """One cube, as toio-py sees it; `pose` is its place on the plan."""

    def __init__(self, table: VirtualTable, name: str, pose: MatPose) -> None:
        self.pose = pose
        self._table, self._name = table, name
        self._units = (0, 0)
        self._until = math.inf
        self._commands = deque[tuple[float, float, tuple[int, int]]]()  # from when, until when, units
        self._connected = False
        self._task: asyncio.Task[None] | None = None

    @property
    def turning(self) -> bool:
        """Whether a wheel turns, or is about to."""
        return any(self._commands[-1][2] if self._commands else self._units)

    def drive(self, now: float, seconds: float) -> None:
        """Drive for a short time."""
        while self._commands and self._commands[0][0] <= now:
            _, self._until, self._units = self._commands.popleft()
        if now > self._until:
            self._units = 0, 0
        left, right = (unit * _SPEED * seconds for unit in self._units)
        x, y, heading = self.pose
        turn, forward = (right - left) / TOIO.plan_base, (left + right) / 2
        middle = heading + turn / 2
        self.pose = MatPose(x + forward * math.cos(middle), y + forward * math.sin(middle), heading + turn)

    async def connect(self) -> bool:
        """Connect, unless it is unplugged."""
        if self._name in self._table.unplugged:
            raise ConnectionError("the cube does not advertise itself")
        self._connected = True
        return True

    async def disconnect(self) -> bool:
        """Disconnect; the wheels stop when their command ends."""
        self._connected = False
        return True

    async def read(self, char_uuid: UUID) -> bytearray:
        """The answer to the last configuration request."""
        return bytearray(_VERSION)

    async def write(self, char_uuid: UUID, data: "bytes | bytearray | memoryview[int]", response: bool = False) -> None:
        """Execute a motor command; everything else is accepted and has no effect."""
        if not self.is_connect():
            raise ConnectionError("the cube is not connected")
        if char_uuid == ToioUuid.Motor.value and data[0] in (1, 2):
            self._table.advance()
            limited, begin = data[0] == 2 and data[7] > 0, self._table.clock() + self._table.latency
            units = _effective(data[2], data[3]), _effective(data[5], data[6])
            self._commands.append((begin, begin + data[7] / 100 if limited else math.inf, units))

    async def register_notification_handler(self, char_uuid: UUID, notification_handler: Any) -> bool:
        """Send positions to a function; there are no other notifications."""
        if char_uuid == ToioUuid.Id.value:
            self._task = asyncio.create_task(self._notify(notification_handler))
        return True

    def is_connect(self) -> bool:
        """Whether it is connected."""
        return self._connected and self._name not in self._table.unplugged

    async def _notify(self, handler: Callable[..., Awaitable[None]]) -> None:
        """Send positions until it is disconnected."""
        while self.is_connect():
            await asyncio.sleep(self._table.interval)
            self._table.advance()
            await handler(None, self._position())

    def _position(self) -> bytearray:
        place = to_mat(self.pose)
        if place is None:
            return bytearray((3,))
        return bytearray(b"\x01" + b"".join(v.to_bytes(2, "little") for v in (*place, *place)))


def _effective(direction: int, unit: int) -> int:
    """The speed at which a wheel turns."""
    speed = 0 if unit < SLOWEST_UNIT else min(unit, FASTEST_UNIT)
    return -speed if direction == 2 else speed


_TABLE: list[VirtualTable] = []


def the_table() -> VirtualTable:
    """The table of this process."""
    if not _TABLE:
        use_table(VirtualTable())
    return _TABLE[0]


def use_table(table: VirtualTable) -> None:
    """Let drivers find their virtual cubes on a table."""
    _TABLE[:] = [table]
