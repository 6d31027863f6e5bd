"""Procedural arenas: a seeded generator with difficulty levels, and sequences of training and test arenas.

As in Procgen (Cobbe et al. 2020), an arena is a *level*, whose number is its seed. Levels for training are below 10**6
and those for the test from there on, so that no test arena is ever trained in.
"""

import math
import operator
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import SupportsIndex, overload

from khepera_forage.sim.arena import Arena, Point, Pose
from khepera_forage.sim.arenas.difficulty import DIFFICULTIES, Difficulty, checked_difficulty
from khepera_forage.sim.arenas.draws import Draws
from khepera_forage.sim.arenas.family import HOME_RADIUS
from khepera_forage.sim.arenas.procedural_floor import Corners, NoRoomError, draw_floor
from khepera_forage.sim.arenas.procedural_marks import Mark, Marks, draw_marks

LEVELS = 10**6
"""Number of levels of each split."""
SPLITS = {"train": 0, "test": LEVELS}
"""First level of each."""
TRIES = 200
"""Tries to draw an arena, after which there is no room."""


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
    for attempt in range(TRIES):
        draws = Draws(level, chosen.name, attempt)
        try:
            walls, obstacles = draw_floor(draws, chosen)
            marks = draw_marks(draws, walls, obstacles, chosen.foods)
        except NoRoomError as error:
            problem = error
            continue
        return _arena(name, walls, obstacles, marks, upright=bool(draws.whole(0, 1)))
    raise ValueError(
        f"difficulty {chosen.name!r}: no room for {chosen.foods} food objects, {chosen.partitions[0]} partitions and "
        f"{chosen.blocks[0]} blocks in level {level} after {TRIES} tries, in the last one {problem}; "
        "allowed: fewer of them, or a larger arena"
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
        last = _whole_number("start_level", self.start_level, 0) + _whole_number(
            "num_levels", self.num_levels, 1
        )
        if last > LEVELS:
            raise ValueError(
                f"start_level {self.start_level} + num_levels {self.num_levels} is {last}; allowed: at most {LEVELS}"
            )

    @property
    def first_level(self) -> int:
        """Number of the first level."""
        return SPLITS[self.split] + self.start_level

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


def _arena(name: str, walls: Corners, obstacles: Sequence[Corners], marks: Marks, upright: bool) -> Arena:
    """The arena, turned by a quarter if `upright`."""
    width = max(y for _, y in walls)

    def turned(place: Mark) -> Point:
        x, y = place
        return Point(float(width - y), float(x)) if upright else Point(float(x), float(y))

    return Arena(
        name=name,
        walls=tuple(map(turned, walls)),
        home=turned(marks.home),
        home_radius=HOME_RADIUS,
        start=Pose(*turned(marks.start), math.radians(marks.degrees + 90 * upright)),
        foods=tuple(map(turned, marks.foods)),
        obstacles=tuple(tuple(map(turned, corners)) for corners in obstacles),
    )


def _whole_number(name: str, value: SupportsIndex, least: int) -> int:
    try:
        number = operator.index(value)
    except TypeError:
        number = -1
    if number < least or isinstance(value, bool):
        raise ValueError(f"{name} is {value!r}; allowed: a whole number of at least {least}")
    return number
