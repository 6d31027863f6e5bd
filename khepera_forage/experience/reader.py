"""Reading experience files, strictly: what differs from the format is an error with file, line and what is allowed."""

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
    closing,
    quoted,
)
from khepera_forage.task.states import Behaviour, FoodType, StateVector

HEADER_LINES = 7


class Contents(NamedTuple):
    """What a file holds."""

    header: Header
    rows: list[tuple[StateVector, Behaviour]]


def read(path: str | PathLike[str], recover: bool) -> Contents:
    """Read a file.

    A line counts as whole if it has its line end: a number may lack digits that a kill cut off.

    Args:
        path: Of the file.
        recover: Keep the whole rows of a file without closing line, as a killed recording leaves it, with an
            `ExperienceWarning`.

    Raises:
        ExperienceError: It is not an experience file, or it is not complete, or not sound.
        OSError: It cannot be read.
    """
    *whole, rest = Path(path).read_bytes().split(b"\n")
    if not (whole or rest):
        raise _error(path, 1, "not an experience file, it is empty")
    _check_first_line(path, whole[0] if whole else rest)
    lines = [_decoded(path, number, line) for number, line in enumerate(whole, 1)]
    cut = rest.decode(errors="replace")
    header = _header(path, lines)
    rows: list[tuple[StateVector, Behaviour]] = []
    closed = False
    for number, line in enumerate(lines[HEADER_LINES:], HEADER_LINES + 1):
        if closed:
            raise _error(path, number, f"{quoted(line)} stands after the closing line; allowed: nothing")
        if line.startswith("#"):
            closed = _closes(path, number, line, len(rows))
        else:
            rows.append(_row(path, number, line))
    if closed and cut:
        raise _error(path, len(lines) + 1, f"{quoted(cut)} stands after the closing line; allowed: nothing")
    if not closed:
        state = f"cut off before its closing line: {len(rows)} whole rows, " + (
            f"then the cut line {quoted(cut)}" if cut else "no cut line"
        )
        if not recover:
            number = len(lines) + bool(cut)
            raise _error(path, number, f"{state}; recover=True keeps the whole rows")
        loss = "the cut line is lost" if cut else "no line is known to be lost"
        # 3: where Experience.load was called.
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
        return line.decode().removesuffix("\r")  # an editor on Windows may have put it there
    except UnicodeDecodeError:
        raise _error(path, number, f"{quoted(line)} is not text; allowed: UTF-8") from None


def _header(path: str | PathLike[str], lines: list[str]) -> Header:
    """The lines before the rows. Where they are not all there, there is nothing to recover."""
    if len(lines) < HEADER_LINES:
        raise _error(
            path, len(lines) + 1, f"cut off in the header; allowed: {HEADER_LINES} lines before the rows"
        )
    values = []
    for number, name in enumerate(("package", "arena", "seed", "episodes", "units"), 2):
        key = f"# {name}: "
        line = lines[number - 1]
        if not line.startswith(key):
            raise _error(path, number, f"{quoted(line)}; allowed: {key!r} and a value")
        values.append(line.removeprefix(key))
    _, arena, seed, episodes, units = values
    if units != UNITS:
        raise _error(path, 6, f"units are {quoted(units)}; allowed: {UNITS!r}")
    if lines[6] != ",".join(COLUMNS):
        raise _error(path, 7, f"columns are {quoted(lines[6])}; allowed: {','.join(COLUMNS)!r}")
    seed_number = None if seed == "none" else _integer(path, 4, "seed", seed)
    episodes_number = _integer(path, 5, "episodes", episodes)
    try:
        return checked_header(arena, seed_number, episodes_number)
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
    # ASCII digits alone: int() would also take '1_0', ' 1' and Arabic digits, and choke on thousands of them.
    if not re.fullmatch("-?[0-9]{1,100}", text):
        raise _error(path, number, f"{name} is {quoted(text)}; allowed: an integer")
    return int(text)


def _closes(path: str | PathLike[str], number: int, line: str, rows: int) -> bool:
    if not re.fullmatch("# complete: [0-9]{1,18} vectors", line):
        allowed = closing(rows).strip()
        raise _error(path, number, f"{quoted(line)}; allowed: a row, or the closing line {allowed!r}")
    if line != closing(rows).strip():
        raise _error(path, number, f"{quoted(line)} after {rows} rows; allowed: the number of rows above it")
    return True
