"""Reading experience files: each deviation from the format is an error with file, line and what is allowed."""

import re
import warnings
from os import PathLike
from pathlib import Path
from typing import NamedTuple

from khepera_forage.experience.text_format import (
    COLUMNS,
    FOOD_TYPES,
    MAGIC,
    RECORDED,
    UNITS,
    VERSION,
    ExperienceError,
    ExperienceWarning,
    Header,
    checked_header,
    checked_row,
    closing_line,
    header_decisions,
    quoted,
)
from khepera_forage.files import utf8
from khepera_forage.task.decisions import Decisions
from khepera_forage.task.states import Behaviour, FoodType, StateVector

HEADER_LINES = 7
"""Of a file without a line of decisions; others have one more."""
DECISIONS_KEY = "# decisions: "


class Contents(NamedTuple):
    """The contents of an experience file."""

    header: Header
    rows: list[tuple[StateVector, Behaviour]]


def read(path: str | PathLike[str], recover: bool) -> Contents:
    """Read a file.

    A line is complete if it has a line end; without one, the last number may lack digits.

    Args:
        path: The file.
        recover: Read the complete rows of a file without a closing line, which a killed recording leaves, with an
            `ExperienceWarning`.

    Raises:
        ExperienceError: The file is not an experience file, is incomplete, or is damaged.
        OSError: The file cannot be read.
    """
    *complete, rest = utf8(Path(path).read_bytes()).split(b"\n")
    if not (complete or rest):
        raise _error(path, 1, "not an experience file, it is empty")
    _check_first_line(path, complete[0] if complete else rest)
    lines = [_decoded(path, number, line) for number, line in enumerate(complete, 1)]
    incomplete = rest.decode(errors="replace")
    decisions: Decisions | None = Decisions.v0_1()
    header_lines = HEADER_LINES
    if len(lines) > 5 and lines[5].startswith(DECISIONS_KEY):
        decisions = _decisions(path, lines[5].removeprefix(DECISIONS_KEY))
        header_lines += 1
    header = _header(path, lines, header_lines, decisions)
    rows: list[tuple[StateVector, Behaviour]] = []
    closed = False
    for number, line in enumerate(lines[header_lines:], header_lines + 1):
        if closed:
            raise _error(path, number, f"{quoted(line)} follows the closing line; allowed: nothing")
        if line.startswith("#"):
            _check_closing_line(path, number, line, len(rows))
            closed = True
        else:
            rows.append(_row(path, number, line))
    if closed and incomplete:
        raise _error(path, len(lines) + 1, f"{quoted(incomplete)} follows the closing line; allowed: nothing")
    if not closed:
        state = f"ends before its closing line: {len(rows)} complete rows, " + (
            f"then the incomplete line {quoted(incomplete)}" if incomplete else "no incomplete line"
        )
        if not recover:
            number = len(lines) + bool(incomplete)
            raise _error(path, number, f"{state}; --recover or recover=True reads the complete rows")
        loss = "the incomplete line is lost" if incomplete else "no line is known to be lost"
        # stacklevel 3 is the caller of Experience.load.
        warnings.warn(f"{path}: {state}; rows kept, {loss}", ExperienceWarning, stacklevel=3)
    return Contents(header, rows)


def _error(path: str | PathLike[str], number: int, complaint: str) -> ExperienceError:
    return ExperienceError(f"{path}, line {number}: {complaint}")


def _check_first_line(path: str | PathLike[str], line: bytes) -> None:
    text = line.decode(errors="replace").removesuffix("\r")
    allowed = f"allowed: {MAGIC + str(VERSION)!r}"
    if not text.startswith(MAGIC):
        raise _error(path, 1, f"not an experience file, its first line is {quoted(text)}; {allowed}")
    version = text.removeprefix(MAGIC)
    if version != str(VERSION):
        later = ", written by a later version of this package" if re.fullmatch("[1-9][0-9]*", version) else ""
        raise _error(path, 1, f"the format version is {quoted(version)}{later}; {allowed}")


def _decoded(path: str | PathLike[str], number: int, line: bytes) -> str:
    try:
        return line.decode().removesuffix("\r")  # which editors on Windows add
    except UnicodeDecodeError:
        raise _error(path, number, f"{quoted(line)} is not text; allowed: UTF-8") from None


def _decisions(path: str | PathLike[str], text: str) -> Decisions | None:
    if not text:
        raise _error(
            path, 6, "decisions are ''; allowed: a version and what differs from it, or no such line"
        )
    try:
        return header_decisions(text)
    except ValueError as error:
        raise _error(path, 6, str(error)) from None


def _header(
    path: str | PathLike[str], lines: list[str], header_lines: int, decisions: Decisions | None
) -> Header:
    """Read the lines before the rows; a file without all of them has nothing to recover."""
    if len(lines) < header_lines:
        raise _error(
            path, len(lines) + 1, f"ends in the header; allowed: {header_lines} lines before the rows"
        )
    values = []
    numbers = (2, 3, 4, 5, header_lines - 1)
    for number, name in zip(numbers, ("package", "arena", "seed", "episodes", "units"), strict=True):
        key = f"# {name}: "
        line = lines[number - 1]
        if not line.startswith(key):
            raise _error(path, number, f"{quoted(line)}; allowed: {key!r} and a value")
        values.append(line.removeprefix(key))
    _, arena, seed, episodes, units = values
    if units != UNITS:
        raise _error(path, header_lines - 1, f"units are {quoted(units)}; allowed: {UNITS!r}")
    columns = lines[header_lines - 1]
    if columns != ",".join(COLUMNS):
        raise _error(path, header_lines, f"columns are {quoted(columns)}; allowed: {','.join(COLUMNS)!r}")
    seed_number = None if seed == "none" else _integer(path, 4, "seed", seed)
    episodes_number = _integer(path, 5, "episodes", episodes)
    try:
        return checked_header(arena, seed_number, episodes_number, decisions)
    except ExperienceError as error:
        raise _error(path, 3 if str(error).startswith("arena") else 5, str(error)) from None


def _row(path: str | PathLike[str], number: int, line: str) -> tuple[StateVector, Behaviour]:
    cells = line.split(",")
    if len(cells) != len(COLUMNS):
        expected = f"{len(COLUMNS)}, {','.join(COLUMNS)}"
        raise _error(path, number, f"{quoted(line)} has {len(cells)} columns; allowed: {expected}")
    presence, home, food_type, arm, food, behaviour = cells
    if food_type not in FOOD_TYPES:
        raise _error(path, number, f"food_type is {quoted(food_type)}; allowed: {', '.join(FOOD_TYPES)}")
    if behaviour not in RECORDED:
        raise _error(path, number, f"behaviour is {quoted(behaviour)}; allowed: {', '.join(RECORDED)}")
    vector = StateVector(
        _integer(path, number, "object_presence", presence),
        _integer(path, number, "robot_home_distance", home),
        FoodType[food_type],
        _integer(path, number, "arms_height", arm),
        _integer(path, number, "robot_food_distance", food),
    )
    try:
        return checked_row(vector, Behaviour[behaviour])
    except ExperienceError as error:
        raise _error(path, number, str(error)) from None


def _integer(path: str | PathLike[str], number: int, name: str, text: str) -> int:
    # Only ASCII digits: int() also accepts '1_0', ' 1' and Arabic digits, and refuses thousands of digits.
    if not re.fullmatch("-?[0-9]{1,100}", text):
        raise _error(path, number, f"{name} is {quoted(text)}; allowed: an integer")
    return int(text)


def _check_closing_line(path: str | PathLike[str], number: int, line: str, rows: int) -> None:
    if not re.fullmatch("# complete: [0-9]{1,18} vectors", line):
        allowed = closing_line(rows).strip()
        raise _error(path, number, f"{quoted(line)}; allowed: a row, or the closing line {allowed!r}")
    if line != closing_line(rows).strip():
        raise _error(path, number, f"{quoted(line)} after {rows} rows; allowed: the number of rows above it")
