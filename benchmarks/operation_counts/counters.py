"""Numbers and records that count the operations on them, and substitutes for `math` and `numpy`."""

import math
import operator
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np

ARITHMETIC, COMPARISON, DIVISION, LOAD, STORE = KINDS = (
    "arithmetic",
    "comparisons",
    "roots, divisions",
    "loads",
    "stores",
)


class Account:
    """Numbers of operations by part of a round and kind.

    Attributes:
        part: The present part.
        counts: By part and kind.
    """

    def __init__(self, part: str) -> None:
        self.part = part
        self.counts: Counter[tuple[str, str]] = Counter()

    def add(self, kind: str) -> None:
        """Count one operation in the present part."""
        self.counts[self.part, kind] += 1


ACCOUNT = Account("new episodes, accounting")
"""Operators have no argument for it. The part is that of everything outside the named kernels."""


class Number:
    """A float64, or 64 random bits, whose operators count themselves; numbers made by `int` do not count."""

    __slots__ = ("value",)
    __array_ufunc__ = None  # numpy's scalars leave operators to this class
    __hash__ = None  # type: ignore[assignment]

    def __init__(self, value: Any) -> None:
        self.value = value

    def __float__(self) -> float:
        return float(self.value)

    def __int__(self) -> int:
        return int(self.value)

    __index__ = __int__

    def __bool__(self) -> bool:
        return bool(self.value != 0)


def plain(value: Any) -> Any:
    """The value of a number that counts; any other value stays the same."""
    return value.value if isinstance(value, Number) else value


def counted(kind: str, function: Callable[..., Any]) -> Callable[..., Any]:
    """A function that counts as one operation if one of its arguments counts."""

    def operation(*values: Any) -> Any:
        if not any(isinstance(value, Number) for value in values):
            return function(*values)
        ACCOUNT.add(kind)
        result = function(*(plain(value) for value in values))
        return result if kind == COMPARISON else Number(result)

    return operation


for _name in (
    "add",
    "sub",
    "mul",
    "truediv",
    "floordiv",
    "mod",
    "pow",
    "and",
    "or",
    "xor",
    "lshift",
    "rshift",
):
    _plain = getattr(operator, f"__{_name}__")
    _operation = counted(DIVISION if _name == "truediv" else ARITHMETIC, _plain)
    setattr(Number, f"__{_name}__", _operation)
    setattr(Number, f"__r{_name}__", lambda right, left, operation=_operation: operation(left, right))
for _name in ("lt", "le", "gt", "ge", "eq", "ne"):
    setattr(Number, f"__{_name}__", counted(COMPARISON, getattr(operator, _name)))
for _name, _plain in (
    *(("neg", operator.neg), ("abs", abs), ("round", round)),
    *(("floor", math.floor), ("ceil", math.ceil)),
):
    setattr(Number, f"__{_name}__", counted(ARITHMETIC, _plain))


class Records:
    """Records of a numpy array, with fields as attributes, as compiled code reads and writes them.

    Args:
        array: A structured array, one of its records, or one of their fields.
        counts: Whether loads and stores count; what all worlds share does not count, because it stays in registers.
    """

    def __init__(self, array: Any, counts: bool = True) -> None:
        object.__setattr__(self, "_array", array)
        object.__setattr__(self, "_counts", counts)

    @property
    def shape(self) -> tuple[int, ...]:
        """Of the array."""
        shape: tuple[int, ...] = self._array.shape
        return shape

    def __len__(self) -> int:
        return len(self._array)

    def __getitem__(self, index: Any) -> Any:
        return self._read(self._array[index])

    def __setitem__(self, index: Any, value: Any) -> None:
        self._write(index, value)

    def __getattr__(self, name: str) -> Any:
        return self._read(self._array[name])

    def __setattr__(self, name: str, value: Any) -> None:
        self._write(name, value)

    def _read(self, element: Any) -> Any:
        if isinstance(element, (np.ndarray, np.void)):
            return Records(element, self._counts)
        if not self._counts:
            return element.item()
        ACCOUNT.add(LOAD)
        return Number(element if isinstance(element, np.uint64) else float(element))

    def _write(self, place: Any, value: Any) -> None:
        if self._counts:
            ACCOUNT.add(STORE)
        self._array[place] = plain(value)


class CountingMath:
    """The module `math` for numbers that count."""

    sqrt = staticmethod(counted(DIVISION, math.sqrt))
    copysign = staticmethod(counted(ARITHMETIC, math.copysign))

    def __getattr__(self, name: str) -> Any:
        return getattr(math, name)


class CountingNumpy:
    """The functions of numpy that kernels call, for numbers that count."""

    rint = staticmethod(counted(ARITHMETIC, lambda value: float(np.rint(value))))
    float64 = staticmethod(counted(ARITHMETIC, float))
    uint64 = staticmethod(counted(ARITHMETIC, lambda value: np.uint64(int(value))))

    def __getattr__(self, name: str) -> Any:
        return getattr(np, name)
