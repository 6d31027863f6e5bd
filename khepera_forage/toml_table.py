"""Strict reading of TOML: errors name the file, the key, the value and what is allowed; unknown keys are errors.

A reader is a function of a key's full name, such as `robots[1].port`, and its value. It returns the checked value.
"""

import re
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from decimal import Decimal
from difflib import get_close_matches
from pathlib import Path
from typing import Any, TypeVar

from khepera_forage.files import utf8

T = TypeVar("T")
Reader = Callable[[str, Any], Any]


def content_of(toml: str, parse_float: Callable[[str], Any] = float) -> dict[str, Any]:
    """The content of a text, or a ValueError with the line; `Decimal` as `parse_float` keeps all digits."""
    try:
        return tomllib.loads(toml, parse_float=parse_float)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise ValueError(f"not TOML: {error}") from None


def text_of(path: Path) -> str:
    """The text of a file; a ValueError if it is not UTF-8."""
    try:
        return utf8(path.read_bytes()).decode()
    except UnicodeDecodeError as error:
        raise ValueError(f"not UTF-8 text: {error}") from None


@contextmanager
def naming(path: Path | str) -> Iterator[None]:
    """A block whose ValueErrors name a file."""
    try:
        yield
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None


def table(key: str, value: Any, readers: Mapping[str, Reader], required: Sequence[str] = ()) -> dict[str, Any]:
    """The checked values of the keys that a table has.

    Args:
        key: Full name of the table; empty for the file itself.
        value: The table.
        readers: Of all keys that are allowed.
        required: Keys that must be there.

    Raises:
        ValueError: An unknown key, which comes first, or one that is missing or rejected by its reader.
    """
    if not isinstance(value, Mapping):
        raise refusal(key, value, "a table of keys and values")
    prefix = f"{key}." if key else ""
    for name in value:
        if name not in readers:
            similar = "".join(f" (did you mean {known}?)" for known in get_close_matches(name, readers, n=1))
            raise ValueError(f"{prefix}{name} is unknown{similar}; allowed: {', '.join(sorted(readers))}")
    for name in required:
        if name not in value:
            raise ValueError(f"{prefix}{name} is missing")
    return {name: read(f"{prefix}{name}", value[name]) for name, read in readers.items() if name in value}


def refusal(key: str, value: object, allowed: str) -> ValueError:
    """The error for a value, of which at most 60 characters are quoted."""
    text = re.sub(r"Decimal\('([^']*)'\)", r"\1", repr(value))
    return ValueError(f"{key} is {text if len(text) <= 60 else text[:57] + '...'}; allowed: {allowed}")


def anything(key: str, value: Any) -> Any:
    """Read a value that is checked later."""
    return value


def text(key: str, value: Any) -> str:
    """Read a string that is not empty."""
    if not isinstance(value, str) or not value.strip():
        raise refusal(key, value, "a text that is not empty")
    return value


def number(low: float, high: float, unit: str) -> Callable[[str, Any], float]:
    """A reader of numbers from `low` to `high`."""

    def read(key: str, value: Any) -> float:
        if not is_number(value) or not low <= float(value) <= high:
            raise refusal(key, value, f"{low:g} to {high:g} {unit}")
        return float(value)

    return read


def true_or_false(key: str, value: Any) -> bool:
    """Read a truth value."""
    if not isinstance(value, bool):
        raise refusal(key, value, "true, false")
    return value


def one_of(allowed: Sequence[T]) -> Callable[[str, Any], T]:
    """A reader of one of some whole numbers or texts."""

    def read(key: str, value: Any) -> T:
        if type(value) is not type(allowed[0]) or value not in allowed:
            raise refusal(key, value, ", ".join(map(str, allowed)))
        return value

    return read


def numbers(form: str) -> Callable[[str, Any], tuple[float, ...]]:
    """A reader of lists of finite numbers, as many as `form` names, such as `[x mm, y mm]`."""
    count = form.count(",") + 1

    def read(key: str, value: Any) -> tuple[float, ...]:
        is_list = isinstance(value, list) and len(value) == count
        if not is_list or not all(is_number(v) and abs(float(v)) < 1e9 for v in value):
            raise refusal(key, value, form)
        return tuple(map(float, value))

    return read


def list_of(
    read_one: Callable[[str, Any], T], least: int = 1, allowed: str = ""
) -> Callable[[str, Any], tuple[T, ...]]:
    """A reader of lists of at least `least` items, 0 or 1; `read_one` reads each item."""
    allowed = allowed or ("a list that is not empty" if least else "a list")

    def read(key: str, value: Any) -> tuple[T, ...]:
        if not isinstance(value, list) or len(value) < least:
            raise refusal(key, value, allowed)
        return tuple(read_one(f"{key}[{i}]", item) for i, item in enumerate(value))

    return read


def is_number(value: Any) -> bool:
    """Whether a value is a number; a truth value is none."""
    return isinstance(value, int | float | Decimal) and not isinstance(value, bool)
