"""CSV files of rows: each file holds rows of one dataclass; they are written one by one and read strictly.

The columns are the fields of the dataclass, in order. A tuple is one column with its values joined by semicolons; a
bool is 1 or 0. Lines end with a line feed, and no field contains one, so that each line is one row.
"""

import csv
import io
import math
from collections.abc import Iterable, Sequence
from dataclasses import fields
from decimal import InvalidOperation
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, Self, TypeVar, get_args, get_origin, get_type_hints

from khepera_forage.files import replacing, utf8, write_all

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

RowT = TypeVar("RowT", bound="DataclassInstance")


class RowWriter(Generic[RowT]):
    """Appends rows to a CSV file, so that a process that is killed loses at most the row it was writing.

    The first rows replace those of an existing file.

    Args:
        path: The file; its folder is created if needed.
        row_type: The dataclass whose fields are the columns.

    Raises:
        OSError: The file cannot be written; so may `write`. The error names it.
    """

    def __init__(self, path: Path, row_type: type[RowT]) -> None:
        self._types = get_type_hints(row_type)
        self._header = _line(_names(row_type))
        path.parent.mkdir(parents=True, exist_ok=True)
        self._replaces = path.is_file() and path.stat().st_size > 0
        self._file = open(path, "ab", buffering=0)  # noqa: SIM115  closed by close()
        self._path = path
        if not self._replaces:
            try:
                self._write(self._header)
            except OSError:
                self._file.close()
                raise

    def write(self, *rows: RowT) -> None:
        """Append rows, with one write for all of them."""
        data = b"".join(
            _line([_format(name, kind, getattr(row, name)) for name, kind in self._types.items()]) for row in rows
        )
        if not self._replaces:
            self._write(data)
            return
        # As a whole: after an error or a kill the earlier rows are still there.
        self._file.close()
        with replacing(self._path) as partial:
            partial.write_bytes(self._header + data)
        self._file, self._replaces = open(self._path, "ab", buffering=0), False  # noqa: SIM115

    def _write(self, data: bytes) -> None:
        write_all(self._file, data, self._path)

    def close(self) -> None:
        """Close the file; a second call does nothing."""
        self._file.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def write_rows(path: Path, row_type: type[RowT], rows: Iterable[RowT]) -> None:
    """Write a file of rows, and replace an existing one."""
    with RowWriter(path, row_type) as writer:
        writer.write(*rows)


def read_rows(path: Path, row_type: type[RowT]) -> list[RowT]:
    """All complete rows of a file. A last line without a line feed, which a killed process leaves, is ignored.

    Raises:
        ValueError: The header is wrong, a value does not fit its column, or a row contradicts itself or repeats
            another. The message names file and line.
    """
    text = utf8(path.read_bytes()).decode().replace("\r\n", "\n")
    return parse_rows(text, str(path), row_type)


def parse_rows(text: str, source: str, row_type: type[RowT]) -> list[RowT]:
    """The rows of a file's text, as `read_rows`; errors name the source."""
    names, types = _names(row_type), get_type_hints(row_type)
    lines = text.split("\n")[:-1]
    if not lines or _split(lines[0]) != names:
        raise ValueError(f"{source}:1: header is {(lines or [text])[0]!r}; allowed: {','.join(names)!r}")
    rows: list[RowT] = []
    seen: dict[str, int] = {}
    for number, line in enumerate(lines[1:], start=2):
        try:
            values = _split(line)
            if len(values) != len(names):
                raise ValueError(f"{len(values)} values; allowed: {len(names)}")
            if seen.setdefault(line, number) != number:
                raise ValueError(f"the row repeats line {seen[line]}")
            rows.append(row_type(**{n: _parse(n, types[n], v) for n, v in zip(names, values, strict=True)}))
        except ValueError as error:
            raise ValueError(f"{source}:{number}: {error}") from error
    return rows


def _names(row_type: "type[DataclassInstance]") -> list[str]:
    return [field.name for field in fields(row_type)]


def _split(line: str) -> list[str]:
    try:
        return next(csv.reader([line], strict=True), [])
    except csv.Error as error:
        raise ValueError(f"line is {line!r}; allowed: comma-separated values ({error})") from error


def _line(values: Sequence[str]) -> bytes:
    for value in values:
        if "\n" in value or "\r" in value:
            raise ValueError(f"a field is {value!r}; allowed: text of one line")
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerow(values)
    return out.getvalue().encode()


def _format(name: str, kind: Any, value: Any) -> str:
    """A value as text; numpy numbers are written like Python's."""
    if get_origin(kind) is tuple:
        return ";".join(_format(name, get_args(kind)[0], part) for part in value)
    if type(None) in get_args(kind):
        return "" if value is None else _format(name, get_args(kind)[0], value)
    if kind in (int, bool):
        if value != int(value):
            raise ValueError(f"{name} is {value!r}; allowed: a whole number")
        return str(int(value))
    return repr(float(value)) if kind is float else str(value)


def _parse(name: str, kind: Any, text: str) -> Any:
    """The value of a column's text."""
    if get_origin(kind) is tuple:
        return tuple(_parse(name, get_args(kind)[0], part) for part in text.split(";")) if text else ()
    if type(None) in get_args(kind):
        return _parse(name, get_args(kind)[0], text) if text else None
    if kind is str:
        return text
    if kind is bool:
        if text not in ("0", "1"):
            raise ValueError(f"{name} is {text!r}; allowed: 0 or 1")
        return text == "1"
    wanted = "a whole number" if kind is int else "a finite number"
    try:
        value = kind(text)
    except (ValueError, InvalidOperation):
        raise ValueError(f"{name} is {text!r}; allowed: {wanted}") from None
    if not math.isfinite(value) or (kind is int and str(value) != text):
        raise ValueError(f"{name} is {text!r}; allowed: {wanted}")
    return value
