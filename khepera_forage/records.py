"""Records: a class of plain fields, and the numpy dtype of the same fields for compiled worlds.

A rule that remembers something takes records. In Python these are instances of slotted dataclasses; in compiled code
they are elements of numpy structured arrays, whose fields numba reads and writes by name. Each kind of record is
declared once, as a class, and `dtype_of` derives the dtype.
"""

from dataclasses import astuple, fields, is_dataclass
from types import SimpleNamespace
from typing import Annotated, Any, get_args, get_origin

import numpy as np
from numpy.typing import NDArray

Word = Annotated[int, "64 bits without a sign"]
"""A field with 64 random bits, or the key of random numbers."""
_KINDS: dict[Any, Any] = {float: "f8", int: "i8", bool: "?", Word: "u8"}


def dtype_of(kind: type) -> np.dtype[Any]:
    """The dtype of a record class; its elements have the fields as attributes, in Python too.

    Args:
        kind: A dataclass or a named tuple. Fields that are numbers, flags, records of their own, tuples of numbers of
            one kind, or lists of as many numbers as their default has, become fields of the dtype. Others, such as
            lists of records, are left out: compiled worlds keep them in arrays of their own.
    """
    if is_dataclass(kind):
        known = [(field.name, field.type, _length(field)) for field in fields(kind)]
    else:
        known = [(name, annotation, 0) for name, annotation in kind.__annotations__.items()]
    parts: list[Any] = []
    for name, annotation, length in known:
        if annotation in _KINDS:
            parts.append((name, _KINDS[annotation]))
        elif length:
            parts.append((name, _KINDS[get_args(annotation)[0]], (length,)))
        elif get_origin(annotation) is tuple:
            parts.append((name, _KINDS[get_args(annotation)[0]], (len(get_args(annotation)),)))
        elif isinstance(annotation, type) and (is_dataclass(annotation) or hasattr(annotation, "_fields")):
            inner = dtype_of(annotation)
            if inner.names:
                parts.append((name, inner))
    return np.dtype((np.record, np.dtype(parts, align=True)))


def blank(kind: Any) -> Any:
    """A record in Python with the fields of a named tuple, all 0; a tuple in it becomes a list."""
    lengths = {name: len(get_args(annotation)) for name, annotation in kind.__annotations__.items()}
    return SimpleNamespace(**{name: [0] * length if length else 0 for name, length in lengths.items()})


def columns_of(records: NDArray[Any]) -> Any:
    """The fields of an array of records as attributes: arrays that share its memory; inner records likewise."""
    fields = {name: records[name] for name in records.dtype.names or ()}
    return SimpleNamespace(**{name: columns_of(own) if own.dtype.names else own for name, own in fields.items()})


def in_python(record: Any) -> Any:
    """A record whose fields can be read fast: a copy of numpy's, in Python's numbers; another one as it is."""
    if isinstance(record, np.void):
        return SimpleNamespace(**dict(zip(record.dtype.names or (), record.item(), strict=True)))
    return record


def array_of(record: Any) -> NDArray[Any]:
    """An array of one record, a copy of a dataclass instance of plain fields."""
    return np.array([astuple(record)], dtype_of(type(record)))


def _length(field: Any) -> int:
    """How many numbers the list has that a field holds by default; 0 for other fields."""
    numbers = get_origin(field.type) is list and get_args(field.type)[0] in _KINDS
    return len(field.default_factory()) if numbers else 0
