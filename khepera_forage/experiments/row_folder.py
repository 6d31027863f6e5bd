"""Rows in a folder: a CSV file a table, written unit by unit, so that a run that was killed can be continued.

Beside the tables stand `units.csv`, the units whose rows are complete, and `settings.csv`, which the rows depend on.
"""

import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from khepera_forage.rollouts.row_files import RowWriter, read_rows, write_rows

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

Tables = Mapping[type[Any], str]
"""Types of rows, and the names of their files without `.csv`."""
RowT = TypeVar("RowT", bound="DataclassInstance")
UNITS, SETTINGS, REORDERED = "units.csv", "settings.csv", "reordered"


@dataclass(frozen=True, slots=True)
class FinishedUnit:
    """A unit whose rows are all in the tables.

    Attributes:
        key: Of the unit.
        rows: Number of rows that it left in each table, in the order of the tables.
    """

    key: str
    rows: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class Setting:
    """Something that rows depend on."""

    name: str
    value: str


class Rows:
    """Rows by their type.

    Args:
        rows: Of any types, in order.
    """

    def __init__(self, rows: Iterable[Any]) -> None:
        self._by_type: dict[type[Any], list[Any]] = {}
        for row in rows:
            self._by_type.setdefault(type(row), []).append(row)

    def of(self, row_type: type[RowT]) -> list[RowT]:
        """All rows of a type."""
        return self._by_type.get(row_type, [])


class RowFolder:
    """The rows of a folder, to be added to; close it to put the rows in order.

    Args:
        folder: Made if it does not exist.
        tables: All types of rows there.
        settings: What the rows depend on. A folder may hold rows with further settings, but none with other values.
        fresh: Delete the rows that are there.

    Raises:
        ValueError: The rows in the folder were made with other settings, or a file is damaged.
    """

    def __init__(
        self, folder: Path, tables: Tables, settings: Mapping[str, str], fresh: bool = False
    ) -> None:
        self._folder, self._tables = folder, dict(tables)
        if fresh:
            for path in (*map(self._path, tables), folder / UNITS, folder / SETTINGS, folder / REORDERED):
                path.unlink(missing_ok=True)
        self._finish_reordering()
        self._check(settings)
        self._parts = self._read()
        self._write_all(self._parts)
        self._writers = {kind: RowWriter(self._path(kind), kind, resume=True) for kind in tables}
        self._finished = RowWriter(folder / UNITS, FinishedUnit, resume=True)

    @property
    def finished(self) -> list[str]:
        """Keys of the units whose rows are complete."""
        return list(self._parts)

    def add(self, key: str, rows: Sequence[Any]) -> None:
        """Write the rows of a unit; a process that is killed meanwhile leaves the unit unfinished."""
        for kind, writer in self._writers.items():
            writer.write(*(row for row in rows if type(row) is kind))
        self._parts[key] = list(rows)
        self._finished.write(self._counted(key, rows))

    def rows(self, keys: Iterable[str]) -> Rows:
        """The rows of some finished units, in the order of the keys."""
        return Rows(row for key in keys for row in self._parts[key])

    def close(self, keys: Sequence[str]) -> None:
        """Put the rows of some units into the order of their keys, behind those of all other units."""
        for writer in (*self._writers.values(), self._finished):
            writer.close()
        others = [key for key in self._parts if key not in set(keys)]
        order = others + [key for key in keys if key in self._parts]
        if order != list(self._parts):
            self._parts = {key: self._parts[key] for key in order}
            self._write_all(self._parts)

    def _path(self, kind: type[Any]) -> Path:
        return self._folder / f"{self._tables[kind]}.csv"

    def _counted(self, key: str, rows: Sequence[Any]) -> FinishedUnit:
        return FinishedUnit(key, tuple(sum(type(row) is kind for row in rows) for kind in self._tables))

    def _check(self, settings: Mapping[str, str]) -> None:
        path = self._folder / SETTINGS
        known: dict[str, str] = {}
        if path.exists():
            known = {setting.name: setting.value for setting in read_rows(path, Setting)}
        elif (self._folder / UNITS).exists():
            raise ValueError(f"{self._folder / UNITS}: rows of unknown settings; allowed: with {SETTINGS}")
        for name, value in settings.items():
            if known.get(name, value) != value:
                raise ValueError(
                    f"{path}: the rows there were made with {name} {known[name]!r}, and this run has {value!r}; "
                    "allowed: the same, another folder (--out), or --fresh, which deletes them"
                )
        write_rows(path, Setting, [Setting(*item) for item in (known | dict(settings)).items()])

    def _read(self) -> dict[str, list[Any]]:
        """The rows of all finished units; rows of a unit that is not finished stand behind them and are left out."""
        path = self._folder / UNITS
        units = read_rows(path, FinishedUnit) if path.exists() else []
        parts: dict[str, list[Any]] = {unit.key: [] for unit in units}
        for number, kind in enumerate(self._tables):
            source = self._path(kind)
            rows = read_rows(source, kind) if source.exists() and units else []
            counted = sum(unit.rows[number] for unit in units)
            if len(rows) < counted:
                raise ValueError(f"{source}: {len(rows)} rows; allowed: the {counted} that {path} counts")
            for unit in units:
                parts[unit.key] += rows[: unit.rows[number]]
                del rows[: unit.rows[number]]
        return parts

    def _write_all(self, parts: Mapping[str, Sequence[Any]]) -> None:
        """Replace all files; a process that is killed meanwhile leaves either all old or all new ones."""
        rows = Rows(row for part in parts.values() for row in part)
        for kind in self._tables:
            write_rows(_new(self._path(kind)), kind, rows.of(kind))
        units = [self._counted(key, part) for key, part in parts.items()]
        write_rows(_new(self._folder / UNITS), FinishedUnit, units)
        (self._folder / REORDERED).touch()
        self._finish_reordering()

    def _finish_reordering(self) -> None:
        if (self._folder / REORDERED).exists():
            for path in (*map(self._path, self._tables), self._folder / UNITS):
                if _new(path).exists():
                    os.replace(_new(path), path)
            (self._folder / REORDERED).unlink()


def finished_units(folder: Path) -> list[str]:
    """Keys of the units whose rows in a folder are complete."""
    path = folder / UNITS
    return [unit.key for unit in read_rows(path, FinishedUnit)] if path.exists() else []


def _new(path: Path) -> Path:
    return path.with_name(path.name + ".new")
