"""The text format of experience files: valid headers and rows, and their text.

    # khepera_forage experience, version 1
    # package: 0.1.0
    # arena: corridor
    # seed: 7
    # episodes: 1
    # decisions: v0.1;next_to_food=22
    # units: distances in pixels of 5 mm; arms_height 255 (down) to 215 (raised)
    object_presence,robot_home_distance,food_type,arms_height,robot_food_distance,behaviour
    0,52,UNKNOWN,215,28,SEARCH_FOR_FOOD
    # complete: 1 vectors

The closing line distinguishes a complete recording from a killed one. The line of decisions names a version and what
differs from it, or says that the decisions are `mixed`. Older files have no such line, or one that names no version:
their decisions are those of version 0.1, and what differs from it.
"""

from collections.abc import Sequence
from operator import index
from typing import Any, NamedTuple

from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED
from khepera_forage.task.decisions import Decisions, decisions_from_text, decisions_text
from khepera_forage.task.states import Behaviour, FoodType, StateVector

VERSION = 1
MAGIC = "# khepera_forage experience, version "
UNITS = f"distances in pixels of 5 mm; arms_height {ARM_DOWN} (down) to {ARM_RAISED} (raised)"
COLUMNS = (*StateVector._fields, "behaviour")
MAX_DISTANCE = 2**31 - 1
"""Pixels: more than in any arena, and the largest number of a 32-bit integer."""

MIXED = "mixed"
"""Text of the decisions of joined experience that was recorded under different ones."""

RECORDED = [behaviour.name for behaviour in Behaviour if behaviour != Behaviour.WAIT]
FOOD_TYPES = [food_type.name for food_type in FoodType]


class ExperienceError(ValueError):
    """A value or a file is not valid experience."""


class ExperienceWarning(UserWarning):
    """An experience file is incomplete; its complete rows were read."""


def quoted(thing: object) -> str:
    """A value for an error message: its `repr`, shortened to 80 characters."""
    text = repr(thing)
    return text if len(text) <= 80 else text[:77] + "..."


class Header(NamedTuple):
    """The header of an experience file.

    Attributes:
        arena: Name of the arena in which the experience was recorded.
        seed: Of the training, if known.
        episodes: Number of training episodes.
        decisions: Of the training; None if experience of different decisions was joined.
    """

    arena: str
    seed: int | None
    episodes: int
    decisions: Decisions | None


def checked_header(arena: str, seed: int | None, episodes: int, decisions: Decisions | None) -> Header:
    """Check the values of a header, and return it.

    Raises:
        ExperienceError: A value is out of range or cannot be written.
    """
    if not arena or arena != arena.strip() or not arena.isprintable():
        raise ExperienceError(
            f"arena is {arena!r}; allowed: a printable name on one line, no space around it"
        )
    try:
        header = Header(arena, None if seed is None else index(seed), index(episodes), decisions)
    except TypeError:
        raise ExperienceError(f"seed is {seed!r}, episodes {episodes!r}; allowed: integers") from None
    if header.seed is not None and abs(header.seed) >= 10**100:
        raise ExperienceError("seed has more than 100 digits; allowed: at most 100")
    if header.episodes < 1:
        raise ExperienceError(f"episodes is {episodes!r}; allowed: at least 1")
    if not (decisions is None or isinstance(decisions, Decisions)):
        raise ExperienceError(
            f"decisions is {decisions!r}; allowed: a khepera_forage.Decisions, or None if mixed"
        )
    return header


def header_decisions_text(decisions: Decisions | None) -> str:
    """Decisions as a header stores them."""
    return MIXED if decisions is None else decisions_text(decisions)


def header_decisions(text: str) -> Decisions | None:
    """The decisions that a text of `header_decisions_text` describes; None if mixed.

    Raises:
        ValueError: Not of this form.
    """
    return None if text == MIXED else decisions_from_text(text)


def checked_row(vector: Sequence[Any], behaviour: Any) -> tuple[StateVector, Behaviour]:
    """Check that a learner can have recorded a row, and return it as plain integers.

    Raises:
        ExperienceError: A value is out of range, or the values contradict each other.
    """
    try:
        numbers = StateVector(*[index(value) for value in vector])
        heard = Behaviour(index(behaviour))
    except (TypeError, ValueError):
        raise ExperienceError(
            f"{quoted(vector)} with behaviour {behaviour!r}; allowed: five integers with a behaviour, 0 to 9"
        ) from None
    presence, home, food_type, arm, food = numbers
    if presence not in (0, 1):
        raise ExperienceError(f"object_presence is {presence}; allowed: 0 or 1")
    for name, distance in (("robot_home_distance", home), ("robot_food_distance", food)):
        if not 0 <= distance <= MAX_DISTANCE:
            raise ExperienceError(f"{name} is {distance}; allowed: 0 to {MAX_DISTANCE} pixels")
    if not ARM_RAISED <= arm <= ARM_DOWN:
        raise ExperienceError(f"arms_height is {arm}; allowed: {ARM_RAISED} to {ARM_DOWN}")
    if not 0 <= food_type < len(FoodType):
        raise ExperienceError(f"food_type is {food_type}; allowed: 0 to {len(FoodType) - 1}")
    if food_type != FoodType.UNKNOWN and not presence:
        raise ExperienceError(f"food_type is {FoodType(food_type).name} without an object; allowed: UNKNOWN")
    if heard == Behaviour.WAIT:
        raise ExperienceError("behaviour is WAIT, which means silence; allowed: a behaviour, 0 to 9")
    return numbers, heard


def header_text(header: Header) -> str:
    """The lines before the rows."""
    from khepera_forage import __version__  # imported late: the package may be importing this module now

    seed = "none" if header.seed is None else header.seed
    return (
        f"{MAGIC}{VERSION}\n# package: {__version__}\n# arena: {header.arena}\n# seed: {seed}\n"
        f"# episodes: {header.episodes}\n# decisions: {header_decisions_text(header.decisions)}\n"
        f"# units: {UNITS}\n{','.join(COLUMNS)}\n"
    )


def row_text(vector: StateVector, behaviour: Behaviour) -> str:
    """The line of one row."""
    presence, home, food_type, arm, food = vector
    return f"{presence},{home},{FoodType(food_type).name},{arm},{food},{behaviour.name}\n"


def closing_line(count: int) -> str:
    """The last line of a complete file."""
    return f"# complete: {count} vectors\n"
