"""Experience files: their text format, strict reading, and writing while the experience is recorded.

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

import os
import re
import warnings
from collections.abc import Sequence
from operator import index
from os import PathLike
from pathlib import Path
from typing import Any, NamedTuple, Self

from khepera_forage.files import utf8, write_all
from khepera_forage.robots.khepera import ARM_DOWN, ARM_RAISED
from khepera_forage.task.decisions import DEFAULT_DECISIONS, Decisions, decisions_from_text, decisions_text
from khepera_forage.task.states import Behaviour, FoodType, StateVector

VERSION = 1
MAGIC = "# khepera_forage experience, version "
UNITS = f"distances in pixels of 5 mm; arms_height {ARM_DOWN} (down) to {ARM_RAISED} (raised)"
COLUMNS = (*StateVector._fields, "behaviour")
MAX_DISTANCE = 2**31 - 1
"""Pixels: more than in any arena, and the largest number of a 32-bit integer."""
MIXED = "mixed"
"""Text of the decisions of joined experience that was recorded under different ones."""

NAMES = {
    "food_type": [food_type.name for food_type in FoodType],
    "behaviour": [behaviour.name for behaviour in Behaviour if behaviour != Behaviour.WAIT],
}
"""The words of the columns that are no numbers, in the order of what they stand for."""


class ExperienceError(ValueError):
    """A value or a file is not valid experience."""


class ExperienceWarning(UserWarning):
    """An experience file is incomplete; its complete rows were read."""


def quoted(thing: object) -> str:
    """A value for an error message: its `repr`, shortened to 80 characters."""
    text = repr(thing)
    return text if len(text) <= 80 else text[:77] + "..."


class Header(NamedTuple):
    """The header of an experience file; the values are those of `Experience`."""

    arena: str
    seed: int | None
    episodes: int
    decisions: Decisions | None


def checked_header(arena: str, seed: int | None, episodes: int, decisions: Decisions | None) -> Header:
    """Check the values of a header, and return it; an `ExperienceError` for one that cannot be written."""
    if not arena or arena != arena.strip() or not arena.isprintable():
        raise ExperienceError(f"arena is {arena!r}; allowed: a printable name on one line, no space around it")
    try:
        header = Header(arena, None if seed is None else index(seed), index(episodes), decisions)
    except TypeError:
        raise ExperienceError(f"seed is {seed!r}, episodes {episodes!r}; allowed: integers") from None
    if header.seed is not None and abs(header.seed) >= 10**100:
        raise ExperienceError("seed has more than 100 digits; allowed: at most 100")
    if header.episodes < 1:
        raise ExperienceError(f"episodes is {episodes!r}; allowed: at least 1")
    if not (decisions is None or isinstance(decisions, Decisions)):
        raise ExperienceError(f"decisions is {decisions!r}; allowed: a khepera_forage.Decisions, or None if mixed")
    return header


def header_decisions_text(decisions: Decisions | None) -> str:
    """Decisions as a header stores them."""
    return MIXED if decisions is None else decisions_text(decisions)


def header_decisions(text: str) -> Decisions | None:
    """The decisions that a text of `header_decisions_text` describes; a ValueError for another text."""
    if not text:
        raise ValueError("decisions are ''; allowed: a version and what differs from it, or no such line")
    return None if text == MIXED else decisions_from_text(text)


def checked_row(vector: Sequence[Any], behaviour: Any) -> tuple[StateVector, Behaviour]:
    """A row as plain integers; an `ExperienceError` if no learner can have recorded it."""
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


def closing_line(count: int) -> str:
    """The last line of a complete file."""
    return f"# complete: {count} vectors\n"


def read(path: str | PathLike[str], recover: bool) -> tuple[Header, list[tuple[StateVector, Behaviour]]]:
    """Read a file.

    Args:
        path: The file.
        recover: Read the complete rows of a file without a closing line, which a killed recording leaves, with an
            `ExperienceWarning`.

    Raises:
        ExperienceError: The file is not an experience file, is incomplete, or is damaged; with the line.
        OSError: The file cannot be read.
    """
    lines = _Lines(Path(path).read_bytes())
    try:
        header = _header(lines)
        rows: list[tuple[StateVector, Behaviour]] = []
        while (line := lines.next()) is not None and not line.startswith("#"):
            rows.append(_row(line))
        if line is not None:
            _check_closing_line(line, len(rows))
            after = lines.next()
            if after is None and lines.rest:
                after, lines.number = lines.rest, lines.number + 1
            if after is not None:
                raise ExperienceError(f"{quoted(after)} follows the closing line; allowed: nothing")
            return header, rows
        end = f"then the incomplete line {quoted(lines.rest)}" if lines.rest else "no incomplete line"
        state = f"ends before its closing line: {len(rows)} complete rows, {end}"
        if not recover:
            lines.number += bool(lines.rest)
            raise ExperienceError(f"{state}; --recover or recover=True reads the complete rows")
    except ValueError as error:
        raise ExperienceError(f"{path}, line {lines.number}: {error}") from None
    loss = "the incomplete line is lost" if lines.rest else "no line is known to be lost"
    # stacklevel 4 is the caller of Experience.load.
    warnings.warn(f"{path}: {state}; rows kept, {loss}", ExperienceWarning, stacklevel=4)
    return header, rows


class _Lines:
    """The lines of a file. One without a line end is not complete: its last number may lack digits."""

    def __init__(self, data: bytes) -> None:
        *self._complete, rest = utf8(data).split(b"\n")
        self.rest = rest.decode(errors="replace")
        self.number = 0
        self.are_decided = any(line.startswith(b"# decisions: ") for line in self._complete[5:6])

    def next(self) -> str | None:
        """The next complete line; None at the end."""
        if self.number >= len(self._complete):
            return None
        line = self._complete[self.number]
        self.number += 1
        try:
            return line.decode().removesuffix("\r")  # which editors on Windows add
        except UnicodeDecodeError:
            raise ExperienceError(f"{quoted(line)} is not text; allowed: UTF-8") from None

    def first(self) -> str:
        """The first line, complete or not, text or not."""
        self.number = 1
        return self._complete[0].decode(errors="replace").removesuffix("\r") if self._complete else self.rest

    def of_header(self, name: str) -> str:
        """The value of the next line, `# name: value`; a file without all of them has nothing to recover."""
        line, key = self.next(), f"# {name}: " if name else ""
        if line is None:
            self.number = len(self._complete) + 1
            raise ExperienceError(f"ends in the header; allowed: {7 + self.are_decided} lines before the rows")
        if not line.startswith(key):
            raise ExperienceError(f"{quoted(line)}; allowed: {key!r} and a value")
        return line.removeprefix(key)


def _header(lines: _Lines) -> Header:
    first = lines.first()
    allowed = f"allowed: {MAGIC + str(VERSION)!r}"
    if not first:
        raise ExperienceError("not an experience file, it is empty")
    if not first.startswith(MAGIC):
        raise ExperienceError(f"not an experience file, its first line is {quoted(first)}; {allowed}")
    version = first.removeprefix(MAGIC)
    if version != str(VERSION):
        later = ", written by a later version of this package" if re.fullmatch("[1-9][0-9]*", version) else ""
        raise ExperienceError(f"the format version is {quoted(version)}{later}; {allowed}")
    lines.of_header("package")
    arena = lines.of_header("arena")
    checked_header(arena, None, 1, None)
    seed_text = lines.of_header("seed")
    seed = None if seed_text == "none" else _number("seed", seed_text)
    header = checked_header(arena, seed, _number("episodes", lines.of_header("episodes")), Decisions.v0_1())
    if lines.are_decided:
        header = header._replace(decisions=header_decisions(lines.of_header("decisions")))
    if (units := lines.of_header("units")) != UNITS:
        raise ExperienceError(f"units are {quoted(units)}; allowed: {UNITS!r}")
    if (columns := lines.of_header("")) != ",".join(COLUMNS):
        raise ExperienceError(f"columns are {quoted(columns)}; allowed: {','.join(COLUMNS)!r}")
    return header


def _row(line: str) -> tuple[StateVector, Behaviour]:
    cells = line.split(",")
    if len(cells) != len(COLUMNS):
        expected = f"{len(COLUMNS)}, {','.join(COLUMNS)}"
        raise ExperienceError(f"{quoted(line)} has {len(cells)} columns; allowed: {expected}")
    *vector, behaviour = map(_number, COLUMNS, cells)
    return checked_row(vector, behaviour)


def _number(name: str, text: str) -> int:
    if name in NAMES:
        if text not in NAMES[name]:
            raise ExperienceError(f"{name} is {quoted(text)}; allowed: {', '.join(NAMES[name])}")
        return NAMES[name].index(text)
    # Only ASCII digits: int() also accepts '1_0', ' 1' and Arabic digits, and refuses thousands of digits.
    if not re.fullmatch("-?[0-9]{1,100}", text):
        raise ExperienceError(f"{name} is {quoted(text)}; allowed: an integer")
    return int(text)


def _check_closing_line(line: str, rows: int) -> None:
    expected = closing_line(rows).strip()
    if not re.fullmatch("# complete: [0-9]{1,18} vectors", line):
        raise ExperienceError(f"{quoted(line)}; allowed: a row, or the closing line {expected!r}")
    if line != expected:
        raise ExperienceError(f"{quoted(line)} after {rows} rows; allowed: the number of rows above it")


class ExperienceWriter:
    """Writes an experience file, vector by vector.

    `append` passes each vector to the operating system before it returns, so that a killed process loses at most an
    incomplete last line. `close` writes the closing line of a complete file. As a context manager the writer closes the
    file at the end of the block; after an exception the file has no closing line, and only
    `Experience.load(..., recover=True)` reads it.

    Args:
        path: The file.
        arena, seed, episodes, decisions: As of `Experience`.
        overwrite: Replace an existing file. By default an existing file is an error.

    Attributes:
        path: The file.
        count: Number of experience vectors written so far.

    Raises:
        FileExistsError: There is a file at `path`.
        ExperienceError: A value cannot be written.
    """

    def __init__(
        self,
        path: str | PathLike[str],
        arena: str,
        seed: int | None = None,
        episodes: int = 1,
        *,
        decisions: Decisions | None = DEFAULT_DECISIONS,
        overwrite: bool = False,
    ) -> None:
        header = checked_header(arena, seed, episodes, decisions)
        self.path = Path(path)
        self.count = 0
        try:
            # Without a buffer, whose rest `close` would write a second time after an error.
            self._file = open(path, "wb" if overwrite else "xb", buffering=0)  # noqa: SIM115 - closed by close()
        except FileExistsError:
            raise FileExistsError(f"{path} exists; overwrite=True replaces it") from None
        try:
            self._write(header_text(header))
        except OSError:
            self._file.close()
            if not overwrite:  # without a header, it would prevent the next recording at this path
                self.path.unlink(missing_ok=True)
            raise

    def append(self, vector: Sequence[int], behaviour: int) -> None:
        """Write a state vector and the behaviour heard with it, never WAIT: nothing is recorded in silence.

        Raises:
            ExperienceError: A value is out of range, or the writer is closed. Nothing is written then.
        """
        if self._file.closed:
            raise ExperienceError(f"{self.path} is closed; allowed: append before close")
        (presence, home, food_type, arm, food), heard = checked_row(vector, behaviour)
        self._write(f"{presence},{home},{FoodType(food_type).name},{arm},{food},{heard.name}\n")
        self.count += 1

    def close(self, complete: bool = True) -> None:
        """Close the file, with its closing line if it is `complete`; a second call does nothing."""
        if self._file.closed:
            return
        with self._file:
            if complete:
                self._write(closing_line(self.count))
                os.fsync(self._file.fileno())

    def _write(self, text: str) -> None:
        write_all(self._file, text.encode(), self.path)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self.close(complete=kind is None)
