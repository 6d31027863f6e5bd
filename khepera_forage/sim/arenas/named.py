"""All arenas that have a name: those of the thesis, whose places are decisions, and the family.

The family are arenas beside those of the thesis, to measure how far a learned policy carries (4.9, 5.5). In all of them
the home has a radius of 80 mm, as the default decisions have it in the thesis's arenas. Passages are at least 200 mm
wide, walls between rooms 40 mm thick. An arena and its copy beside it, for training, are in the camera's picture of
3200 x 2400 mm.
"""

import math
from collections.abc import Mapping
from functools import cache
from typing import Any, NamedTuple

from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.sim.arenas.thesis import THESIS_ARENAS, SetUp, thesis_arena

HOME_RADIUS = 80.0
_LENGTH = 650.0
"""mm: length of the thesis's arenas, for which its step limits are."""


def box(left: float, bottom: float, right: float, top: float) -> tuple[Point, ...]:
    """The corners of a rectangle with level sides, counter-clockwise."""
    return Point(left, bottom), Point(right, bottom), Point(right, top), Point(left, top)


def corners(*places: tuple[float, float]) -> tuple[Point, ...]:
    """Corners from pairs of numbers."""
    return tuple(Point(x, y) for x, y in places)


class FamilyArena(NamedTuple):
    """An arena of the family, with the settings of its environments.

    Attributes:
        walls: Corners of the outer wall, mm.
        home: Centre of the home.
        start: Where a robot starts in training: x, y, and heading in degrees.
        foods: Where food lies in training.
        longest_path: From the home to the furthest place that a robot can reach, mm.
        obstacles: Corners of each.
        food_types: Odds of food types; None is all PICKABLE.
    """

    walls: tuple[Point, ...]
    home: tuple[float, float]
    start: tuple[float, float, float]
    foods: tuple[tuple[float, float], ...]
    longest_path: float
    obstacles: tuple[tuple[Point, ...], ...] = ()
    food_types: Mapping[str, float] | None = None

    @property
    def limit(self) -> int:
        """Steps of an episode at most."""
        return step_limit(len(self.foods), self.longest_path)


def step_limit(foods: int, longest_path: float) -> int:
    """Steps in which a robot can forage: the thesis's limits, in proportion to the length of the paths.

    The thesis has 500 steps for one food object and 700 for two, in arenas 650 mm long (5.4); each further object adds
    200.

    Args:
        foods: Number of food objects.
        longest_path: From the home to the furthest place that a robot can reach, mm.

    Returns:
        A whole number of hundreds.
    """
    return 100 * math.ceil((3 + 2 * foods) * max(1.0, longest_path / _LENGTH))


FAMILY: Mapping[str, FamilyArena] = {
    # Start at the foot, food in one arm, home in the other.
    "t_maze": FamilyArena(
        walls=corners((570, 0), (830, 0), (830, 600), (1400, 600), (1400, 860), (0, 860), (0, 600), (570, 600)),
        home=(1270, 730),
        start=(700, 110, 90),
        foods=((200, 730),),
        longest_path=1186,
    ),
    # Home and start in different arms.
    "l_room": FamilyArena(
        walls=corners((0, 0), (1400, 0), (1400, 500), (500, 500), (500, 1100), (0, 1100)),
        home=(250, 970),
        start=(1280, 250, 180),
        foods=((850, 150), (1000, 350)),
        longest_path=1515,
    ),
    # Three rooms in a row, with doors at opposite sides.
    "doors": FamilyArena(
        walls=box(0, 0, 1800, 800),
        home=(1660, 240),
        start=(140, 600, 0),
        foods=((400, 600), (900, 250)),
        longest_path=1898,
        obstacles=(box(580, 0, 620, 120), box(580, 360, 620, 800), box(1180, 0, 1220, 440), box(1180, 680, 1220, 800)),
    ),
    # One room with blocks of several shapes.
    "obstacles": FamilyArena(
        walls=box(0, 0, 1400, 1000),
        home=(1260, 860),
        start=(130, 130, 45),
        foods=((560, 760), (1080, 260)),
        longest_path=1417,
        obstacles=(
            box(280, 360, 400, 620),
            corners((620, 250), (780, 210), (840, 310), (700, 370)),
            corners((700, 580), (830, 620), (780, 730)),
            box(1040, 480, 1180, 540),
        ),
    ),
    # One empty room, with more food than in the thesis.
    "many_foods": FamilyArena(
        walls=box(0, 0, 1200, 900),
        home=(1070, 770),
        start=(120, 450, 0),
        foods=((400, 200), (400, 700), (600, 450), (800, 200), (800, 700)),
        longest_path=1200,
    ),
    # The same room with food to carry, to push and to leave alone (table 4.1).
    "mixed_foods": FamilyArena(
        walls=box(0, 0, 1200, 900),
        home=(1070, 770),
        start=(120, 450, 0),
        foods=((450, 200), (450, 700), (750, 200), (750, 700)),
        longest_path=1200,
        food_types={"PICKABLE": 0.5, "PUSHABLE": 0.25, "POISONOUS": 0.25},
    ),
}

ARENAS = (*THESIS_ARENAS, *FAMILY)
"""Names of arenas that environments, commands and laboratories accept."""


@cache
def family_arena(name: str) -> Arena:
    """An arena of the family.

    Args:
        name: One of `FAMILY`.
    """
    data = FAMILY[name]
    x, y, degrees = data.start
    return Arena(
        name=name,
        walls=data.walls,
        home=Point(*data.home),
        home_radius=HOME_RADIUS,
        start=Pose(x, y, math.radians(degrees)),
        foods=tuple(Point(*food) for food in data.foods),
        obstacles=data.obstacles,
    )


def named_arena(name: Any, set_up: SetUp) -> Arena:
    """An arena by its name.

    Args:
        name: One of `ARENAS`.
        set_up: Where start, food and home are in an arena of the thesis; without effect in other arenas.

    Raises:
        ValueError: An unknown name, or a set-up that does not fit.
    """
    if name not in ARENAS:
        raise ValueError(f"arena is {name!r}; allowed: an Arena, or one of {', '.join(map(repr, ARENAS))}")
    return family_arena(name) if name in FAMILY else thesis_arena(name, set_up)
