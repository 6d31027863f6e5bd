"""Strict reading of TOML: every mistake is named by its key, and a key that nobody asks for is one."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeVar

T = TypeVar("T")
_MISSING: Any = object()


class TableError(ValueError):
    """A key that is missing, unknown, or has a value that is not allowed; the message says which and what is."""


class Table:
    """One table of a TOML file, from which every key is taken once.

    Args:
        content: The table as `tomllib` gives it.
        name: Where it stands, such as `robots[1]`; empty for the file itself.

    Raises:
        TableError: `content` is not a table.
    """

    def __init__(self, content: Any, name: str = "") -> None:
        if not isinstance(content, Mapping):
            raise TableError(f"{name} is {quoted(content)}; allowed: a table of keys and values")
        self._content = dict(content)
        self._name = name
        self._asked: list[str] = []

    def key(self, key: str) -> str:
        """A key with the names of the tables around it."""
        return f"{self._name}.{key}" if self._name else key

    def take(self, key: str, read: Callable[[str, Any], T], default: T = _MISSING) -> T:
        """The value of a key.

        Args:
            key: Within this table.
            read: Checks the value; gets the whole key, for its message, and what the file says.
            default: For a key that is not there.

        Raises:
            TableError: There is no such key and no default, or `read` does not allow the value.
        """
        self._asked.append(key)
        if key not in self._content:
            if default is _MISSING:
                raise TableError(f"{self.key(key)} is missing")
            return default
        return read(self.key(key), self._content.pop(key))

    def table(self, key: str) -> "Table":
        """The table under a key; an empty one if it is not there.

        Raises:
            TableError: It is not a table.
        """
        return self.take(key, lambda name, value: Table(value, name), Table({}, self.key(key)))

    def tables(self, key: str) -> list["Table"]:
        """The tables of an array such as `[[robots]]`; none if it is not there.

        Raises:
            TableError: It is not an array of tables.
        """

        def read(name: str, value: Any) -> list[Table]:
            if not isinstance(value, list):
                raise TableError(f"{name} is {quoted(value)}; allowed: one or more tables [[{name}]]")
            return [Table(item, f"{name}[{i}]") for i, item in enumerate(value)]

        return self.take(key, read, [])

    def finish(self) -> None:
        """Complain about what nobody asked for.

        Raises:
            TableError: An unknown key.
        """
        for key in self._content:
            raise TableError(f"{self.key(key)} is unknown; allowed: {', '.join(sorted(self._asked))}")


def quoted(value: object) -> str:
    """How a message shows what it found, not too long."""
    text = repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def text(key: str, value: Any) -> str:
    """A string that is not empty."""
    if not isinstance(value, str) or not value.strip():
        raise TableError(f"{key} is {quoted(value)}; allowed: a text that is not empty")
    return value


def number(low: float, high: float, unit: str) -> Callable[[str, Any], float]:
    """A number of `low` to `high`."""

    def read(key: str, value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float) or not low <= value <= high:
            raise TableError(f"{key} is {quoted(value)}; allowed: {low:g} to {high:g} {unit}")
        return float(value)

    return read


def one_of(allowed: Sequence[int]) -> Callable[[str, Any], int]:
    """One of a few whole numbers."""

    def read(key: str, value: Any) -> int:
        if type(value) is not int or value not in allowed:
            raise TableError(f"{key} is {quoted(value)}; allowed: {', '.join(map(str, allowed))}")
        return value

    return read


def numbers(form: str) -> Callable[[str, Any], tuple[float, ...]]:
    """As many finite numbers as `form` names, such as `[x mm, y mm]`."""
    count = form.count(",") + 1

    def read(key: str, value: Any) -> tuple[float, ...]:
        if (
            not isinstance(value, list)
            or len(value) != count
            or not all(type(v) in (int, float) and abs(v) < 1e9 for v in value)
        ):
            raise TableError(f"{key} is {quoted(value)}; allowed: {form}")
        return tuple(float(v) for v in value)

    return read


def list_of(read_one: Callable[[str, Any], T]) -> Callable[[str, Any], tuple[T, ...]]:
    """A list whose every item is read the same way."""

    def read(key: str, value: Any) -> tuple[T, ...]:
        if not isinstance(value, list) or not value:
            raise TableError(f"{key} is {quoted(value)}; allowed: a list that is not empty")
        return tuple(read_one(f"{key}[{i}]", item) for i, item in enumerate(value))

    return read
