"""Strict reading of TOML: errors name the key, and unknown keys are errors."""

import re
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from decimal import Decimal
from difflib import get_close_matches
from pathlib import Path
from typing import Any, TypeVar

from khepera_forage.files import utf8

T = TypeVar("T")
_MISSING: Any = object()


class TableError(ValueError):
    """A key that is missing, unknown, or has an invalid value; the message names the key and the allowed values."""


class Table:
    """One table of a TOML file.

    Args:
        content: The table as returned by `tomllib`.
        name: Name of the table, such as `robots[1]`; empty for the file itself.

    Raises:
        TableError: `content` is not a table.
    """

    def __init__(self, content: Any, name: str = "") -> None:
        if not isinstance(content, Mapping):
            raise TableError(f"{name} is {quoted(content)}; allowed: a table of keys and values")
        self._content = content
        self.name = name

    def check_keys(self, allowed: Iterable[str]) -> None:
        """Reject other keys. Comes before any `take`: a key with a typing error is not reported as missing.

        Raises:
            TableError: An unknown key.
        """
        known = sorted(allowed)
        for key in self._content:
            if key not in known:
                similar = "".join(f" (did you mean {name}?)" for name in get_close_matches(key, known, n=1))
                raise TableError(f"{self.key(key)} is unknown{similar}; allowed: {', '.join(known)}")

    def has(self, key: str) -> bool:
        """Whether the table has a key."""
        return key in self._content

    def key(self, key: str) -> str:
        """The full name of a key, with the table's name."""
        return f"{self.name}.{key}" if self.name else key

    def take(self, key: str, read: Callable[[str, Any], T], default: T = _MISSING) -> T:
        """The value of a key.

        Args:
            key: Name of the key within this table.
            read: Called with the full name of the key and its value; checks and converts the value.
            default: Value of a missing key.

        Raises:
            TableError: The key is missing and has no default, or `read` rejects the value.
        """
        if key not in self._content:
            if default is _MISSING:
                raise TableError(f"{self.key(key)} is missing")
            return default
        return read(self.key(key), self._content[key])

    def table(self, key: str) -> "Table":
        """The table under a key; an empty one if the key is missing.

        Raises:
            TableError: The value is not a table.
        """
        return self.take(key, lambda name, value: Table(value, name), Table({}, self.key(key)))

    def tables(self, key: str) -> list["Table"]:
        """The tables of an array such as `[[robots]]`; none if the key is missing.

        Raises:
            TableError: The value is not an array of tables.
        """

        def read(name: str, value: Any) -> list[Table]:
            if not isinstance(value, list):
                raise TableError(f"{name} is {quoted(value)}; allowed: one or more tables [[{name}]]")
            return [Table(item, f"{name}[{i}]") for i, item in enumerate(value)]

        return self.take(key, read, [])


def table_of(toml: str, parse_float: Callable[[str], Any] = float) -> Table:
    """The table of a whole text.

    Args:
        toml: The text.
        parse_float: Makes the value of a number that is not whole; `Decimal` keeps all its digits.

    Raises:
        TableError: The text is not TOML; the message has the line.
    """
    try:
        return Table(tomllib.loads(toml, parse_float=parse_float))
    except tomllib.TOMLDecodeError as error:
        raise TableError(f"not TOML: {error}") from None


def text_of(path: Path) -> str:
    """The text of a file.

    Raises:
        TableError: It is not UTF-8.
        OSError: The file cannot be read.
    """
    try:
        return utf8(path.read_bytes()).decode()
    except UnicodeDecodeError as error:
        raise TableError(f"not UTF-8 text: {error}") from None


def quoted(value: object) -> str:
    """A value as shown in an error message, at most 60 characters."""
    text = re.sub(r"Decimal\('([^']*)'\)", r"\1", repr(value))
    return text if len(text) <= 60 else text[:57] + "..."


def text(key: str, value: Any) -> str:
    """Read a string that is not empty."""
    if not isinstance(value, str) or not value.strip():
        raise TableError(f"{key} is {quoted(value)}; allowed: a text that is not empty")
    return value


def number(low: float, high: float, unit: str) -> Callable[[str, Any], float]:
    """A reader of numbers from `low` to `high`."""

    def read(key: str, value: Any) -> float:
        if not _is_number(value) or not low <= float(value) <= high:
            raise TableError(f"{key} is {quoted(value)}; allowed: {low:g} to {high:g} {unit}")
        return float(value)

    return read


def true_or_false(key: str, value: Any) -> bool:
    """Read a truth value."""
    if not isinstance(value, bool):
        raise TableError(f"{key} is {quoted(value)}; allowed: true, false")
    return value


def one_of(allowed: Sequence[int]) -> Callable[[str, Any], int]:
    """A reader of one of the allowed whole numbers."""

    def read(key: str, value: Any) -> int:
        if type(value) is not int or value not in allowed:
            raise TableError(f"{key} is {quoted(value)}; allowed: {', '.join(map(str, allowed))}")
        return value

    return read


def numbers(form: str) -> Callable[[str, Any], tuple[float, ...]]:
    """A reader of lists of finite numbers, as many as `form` names, such as `[x mm, y mm]`."""
    count = form.count(",") + 1

    def read(key: str, value: Any) -> tuple[float, ...]:
        if (
            not isinstance(value, list)
            or len(value) != count
            or not all(_is_number(v) and abs(float(v)) < 1e9 for v in value)
        ):
            raise TableError(f"{key} is {quoted(value)}; allowed: {form}")
        return tuple(float(v) for v in value)

    return read


def list_of(read_one: Callable[[str, Any], T], least: int = 1) -> Callable[[str, Any], tuple[T, ...]]:
    """A reader of lists of at least `least` items; `read_one` reads each item."""
    allowed = (
        "a list that is not empty" if least == 1 else f"a list of at least {least}" if least else "a list"
    )

    def read(key: str, value: Any) -> tuple[T, ...]:
        if not isinstance(value, list) or len(value) < least:
            raise TableError(f"{key} is {quoted(value)}; allowed: {allowed}")
        return tuple(read_one(f"{key}[{i}]", item) for i, item in enumerate(value))

    return read


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float | Decimal) and not isinstance(value, bool)
