"""Difficulty levels of procedural arenas. Millimetres."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from khepera_forage.noise import Noise
from khepera_forage.sim.arena import MOST_FOODS
from khepera_forage.sim.arenas.named import step_limit

Range = tuple[int, int]
"""The least and the greatest whole number."""

_ALLOWED: Mapping[str, Range] = {
    # The camera sees 3200 x 2400 mm; an arena and its copy beside it, 70 mm apart, are in the picture either way up.
    "length": (500, 2400),
    "width": (400, 1165),
    "notches": (0, 2),
    "partitions": (0, 8),
    "blocks": (0, 30),
}


def _is_range(value: object) -> bool:
    return isinstance(value, tuple) and len(value) == 2 and all(type(number) is int for number in value)


@dataclass(frozen=True, slots=True)
class Difficulty:
    """What procedural arenas are drawn from, and the settings of their environments.

    Attributes:
        name: Part of the arenas' names.
        length: Of the longer side of the floor, mm.
        width: Of the shorter side of the floor, mm.
        notches: How many corners of the rectangular floor are cut out.
        partitions: How many walls with a door divide the floor into rooms.
        blocks: How many obstacles stand free.
        most_walls: Straight walls of an arena at most: sides of the outer wall, partitions and blocks.
        foods: Number of food objects, 1 to 16.
        longest_path: From the home to the furthest place, mm, which the step limit allows for.
        food_types: Odds of food types.
        noise: Errors of devices, as a share of the laboratory's.

    Raises:
        ValueError: A value that is not allowed.
    """

    name: str
    length: Range
    width: Range
    notches: Range
    partitions: Range
    blocks: Range
    most_walls: int
    foods: int
    longest_path: float
    food_types: Mapping[str, float] = field(default_factory=lambda: {"PICKABLE": 1.0}, hash=False)
    noise: float = 1.0

    def __post_init__(self) -> None:
        for name, (low, high) in _ALLOWED.items():
            value = getattr(self, name)
            if not (_is_range(value) and low <= value[0] <= value[1] <= high):
                raise ValueError(
                    f"difficulty {self.name!r}: {name} is {value!r}; "
                    f"allowed: two whole numbers in increasing order, {low} to {high}"
                )
        if not (type(self.foods) is int and 1 <= self.foods <= MOST_FOODS):
            raise ValueError(f"difficulty {self.name!r}: foods is {self.foods!r}; allowed: 1 to {MOST_FOODS}")
        for name, least in (("most_walls", 4), ("longest_path", 0), ("noise", 0)):
            value = getattr(self, name)
            if not (isinstance(value, int | float) and least <= value < float("inf")):
                raise ValueError(
                    f"difficulty {self.name!r}: {name} is {value!r}; allowed: a number of at least {least}"
                )

    @property
    def limit(self) -> int:
        """Steps of an episode at most, by the rule of the family."""
        return step_limit(self.foods, self.longest_path)

    def scaled_noise(self) -> Noise:
        """The noise of the environments."""
        return Noise.laboratory().scaled(self.noise)


DIFFICULTIES: Mapping[str, Difficulty] = {
    difficulty.name: difficulty
    for difficulty in (
        Difficulty(
            "easy",
            length=(650, 1000),
            width=(500, 800),
            notches=(0, 0),
            partitions=(0, 0),
            blocks=(0, 1),
            most_walls=10,
            foods=1,
            longest_path=1000,
            noise=0.5,
        ),
        Difficulty(
            "medium",
            length=(900, 1400),
            width=(650, 950),
            notches=(0, 1),
            partitions=(0, 1),
            blocks=(1, 2),
            most_walls=18,
            foods=2,
            longest_path=1700,
            food_types={"PICKABLE": 0.75, "PUSHABLE": 0.25},
        ),
        Difficulty(
            "hard",
            length=(1300, 1900),
            width=(750, 1100),
            notches=(0, 2),
            partitions=(1, 2),
            blocks=(1, 3),
            most_walls=24,
            foods=3,
            longest_path=2500,
            food_types={"PICKABLE": 0.5, "PUSHABLE": 0.3, "POISONOUS": 0.2},
        ),
        Difficulty(
            "extreme",
            length=(1700, 2400),
            width=(850, 1165),
            notches=(1, 2),
            partitions=(2, 3),
            blocks=(1, 4),
            most_walls=30,
            foods=4,
            longest_path=3400,
            food_types={"PICKABLE": 0.4, "PUSHABLE": 0.3, "POISONOUS": 0.3},
            noise=1.5,
        ),
    )
}
"""By their names, from the easiest to the hardest."""


def checked_difficulty(difficulty: object) -> Difficulty:
    """A difficulty that a user gave.

    Args:
        difficulty: One of the names in `DIFFICULTIES`, or a `Difficulty`.

    Raises:
        ValueError: Something else.
    """
    if isinstance(difficulty, Difficulty):
        return difficulty
    if isinstance(difficulty, str) and difficulty in DIFFICULTIES:
        return DIFFICULTIES[difficulty]
    raise ValueError(f"difficulty is {difficulty!r}; allowed: {', '.join(map(repr, DIFFICULTIES))}, or a Difficulty")
