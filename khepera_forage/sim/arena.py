"""Arenas: walls, home, and where robots and food stand (section 3.1). Millimetres and radians."""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

from khepera_forage.geometry import polygon
from khepera_forage.geometry.plane import Wall, clearance, walls_of
from khepera_forage.robots.khepera import FOOD_RADIUS, RADIUS
from khepera_forage.vision.scene import MM_PER_PIXEL

MOST_FOODS = 16
"""Food objects in an arena at most, on every backend."""
_ROUNDING = 1e-6
"""mm by which something that just touches a wall may seem to stand in it, in a copy of an arena at an offset."""


class Point(NamedTuple):
    """A place in mm."""

    x: float
    y: float


class Pose(NamedTuple):
    """A place in mm and a heading in radians, counter-clockwise from the x axis."""

    x: float
    y: float
    heading: float


@dataclass(frozen=True, slots=True)
class Arena:
    """One walled enclosure with a home, and the set-up used for training in it.

    Any other enclosure can be described the same way and given to every environment.

    Attributes:
        name: Written into experience files, which are of one arena.
        walls: Corners of the outer wall, a simple polygon; the floor is inside.
        home: Centre of the home.
        home_radius: Of the home; at most the distance from its centre to the walls.
        start: Where a robot starts in training (figure 5.1).
        foods: Where food lies in training, one place an object; 1 to 16.
        obstacles: Further simple polygons on the floor; they may touch the outer wall and one another.

    Raises:
        ValueError: No name, walls that cross, obstacles that overlap or are not on the floor, a size that is not
            positive, too few or too many foods, or a home, start or food that is not on the free floor.
    """

    name: str
    walls: tuple[Point, ...]
    home: Point
    home_radius: float
    start: Pose
    foods: tuple[Point, ...]
    obstacles: tuple[tuple[Point, ...], ...] = ()

    def __post_init__(self) -> None:
        name = self.name
        if not (isinstance(name, str) and name and name == name.strip() and name.isprintable()):
            raise ValueError(f"name of an arena is {name!r}; allowed: a text on one line, no space around it")
        polygon.check_enclosure(self.name, self.walls, self.obstacles)
        if not MM_PER_PIXEL <= self.home_radius < math.inf:
            raise ValueError(
                f"{self.name}: home_radius is {self.home_radius!r} mm; allowed: at least {MM_PER_PIXEL:g} mm, one pixel"
            )
        if not 1 <= len(self.foods) <= MOST_FOODS:
            raise ValueError(
                f"{self.name}: foods has {len(self.foods)} places; allowed: 1 to {MOST_FOODS}, one an object"
            )
        self.check_free("home", self.home, 0.0)
        room = self.clearance(self.home)
        if room < self.home_radius - _ROUNDING:
            raise ValueError(
                f"{self.name}: home {tuple(self.home)} with radius {self.home_radius:g} mm reaches outside the walls; "
                f"allowed there: at most {room:.0f} mm"
            )
        self.check_free("start", self.start, RADIUS)
        for food in self.foods:
            self.check_free("food", food, FOOD_RADIUS)

    @property
    def segments(self) -> tuple[tuple[float, float, float, float], ...]:
        """All walls as line segments (x1, y1, x2, y2)."""
        return tuple(side for corners in (self.walls, *self.obstacles) for side in polygon.edges(corners))

    @property
    def wall_records(self) -> tuple[Wall, ...]:
        """All walls as `geometry.plane.Wall` records, in mm."""
        return walls_of((self.walls, *self.obstacles))

    @property
    def corners(self) -> tuple[tuple[float, float, int, int], ...]:
        """The corners that point into the floor: x, y, and the numbers of the two walls that meet there."""
        return polygon.inward_corners((self.walls, *self.obstacles))

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """Smallest x and y and largest x and y of the walls."""
        return polygon.bounds(self.walls)

    @property
    def diagonal(self) -> float:
        """Length of the diagonal of the bounds: the largest distance of section 4.6.1."""
        x1, y1, x2, y2 = self.bounds
        return math.hypot(x2 - x1, y2 - y1)

    def clearance(self, place: Point | Pose) -> float:
        """Distance from a place to the nearest wall, negative outside the free floor."""
        return clearance(place[0], place[1], self.wall_records)

    def check_free(self, what: str, place: Point | Pose, radius: float) -> None:
        """Complain if a disc does not fit on the free floor.

        Raises:
            ValueError: The place lies outside the walls, in an obstacle, or too near to one.
        """
        if not all(map(math.isfinite, place)):
            raise ValueError(f"{self.name}: {what} at {tuple(place)}; allowed: finite coordinates in mm")
        room = self.clearance(place)
        if room < radius - _ROUNDING:
            where = "inside a wall or outside the walls" if room < 0 else f"{room:.0f} mm from a wall"
            raise ValueError(
                f"{self.name}: {what} at ({place[0]:g}, {place[1]:g}) mm is {where}; "
                f"allowed: on the floor, at least {radius:g} mm from every wall"
            )

    def shifted(self, dx: float, dy: float) -> "Arena":
        """A copy at an offset in mm: identical but for where it stands (4.5.2)."""

        def move(corners: tuple[Point, ...]) -> tuple[Point, ...]:
            return tuple(Point(x + dx, y + dy) for x, y in corners)

        x, y, heading = self.start
        return replace(
            self,
            walls=move(self.walls),
            home=Point(self.home.x + dx, self.home.y + dy),
            start=Pose(x + dx, y + dy, heading),
            foods=move(self.foods),
            obstacles=tuple(move(o) for o in self.obstacles),
        )


def copies(arena: Arena, count: int) -> tuple[Arena, ...]:
    """An arena and its copies side by side the narrow way, then in further rows, with 70 mm between their walls.

    The gap keeps a marker of one from covering the floor of the next.

    Args:
        arena: The original, which is the first.
        count: How many arenas in all.

    Raises:
        ValueError: Fewer than one arena.
    """
    if count < 1:
        raise ValueError(f"{count!r} copies of an arena; allowed: at least 1")
    gap = 70.0
    x1, y1, x2, y2 = arena.bounds
    width, height = x2 - x1, y2 - y1
    dx, dy = width + gap, height + gap
    # As many rows or columns as 2.4 m of the thesis's laboratory floor hold.
    abreast = max(1, int((2400.0 + gap) / min(dx, dy)))
    places = (divmod(i, abreast) for i in range(count))
    return tuple(arena.shifted(a * dx, b * dy) if dy <= dx else arena.shifted(b * dx, a * dy) for a, b in places)
