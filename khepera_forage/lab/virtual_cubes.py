"""A laboratory of toio cubes without hardware: the real driver and toio-py, connected to virtual cubes."""

from khepera_forage.lab.clock import SimulatedClock
from khepera_forage.lab.cubes import CubeOperator
from khepera_forage.lab.laboratory import Laboratory
from khepera_forage.lab.settings import CameraSettings, LabSettings, RobotSettings
from khepera_forage.robots.model import TOIO
from khepera_forage.robots.toio.driver import SIMPLE_MAT, VIRTUAL
from khepera_forage.robots.toio.virtual import Table, use_table
from khepera_forage.sim.arena import Arena

_BORDER = 20.0
"""mm from the border of the mat to the first arena."""
_GAP = 6.0
"""mm from one arena to the next."""
_INTERVAL = 0.001
"""Seconds of the computer from one position of a virtual cube to the next."""


class VirtualCubeLaboratory(Laboratory):
    """A `Laboratory` on a virtual mat, whose time passes in rounds and while the cubes drive to their places.

    There is a copy of the arena for every robot, side by side; `table` has the true places of the cubes.

    Raises:
        ValueError: The mat has no room for the arenas.
    """

    def __init__(self, arena: Arena, robots: int, period: float, recall_marker: int) -> None:
        self._now = 0.0
        self.table = Table(lambda: self._now, _INTERVAL)
        use_table(self.table)
        x1, y1, _, y2 = arena.bounds
        step = y2 - y1 + _GAP
        placed = [arena.shifted(_BORDER - x1, _BORDER - y1 + i * step) for i in range(robots)]
        width, height = SIMPLE_MAT.size
        if any(copy.bounds[2] > width or copy.bounds[3] > height for copy in placed):
            raise ValueError(
                f"{robots} arenas {arena.name} do not fit a mat of {width:.0f} x {height:.0f} mm"
            )
        entries = tuple(
            RobotSettings(
                port=f"{VIRTUAL}robot {i}",
                name="teacher" if i == 0 and robots > 1 else f"learner_{max(0, i - 1)}",
                holes=recall_marker if robots == 1 else 1 if i == 0 else 2,
                offset=type(arena.home)(copy.home.x - arena.home.x, copy.home.y - arena.home.y),
                type=TOIO.name,
            )
            for i, copy in enumerate(placed)
        )
        foods = tuple(f"{VIRTUAL}food {i}" for i in range(robots * len(arena.foods)))
        settings = LabSettings(arena, entries, CameraSettings(), period, food_cubes=foods)
        operator = CubeOperator(lambda: self._devices.cubes, lambda: self._devices.foods, self._sleep)
        super().__init__(settings, operator, clock=SimulatedClock(lambda: self._sleep(period)))

    @property
    def port_urls(self) -> tuple[str, ...]:
        """The names of the robots."""
        return tuple(robot.port for robot in self.settings.robots)

    def _sleep(self, seconds: float) -> None:
        self._now += seconds
        self.table.advance()
