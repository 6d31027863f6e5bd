"""The mat as a camera: toio cubes report their own places."""

import math
from collections.abc import Sequence

from khepera_forage.robots.khepera import MARKER_LENGTH, MARKER_WIDTH
from khepera_forage.robots.toio.driver import ToioRobot
from khepera_forage.vision.scene import MM_PER_PIXEL, Region, Scene

_AREA = MARKER_LENGTH * MARKER_WIDTH / MM_PER_PIXEL**2
_PERIMETER = 2 * (MARKER_LENGTH + MARKER_WIDTH) / MM_PER_PIXEL


class MatCamera:
    """A `LabCamera` whose regions are cubes: robots, with the holes of the markers that they stand for, and food.

    A cube that was lifted off the mat, or has left it, keeps its last place and counts as lost, like a region that the
    tracker does not find.

    Args:
        robots: The robots.
        holes: Number of holes of each robot's marker.
        foods: The cubes that are food.
    """

    def __init__(self, robots: Sequence[ToioRobot], holes: Sequence[int], foods: Sequence[ToioRobot]) -> None:
        self._cubes = [*zip(robots, holes, strict=True), *((food, 0) for food in foods)]
        self._foods = foods
        self._scene = Scene(())

    def begin_round(self) -> None:
        """Nothing to do: places are taken in `expose`."""

    def forget(self) -> None:
        """Nothing to do: a cube's place does not follow from earlier ones."""

    def reset(self) -> None:
        """As `expose`."""
        self.expose()

    def expose(self) -> None:
        """Take the place of every cube.

        Raises:
            RobotLost: A cube that is food does not reply.
        """
        for food in self._foods:
            food.receive()
        self._scene = Scene(
            tuple(_region(label, cube, holes) for label, (cube, holes) in enumerate(self._cubes))
        )

    def look(self) -> Scene:
        """The places of the last `expose`."""
        return self._scene

    def close(self) -> None:
        """Stop and disconnect the food; a second call does nothing."""
        for food in self._foods:
            food.close()


def _region(label: int, cube: ToioRobot, holes: int) -> Region:
    x, y, heading = cube.pose
    degrees = round(math.degrees(heading)) % 360 if holes else 0
    place = x / MM_PER_PIXEL, y / MM_PER_PIXEL
    compactness = _PERIMETER**2 / _AREA
    return Region(label, *place, holes, degrees, cube.on_mat, False, *place, _AREA, _PERIMETER, compactness)
