"""Results of long runs on disk: compressed arrays with a header, one file a chunk, so that a killed run continues."""

import json
import os
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from tokenize import TokenError
from typing import TYPE_CHECKING, Any, TypeVar
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

SUFFIX = ".npz"
"""Of the files."""
_DAMAGED = (
    ValueError,
    KeyError,
    TypeError,
    OSError,
    EOFError,
    RuntimeError,
    BadZipFile,
    TokenError,
    zlib.error,
)
"""What numpy raises for files that are cut off, changed, or of another kind."""
_Arrays = TypeVar("_Arrays", bound=tuple[NDArray[Any], ...])


def write_arrays(path: Path, contents: "DataclassInstance", arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write one chunk; a process that is killed meanwhile leaves no file of that name.

    Args:
        path: Of the file; its folder is created if it does not exist.
        contents: What all chunks of the folder have in common, of values that JSON can store; the header.
        arrays: By name.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f"{path.name}.part")
    with part.open("wb") as file:
        named: dict[str, Any] = dict(arrays)
        np.savez_compressed(file, contents=np.array(_text(contents)), **named)
    os.replace(part, path)


def read_arrays(
    path: Path, contents: "DataclassInstance", names: Sequence[str], what: str
) -> list[NDArray[Any]]:
    """The arrays of one chunk.

    Args:
        path: Of the file.
        contents: The header that it must have.
        names: Of the arrays.
        what: Name of such a chunk, for the error.

    Raises:
        ValueError: The file is damaged, of another kind, or has another header.
    """
    header, arrays = _read(path, names, what)
    wanted = json.loads(_text(contents))
    if header != wanted:
        raise ValueError(
            f"{path}: made with {_difference(header, wanted)}; allowed: the same as in this run, another folder "
            "(--out), or --fresh, which deletes it"
        )
    return arrays


def read_header(path: Path, what: str) -> dict[str, Any]:
    """The header of one chunk.

    Args:
        path: Of the file.
        what: Name of such a chunk, for the error.

    Raises:
        ValueError: The file is damaged, or of another kind.
    """
    header, _ = _read(path, (), what)
    return header if isinstance(header, dict) else {}


def joined(parts: Sequence[_Arrays]) -> _Arrays:
    """Some chunks as one.

    Args:
        parts: Named tuples of arrays; at least one.
    """
    return type(parts[0])(*(np.concatenate(arrays) for arrays in zip(*parts, strict=True)))


def _read(path: Path, names: Sequence[str], what: str) -> tuple[Any, list[NDArray[Any]]]:
    """Header and some arrays of a chunk."""
    try:
        with path.open("rb") as opened, np.load(opened, allow_pickle=False) as file:
            return json.loads(str(file["contents"])), [file[name] for name in names]
    except _DAMAGED as error:
        told = str(error) or type(error).__name__
        raise ValueError(f"{path}: {told}; allowed: {what}; delete the file, or give --out") from None


def _text(contents: "DataclassInstance") -> str:
    return json.dumps(asdict(contents))


def _difference(header: Any, wanted: dict[str, Any]) -> str:
    """Which fields of a header differ, for people."""
    found = header if isinstance(header, dict) else {}
    differing = [
        f"{name} {found[name]!r}" if type(found.get(name)) is int else f"another {name}"
        for name in wanted
        if name not in found or found[name] != wanted[name]
    ]
    return ", ".join(differing) or "fields of another version"
