"""What a robot knows of its arena from the beginning, in pixels, and the floor on which everything is placed, in mm."""

from typing import Any, NamedTuple

from khepera_forage.geometry.paths import Ways
from khepera_forage.vision.scene import MM_PER_PIXEL

OUTSIDE = 4.0
"""Pixels by which a region may seem to lie outside its arena and still belong to it."""
EVERY_SIDE = 360.0
"""The opening of a home that can be left and passed on every side: no direction has this number of degrees."""


class ArenaMap(NamedTuple):
    """What a robot knows of its own arena, in pixels.

    Attributes:
        home_x: Centre of its home.
        home_y: Centre of its home.
        home_radius: Whole pixels.
        start_x: Where training starts.
        start_y: Where training starts.
        home_opening: Degrees from the home to the side on which it can be left and passed: to the middle of the floor,
            or, where walls stand between, to the first waypoint towards the start. `EVERY_SIDE` where no wall is near.
        diagonal: Of the arena, whole pixels: the largest distance of 4.6.1.
        left: Smallest x of a region that belongs to it, `OUTSIDE` pixels to the left of its walls.
        bottom: Smallest y of such a region.
        right: Largest x of such a region.
        top: Largest y of such a region.
        walls: `geometry.walls.Wall` records.
        ways: How to drive around its walls.
    """

    home_x: float
    home_y: float
    home_radius: int
    start_x: float
    start_y: float
    home_opening: float
    diagonal: int
    left: float
    bottom: float
    right: float
    top: float
    walls: Any
    ways: Ways


class Floor(NamedTuple):
    """The floor of an arena, in mm.

    Attributes:
        left: Smallest x.
        bottom: Smallest y.
        right: Largest x.
        top: Largest y.
        home_x: Centre of the home.
        home_y: Centre of the home.
        home_radius: Of the home.
        walls: `geometry.walls.Wall` records.
    """

    left: float
    bottom: float
    right: float
    top: float
    home_x: float
    home_y: float
    home_radius: float
    walls: Any


def whole_pixels(length: float) -> int:
    """A length in mm as robots know it: in whole pixels."""
    return round(length / MM_PER_PIXEL)


def is_within(x: float, y: float, arena: ArenaMap) -> bool:
    """Whether a region at this place, in pixels, lies in the arena."""
    # Without a chained comparison, which numba compiles to branches.
    return (arena.left <= x) & (x <= arena.right) & (arena.bottom <= y) & (y <= arena.top)
