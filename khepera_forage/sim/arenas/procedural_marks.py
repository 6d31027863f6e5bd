"""Home, start and food of procedural arenas, on a floor of which a robot reaches every part. Whole millimetres."""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from khepera_forage.geometry.walls import clearance, walls_of
from khepera_forage.robots.khepera import FOOD_RADIUS, RADIUS
from khepera_forage.sim.arenas.draws import Draws
from khepera_forage.sim.arenas.family import HOME_RADIUS
from khepera_forage.sim.arenas.procedural_floor import Corners, NoRoomError

CLEARANCE = 85.0
"""From the centre of a robot with food in its gripper to the walls, at least."""
_HOME_CLEARANCE, _MARK_CLEARANCE = 115.0, 90.0
"""From the centre of the home, and from start and food, to the walls."""
_PAST_HOME = HOME_RADIUS + RADIUS, HOME_RADIUS + 50.0
"""From the centre of the home to a robot that drives past it: at least, and as way finding leads it."""
_MITRE: dict[str, Any] = {"join_style": "mitre", "mitre_limit": 1.5}
"""Way finding keeps this many clearances from corners."""
_START_TO_HOME, _FOOD_TO_HOME = 400.0, HOME_RADIUS + FOOD_RADIUS + 80.0
_FOOD_TO_START, _FOOD_SPACING = 280.0, 200.0
_TRIES = 60
"""For each place."""

Mark = tuple[int, int]


class Marks(NamedTuple):
    """Where everything is at the start of a training episode.

    Attributes:
        home: Its centre.
        start: Of a robot.
        degrees: Heading at the start.
        foods: One place an object.
    """

    home: Mark
    start: Mark
    degrees: int
    foods: tuple[Mark, ...]


def draw_marks(draws: Draws, walls: Corners, obstacles: Sequence[Corners], foods: int) -> Marks:
    """Places on a floor.

    Raises:
        NoRoomError: There is no room for them, or a robot could not reach every part of the floor without driving
            through the home.
    """
    records = walls_of((walls, *obstacles))
    length, width = max(x for x, _ in walls), max(y for _, y in walls)

    def place(least: float, *others: tuple[Mark, float]) -> Mark:
        low = math.ceil(least)
        for _ in range(_TRIES):
            found = draws.whole(low, length - low), draws.whole(low, width - low)
            apart = all(math.dist(found, other) >= distance for other, distance in others)
            if apart and clearance(*found, records) >= least:
                return found
        raise NoRoomError(f"no place {least:g} mm from every wall")

    home = place(_HOME_CLEARANCE)
    if not _can_be_passed(home, walls, obstacles):
        raise NoRoomError("the floor has parts that a robot cannot reach, or only through the home")
    start = place(_MARK_CLEARANCE, (home, _START_TO_HOME))
    marks: list[Mark] = []
    for _ in range(foods):
        near = [(other, _FOOD_SPACING) for other in marks]
        marks.append(place(_MARK_CLEARANCE, (home, _FOOD_TO_HOME), (start, _FOOD_TO_START), *near))
    return Marks(home, start, draws.whole(-179, 180), tuple(marks))


def _can_be_passed(home: Mark, walls: Corners, obstacles: Sequence[Corners]) -> bool:
    """Whether a robot can drive from everywhere to everywhere, with the home in its way and without."""
    import shapely  # takes 0.1 s, which importing this package should not

    floor = shapely.Polygon(walls).buffer(-CLEARANCE, **_MITRE)
    if obstacles:
        shapes = [shapely.Polygon(corners) for corners in obstacles]
        floor = floor.difference(shapely.union_all(shapely.buffer(shapes, CLEARANCE, **_MITRE)))
    past_home = [floor.difference(shapely.Point(home).buffer(distance)) for distance in _PAST_HOME]
    return all(region.geom_type == "Polygon" for region in (floor, *past_home))
