"""The text format of experience files: what a row may be, how a file is written, how it is read.

    # khepera_forage experience, version 1
    # package: 0.1.0
    # arena: corridor
    # seed: 7
    # episodes: 1
    # units: distances in pixels of 5 mm; arms_height 255 (down) to 215 (raised)
    object_presence,robot_home_distance,food_type,arms_height,robot_food_distance,behaviour
    0,52,UNKNOWN,215,28,SEARCH_FOR_FOOD
    # complete: 1 vectors

The closing line tells a finished recording from one that was killed. Reading is strict: whatever differs from what
is written here is an error that names file, line and what is allowed.
"""

import re
import warnings
from collections.abc import Sequence
from operator import index
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple

from khepera_forage.foraging.states import Behaviour, FoodType, StateVector
from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED

VERSION = 1
MAGIC = "# khepera_forage experience, version "
UNITS = f"distances in pixels of 5 mm; arms_height {ARM_DOWN} (down) to {ARM_RAISED} (raised)"
COLUMNS = (*StateVector._fields, "behaviour")
MAX_DISTANCE = 2**31 - 1
"""Pixels: no arena is that large, and every table can hold it."""

RECORDED = [behaviour.name for behaviour in Behaviour if behaviour != Behaviour.WAIT]
FOOD_TYPES = [food_type.name for food_type in FoodType]


class ExperienceError(ValueError):
    """Something is not an experience vector, or not an experience file."""


class ExperienceWarning(UserWarning):
    """An experience file was not complete, and what could be kept of it was."""


class Header(NamedTuple):
    """What a file says before its rows.

    Attributes:
        arena: Name of the arena that the experience was made in.
        seed: Of the training, if known.
        episodes: How many training episodes the experience is of.
    """

    arena: str
    seed: int | None
    episodes: int


class Contents(NamedTuple):
    """What a file holds."""

    header: Header
    rows: list[tuple[StateVector, Behaviour]]


def checked_header(arena: str, seed: int | None, episodes: int) -> Header:
    """The header, once its values are found to be such as can be written and read again.

    Raises:
        ExperienceError: A value that cannot be.
    """
    if not arena or arena != arena.strip() or not arena.isprintable():
        raise ExperienceError(
            f"arena is {arena!r}; allowed: a printable name on one line, no space around it"
        )
    try:
        header = Header(arena, None if seed is None else index(seed), index(episodes))
    except TypeError:
        raise ExperienceError(f"seed is {seed!r}, episodes {episodes!r}; allowed: integers") from None
    if header.episodes < 1:
        raise ExperienceError(f"episodes is {episodes!r}; allowed: at least 1")
    return header


def checked_row(vector: Sequence[Any], behaviour: Any) -> tuple[StateVector, Behaviour]:
    """An experience vector in plain integers, once it is found to be one that a learner can have recorded.

    Raises:
        ExperienceError: It is not.
    """
    try:
        numbers = StateVector(*[index(value) for value in vector])
        heard = Behaviour(index(behaviour))
    except (TypeError, ValueError):
        raise ExperienceError(
            f"{_quoted(vector)} with behaviour {behaviour!r}; allowed: five integers with a behaviour, 0 to 9"
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
        raise ExperienceError("behaviour is WAIT, which is silence; allowed: what was heard, 0 to 9")
    return numbers, heard


def opening(header: Header) -> str:
    """All lines before the rows."""
    from khepera_forage import __version__  # late: the package may be importing this module just now

    seed = "none" if header.seed is None else header.seed
    return (
        f"{MAGIC}{VERSION}\n# package: {__version__}\n# arena: {header.arena}\n# seed: {seed}\n"
        f"# episodes: {header.episodes}\n# units: {UNITS}\n{','.join(COLUMNS)}\n"
    )


def line_of(vector: StateVector, behaviour: Behaviour) -> str:
    """One row."""
    presence, home, food_type, arm, food = vector
    return f"{presence},{home},{FoodType(food_type).name},{arm},{food},{behaviour.name}\n"


def closing(count: int) -> str:
    """The line that says that nothing is missing."""
    return f"# complete: {count} vectors\n"


def read(path: str | PathLike[str], recover: bool) -> Contents:
    """Read a file.

    Args:
        path: Of the file.
        recover: Keep the whole rows of a file without closing line, as a killed recording leaves it, with a warning.

    Raises:
        ExperienceError: It is not an experience file, or not a complete one.
        OSError: It cannot be read.
    """
    *lines, cut = Path(path).read_bytes().split(b"\n")
    header = _read_header(path, lines, cut)
    rows: list[tuple[StateVector, Behaviour]] = []
    closed = False
    for number, line in enumerate(lines[7:], 8):
        text = _text(path, number, line)
        if closed:
            raise _error(path, number, f"{_quoted(text)} after the closing line; allowed: nothing")
        if text.startswith("#"):
            _check_closing(path, number, text, len(rows))
            closed = True
        else:
            try:
                rows.append(_row(text))
            except ExperienceError as error:
                raise _error(path, number, str(error)) from None
    remainder = _quoted(cut.decode(errors="replace"))
    if closed and cut:
        raise _error(path, len(lines) + 1, f"{remainder} after the closing line; allowed: nothing")
    if not closed:
        state = f"no closing line, the recording was cut off: {len(rows)} whole rows, " + (
            f"and the cut last line {remainder}" if cut else "and no cut line"
        )
        if not recover:
            raise _error(path, len(lines) + bool(cut), f"{state}; recover=True keeps the whole rows")
        lost = "lost is the cut line" if cut else "lost is nothing that can be seen"
        warnings.warn(f"{path}: {state}; {lost}", ExperienceWarning, stacklevel=3)
    return Contents(header, rows)


def _read_header(path: str | PathLike[str], lines: list[bytes], cut: bytes) -> Header:
    first = lines[0] if lines else cut
    allowed = f"allowed: {MAGIC + str(VERSION)!r}"
    if not first.startswith(MAGIC.encode()):
        what = _quoted(first.decode(errors="replace")) if first else "empty"
        raise _error(path, 1, f"not an experience file, its first line is {what}; {allowed}")
    if len(lines) < 7:
        raise _error(path, len(lines) + 1, "the file ends within its header: there is nothing in it to keep")
    texts = [_text(path, number, line) for number, line in enumerate(lines[:7], 1)]
    version = texts[0].removeprefix(MAGIC)
    if version != str(VERSION):
        later = re.fullmatch("[1-9][0-9]*", version)
        hint = ", a later version of the package wrote it" if later else ""
        raise _error(path, 1, f"format version is {_quoted(version)}{hint}; {allowed}")
    values = []
    for number, name in enumerate(("package", "arena", "seed", "episodes", "units"), 2):
        start = f"# {name}: "
        if not texts[number - 1].startswith(start):
            raise _error(path, number, f"{_quoted(texts[number - 1])}; allowed: {start!r} and its value")
        values.append(texts[number - 1].removeprefix(start))
    _, arena, seed, episodes, units = values
    if units != UNITS:
        raise _error(path, 6, f"units are {_quoted(units)}; allowed: {UNITS!r}")
    if texts[6] != ",".join(COLUMNS):
        raise _error(path, 7, f"columns are {_quoted(texts[6])}; allowed: {','.join(COLUMNS)!r}")
    try:
        return checked_header(
            arena, None if seed == "none" else _integer("seed", seed), _integer("episodes", episodes)
        )
    except ExperienceError as error:
        raise _error(path, 3, str(error)) from None


def _row(text: str) -> tuple[StateVector, Behaviour]:
    cells = text.split(",")
    if len(cells) != len(COLUMNS):
        raise ExperienceError(f"{_quoted(text)} has {len(cells)} columns; allowed: {len(COLUMNS)}, {COLUMNS}")
    presence, home, food_type, arm, food, behaviour = cells
    if food_type not in FOOD_TYPES:
        raise ExperienceError(f"food_type is {_quoted(food_type)}; allowed: {', '.join(FOOD_TYPES)}")
    if behaviour not in RECORDED:
        raise ExperienceError(f"behaviour is {_quoted(behaviour)}; allowed: {', '.join(RECORDED)}")
    presence_, home_ = _integer("object_presence", presence), _integer("robot_home_distance", home)
    arm_, food_ = _integer("arms_height", arm), _integer("robot_food_distance", food)
    return checked_row((presence_, home_, FoodType[food_type], arm_, food_), Behaviour[behaviour])


def _check_closing(path: str | PathLike[str], number: int, text: str, count: int) -> None:
    match = re.fullmatch("# complete: ([0-9]+) vectors", text)
    if match is None:
        raise _error(
            path, number, f"{_quoted(text)}; allowed: a row, or the closing line '# complete: N vectors'"
        )
    if int(match[1]) != count:
        raise _error(path, number, f"{_quoted(text)} after {count} rows; allowed: as many as there are")


def _integer(name: str, text: str) -> int:
    if re.fullmatch("0|-?[1-9][0-9]*", text) is None or len(text) > 20:
        raise ExperienceError(f"{name} is {_quoted(text)}; allowed: a whole number")
    return int(text)


def _text(path: str | PathLike[str], number: int, line: bytes) -> str:
    try:
        return line.decode("utf-8")
    except UnicodeDecodeError:
        raise _error(path, number, f"{_quoted(line.decode(errors='replace'))}; allowed: UTF-8 text") from None


def _quoted(value: object) -> str:
    """Something as it stands in a message, at a length that can be read."""
    text = repr(value)
    return text if len(text) <= 80 else f"{text[:60]}... ({len(text)} characters)"


def _error(path: str | PathLike[str], number: int, message: str) -> ExperienceError:
    return ExperienceError(f"{path}:{number}: {message}")
