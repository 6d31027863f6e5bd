"""The thesis's arenas (section 3.1), with start, food and home as in figure 5.1. Millimetres and radians."""

from typing import NamedTuple

from khepera_forage.sim.arena import Arena, Point, Pose


class SetUp(NamedTuple):
    """The set-up of figure 5.1 in an arena, in mm: start, food and home.

    Attributes:
        start_to_wall: From the robot's start to the wall behind it.
        food_to_home: From the food to the centre of the home, along the arena.
        home_to_wall: From the home's centre to the wall behind it.
        home_radius: Of the home.
        start_aside: From the arena's middle line to the start, towards the left of a robot that faces the home.
        food_aside: From the middle line to the food, likewise; added to each object's own place.
        home_aside: From the middle line to the centre of the home, likewise.
    """

    start_to_wall: float
    food_to_home: float
    home_to_wall: float
    home_radius: float
    start_aside: float
    food_aside: float
    home_aside: float


class _Shape(NamedTuple):
    """Length and width of a rectangular arena, and how far beside its middle each food object lies, in mm."""

    length: float
    width: float
    foods_aside: tuple[float, ...]


CORRIDOR, RECTANGLE = "corridor", "rectangle"
_SHAPES = {
    # The training corridor (3.1).
    CORRIDOR: _Shape(650.0, 230.0, (0.0,)),
    # The evaluation arena (3.1), with the corridor's home and two food objects (5.4.2).
    RECTANGLE: _Shape(650.0, 600.0, (-100.0, 100.0)),
}
THESIS_ARENAS = tuple(_SHAPES)
"""Names of the thesis's arenas."""


def thesis_arena(name: str, set_up: SetUp) -> Arena:
    """One of the thesis's arenas.

    Args:
        name: One of `THESIS_ARENAS`.
        set_up: Where start, food and home are (figure 5.1).

    Raises:
        ValueError: A set-up that does not fit.
    """
    length, width, foods_aside = _SHAPES[name]
    middle, home = width / 2, length - set_up.home_to_wall
    return Arena(
        name=name,
        walls=(Point(0, 0), Point(length, 0), Point(length, width), Point(0, width)),
        home=Point(home, middle + set_up.home_aside),
        home_radius=set_up.home_radius,
        start=Pose(set_up.start_to_wall, middle + set_up.start_aside, 0.0),
        foods=tuple(Point(home - set_up.food_to_home, middle + set_up.food_aside + aside) for aside in foods_aside),
    )
