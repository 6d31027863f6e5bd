"""Procedural arenas: a seeded generator with difficulty levels, and sequences of training and test arenas.

As in Procgen (Cobbe et al. 2020), an arena is a *level*, whose number is its seed. Levels for training are below 10**6
and those for the test from there on, so that no test arena is ever trained in.
"""

import math
import operator
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, SupportsIndex, overload

from khepera_forage.geometry.plane import clearance, walls_of
from khepera_forage.robots.khepera import FOOD_RADIUS, RADIUS
from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES, Difficulty, checked_difficulty
from khepera_forage.sim.arenas.named import HOME_RADIUS
from khepera_forage.sim.arenas.procedural_floor import Corners, Draws, NoRoomError, draw_floor

LEVELS = 10**6
"""Number of levels of each split."""
SPLITS = {"train": 0, "test": LEVELS}
"""First level of each."""
_TRIES = 200
"""Tries to draw an arena, after which there is no room."""
_CLEARANCE = 85.0
"""From the centre of a robot with food in its gripper to the walls, at least."""
_HOME_CLEARANCE, _MARK_CLEARANCE = 115.0, 90.0
"""From the centre of the home, and from start and food, to the walls."""
_PAST_HOME = HOME_RADIUS + RADIUS, HOME_RADIUS + 50.0
"""From the centre of the home to a robot that drives past it: at least, and as way finding leads it."""
_MITRE: dict[str, Any] = {"join_style": "mitre", "mitre_limit": 1.5}
"""Path finding keeps this many clearances from corners."""
_START_TO_HOME, _FOOD_TO_HOME = 400.0, HOME_RADIUS + FOOD_RADIUS + 80.0
_FOOD_TO_START, _FOOD_SPACING = 280.0, 200.0
_TRIES_A_PLACE = 60
"""Tries to find each place."""

Mark = tuple[int, int]
"""Where something stands at the start of a training episode, in whole millimetres."""


@lru_cache(maxsize=1 << 14)
def procedural_arena(level: int, difficulty: str | Difficulty = "medium") -> Arena:
    """The arena of a level, the same on every machine.

    Args:
        level: A whole number of at least 0.
        difficulty: One of `DIFFICULTIES`, or a `Difficulty` of your own.

    Raises:
        ValueError: Another level or difficulty, or a difficulty without room for its food objects.
    """
    chosen = checked_difficulty(difficulty)
    level = _whole_number("level", level, 0)
    name = f"procedural_{chosen.name}_{level}"
    for attempt in range(_TRIES):
        try:
            return _draw(Draws(level, chosen.name, attempt), name, chosen)
        except NoRoomError as error:
            problem = error
    raise ValueError(
        f"difficulty {chosen.name!r}: no room for {chosen.foods} food objects, {chosen.partitions[0]} partitions and "
        f"{chosen.blocks[0]} blocks in level {level} after {_TRIES} tries, in the last one {problem}; "
        "allowed: fewer of them, more walls, or a larger arena"
    )


def level_of(name: str) -> tuple[str, int] | None:
    """The difficulty and the level of a procedural arena, from its name; None if it has another name.

    Args:
        name: Such as `procedural_hard_5`. A `Difficulty` of your own is not known by its name.
    """
    found = re.fullmatch(r"procedural_(\w+)_(\d+)", name)
    return (found[1], int(found[2])) if found and found[1] in DIFFICULTIES else None


@dataclass(frozen=True)
class ProceduralArenas(Sequence[Arena]):
    """Consecutive levels of a difficulty, for environments: `arena=ProceduralArenas("hard", split="test")`.

    An arena is drawn when it is first used, and kept in memory.

    Args:
        difficulty: One of `DIFFICULTIES`, or a `Difficulty` of your own.
        split: `"train"` or `"test"`, which have no level in common.
        num_levels: How many.
        start_level: First level, counted from the first one of the split.

    Raises:
        ValueError: Another difficulty or split, or levels that are not in the split.
    """

    difficulty: str | Difficulty = "medium"
    split: str = "train"
    num_levels: int = 200
    start_level: int = 0

    def __post_init__(self) -> None:
        checked_difficulty(self.difficulty)
        if self.split not in SPLITS:
            raise ValueError(f"split is {self.split!r}; allowed: {', '.join(map(repr, SPLITS))}")
        last = _whole_number("start_level", self.start_level, 0) + _whole_number("num_levels", self.num_levels, 1)
        if last > LEVELS:
            raise ValueError(
                f"start_level {self.start_level} + num_levels {self.num_levels} is {last}; allowed: at most {LEVELS}"
            )

    @property
    def first_level(self) -> int:
        """Number of the first level."""
        return SPLITS[self.split] + self.start_level

    @property
    def food_types(self) -> Mapping[str, float]:
        """Odds of food types, those of the difficulty."""
        return checked_difficulty(self.difficulty).food_types

    @property
    def diagonal(self) -> float:
        """Length of the diagonal of the largest arena that can be drawn, mm."""
        largest = checked_difficulty(self.difficulty)
        return math.hypot(largest.length[1], largest.width[1])

    def __len__(self) -> int:
        return self.num_levels

    @overload
    def __getitem__(self, index: SupportsIndex) -> Arena: ...

    @overload
    def __getitem__(self, index: slice) -> tuple[Arena, ...]: ...

    def __getitem__(self, index: SupportsIndex | slice) -> Arena | tuple[Arena, ...]:
        chosen = range(self.num_levels)[index]
        if isinstance(chosen, int):
            return procedural_arena(self.first_level + chosen, self.difficulty)
        return tuple(procedural_arena(self.first_level + i, self.difficulty) for i in chosen)


def _draw(draws: Draws, name: str, difficulty: Difficulty) -> Arena:
    """One try to draw an arena.

    Raises:
        NoRoomError: Something does not fit, or a robot could not reach every part of the floor without driving through
            the home.
    """
    walls, obstacles = draw_floor(draws, difficulty)
    records = walls_of((walls, *obstacles))
    length, width = max(x for x, _ in walls), max(y for _, y in walls)

    def place(least: float, *others: tuple[Mark, float]) -> Mark:
        low = math.ceil(least)
        for _ in range(_TRIES_A_PLACE):
            found = draws.whole(low, length - low), draws.whole(low, width - low)
            apart = all(math.dist(found, other) >= distance for other, distance in others)
            if apart and clearance(*found, records) >= least:
                return found
        raise NoRoomError(f"no place {least:g} mm from every wall")

    home = place(_HOME_CLEARANCE)
    if not _can_be_passed(home, walls, obstacles):
        raise NoRoomError("the floor has parts that a robot cannot reach, or only through the home")
    start = place(_MARK_CLEARANCE, (home, _START_TO_HOME))
    foods: list[Mark] = []
    for _ in range(difficulty.foods):
        near = [(other, _FOOD_SPACING) for other in foods]
        foods.append(place(_MARK_CLEARANCE, (home, _FOOD_TO_HOME), (start, _FOOD_TO_START), *near))
    degrees = draws.whole(-179, 180)
    upright = draws.whole(0, 1)  # the arena is then turned by a quarter

    def turned(mark: Mark) -> Point:
        x, y = mark
        return Point(float(width - y), float(x)) if upright else Point(float(x), float(y))

    return Arena(
        name=name,
        walls=tuple(map(turned, walls)),
        home=turned(home),
        home_radius=HOME_RADIUS,
        start=Pose(*turned(start), math.radians(degrees + 90 * upright)),
        foods=tuple(map(turned, foods)),
        obstacles=tuple(tuple(map(turned, corners)) for corners in obstacles),
    )


def _can_be_passed(home: Mark, walls: Corners, obstacles: Sequence[Corners]) -> bool:
    """Whether a robot can drive from everywhere to everywhere, with the home in its way and without."""
    import shapely  # takes 0.1 s, which importing this package should not

    floor = shapely.Polygon(walls).buffer(-_CLEARANCE, **_MITRE)
    if obstacles:
        shapes = [shapely.Polygon(corners) for corners in obstacles]
        floor = floor.difference(shapely.union_all(shapely.buffer(shapes, _CLEARANCE, **_MITRE)))
    past_home = [floor.difference(shapely.Point(home).buffer(distance)) for distance in _PAST_HOME]
    return all(region.geom_type == "Polygon" for region in (floor, *past_home))


def _whole_number(name: str, value: SupportsIndex, least: int) -> int:
    try:
        number = operator.index(value)
    except TypeError:
        number = -1
    if number < least or isinstance(value, bool):
        raise ValueError(f"{name} is {value!r}; allowed: a whole number of at least {least}")
    return number
