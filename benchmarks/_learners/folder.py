"""A folder of results that a run can be resumed in: rows as they come, and the settings that they were made with."""

import json
import os
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

from _learners.lessons import Compared
from _learners.rows import Batch, Size
from _learners.units import cells
from khepera_forage.rollouts.row_files import RowWriter, read_rows, write_rows

ROWS, SETTINGS = "rows.csv", "settings.json"


def claim(folder: Path, seed: int, size: Size, learners: Mapping[str, str]) -> None:
    """Note down what rows in this folder are made with, or see that it is the same as before.

    Args:
        folder: It is made if it is not there.
        seed: Of the run.
        size: Of the run.
        learners: The settings of each; those of earlier runs stay noted.

    Raises:
        ValueError: The rows there were made with other settings; or there are rows, and no settings.
    """
    path = folder / SETTINGS
    wanted = {"seed": seed, **{name: _plain(value) for name, value in size._asdict().items()}}
    noted: dict[str, str] = {}
    if path.exists():
        found = _read(path)
        noted = found.pop("learners")
        for name, value in wanted.items():
            _same(path, name, found.get(name), value)
        for name in noted.keys() & learners.keys():
            _same(path, name, noted[name], learners[name])
    elif (folder / ROWS).exists():
        raise ValueError(f"{folder / ROWS}: rows of unknown settings; allowed: with {SETTINGS} beside them")
    folder.mkdir(parents=True, exist_ok=True)
    text = json.dumps({**wanted, "learners": {**noted, **learners}}, indent=2, ensure_ascii=False)
    _replace(path, text + "\n")


def kept(folder: Path, size: Size, known: Mapping[str, Compared]) -> list[Batch]:
    """The rows of earlier runs.

    A last line cut short is removed, and so are the rows of a unit that is not whole: it is to be done again.

    Args:
        folder: Its settings are claimed.
        size: Of the run.
        known: All learners that may have rows.

    Raises:
        ValueError: The file of rows is damaged; the message names the line. Or a learner in it is not known.
    """
    path = folder / ROWS
    RowWriter(path, Batch, resume=True).close()
    rows = read_rows(path, Batch)
    found: dict[tuple[str, int], set[tuple[int, str]]] = {}
    for row in rows:
        if row.learner not in known:
            raise ValueError(f"{path}: learner is {row.learner!r}; allowed: {', '.join(known)}")
        found.setdefault(row.key, set()).add((row.amount, row.arena))
    torn = {key for key, there in found.items() if there != cells(known[key[0]], size)}
    if torn:
        rows = [row for row in rows if row.key not in torn]
        rewrite(folder, rows)
    return rows


def rewrite(folder: Path, rows: Collection[Batch]) -> None:
    """Put these rows in place of those there, all at once."""
    whole = folder / f"{ROWS}.new"
    write_rows(whole, Batch, rows)
    os.replace(whole, folder / ROWS)


def in_order(rows: Collection[Batch], names: Sequence[str]) -> list[Batch]:
    """Rows in one order, in whatever order their units were done."""
    place = {name: i for i, name in enumerate(names)}
    return sorted(rows, key=lambda row: (place[row.learner], row.replication, row.amount, row.arena))


def _plain(value: int | tuple[int, ...]) -> int | list[int]:
    return value if isinstance(value, int) else list(value)


def _read(path: Path) -> dict[str, Any]:
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
    if not isinstance(found, dict) or not isinstance(found.get("learners"), dict):
        raise ValueError(f"{path}: allowed: what a run of this benchmark wrote, with its learners")
    return found


def _same(path: Path, name: str, found: object, wanted: object) -> None:
    if found != wanted:
        raise ValueError(
            f"{path}: the rows there were made with {name} {found!r}, and this run has {wanted!r}; "
            "allowed: the same, or another folder (--out)"
        )


def _replace(path: Path, text: str) -> None:
    new = path.with_name(path.name + ".new")
    new.write_text(text, encoding="utf-8")
    os.replace(new, path)
