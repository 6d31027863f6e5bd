"""Numbers and rows that count what is done with them, and what stands for `math` and `numpy` beside them."""

import math
import operator
from collections import Counter
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

ARITHMETIC, COMPARISON, DIVISION, LOAD, STORE = KINDS = (
    "arithmetic",
    "comparisons",
    "roots, divisions",
    "loads",
    "stores",
)


class Account:
    """How often each kind of operation was done in each part of a round.

    Attributes:
        part: The part that is under way.
        counts: By part and kind.
    """

    def __init__(self, part: str) -> None:
        self.part = part
        self.counts: Counter[tuple[str, str]] = Counter()

    def add(self, kind: str) -> None:
        """Count one operation in the part that is under way."""
        self.counts[self.part, kind] += 1


ACCOUNT = Account("new episodes, account")
"""Operators have no argument for it; the part is where everything belongs that no kernel does."""


class Number:
    """A float64, or 64 random bits, whose operators count themselves. What `int` makes of it counts no more."""

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
    """A number without its account."""
    return value.value if isinstance(value, Number) else value


def counted(kind: str, function: Callable[..., Any]) -> Callable[..., Any]:
    """A function of plain numbers as one operation on those that count; plain if none of its arguments counts."""

    def operation(*values: Any) -> Any:
        if not any(isinstance(value, Number) for value in values):
            return function(*values)
        ACCOUNT.add(kind)
        result = function(*(plain(value) for value in values))
        return result if kind == COMPARISON else Number(result)

    return operation


for _name in ("add", "sub", "mul", "truediv", "floordiv", "mod", "pow", "and", "xor", "rshift"):
    _plain = getattr(operator, f"__{_name}__")
    _operation = counted(DIVISION if _name == "truediv" else ARITHMETIC, _plain)
    setattr(Number, f"__{_name}__", _operation)
    setattr(Number, f"__r{_name}__", lambda right, left, operation=_operation: operation(left, right))
for _name in ("lt", "le", "gt", "ge", "eq", "ne"):
    setattr(Number, f"__{_name}__", counted(COMPARISON, getattr(operator, _name)))
for _name, _plain in (
    *(("neg", operator.neg), ("abs", abs)),
    *(("floor", math.floor), ("ceil", math.ceil)),
):
    setattr(Number, f"__{_name}__", counted(ARITHMETIC, _plain))


class Rows:
    """An array whose elements are read and written one by one, and counted; a slice is as yet no load."""

    def __init__(self, array: NDArray[Any]) -> None:
        self.array = array
        self.shape = array.shape

    def __getitem__(self, index: Any) -> Any:
        element = self.array[index]
        if isinstance(element, np.ndarray):
            return Rows(element)
        ACCOUNT.add(LOAD)
        return Number(element if isinstance(element, np.uint64) else float(element))

    def __setitem__(self, index: Any, value: Any) -> None:
        ACCOUNT.add(STORE)
        self.array[index] = plain(value)


class CountingMath:
    """The module `math` for numbers that count."""

    sqrt = staticmethod(counted(DIVISION, math.sqrt))
    copysign = staticmethod(counted(ARITHMETIC, math.copysign))

    def __getattr__(self, name: str) -> Any:
        return getattr(math, name)


class CountingNumpy:
    """What kernels use of numpy, for numbers that count."""

    rint = staticmethod(counted(ARITHMETIC, lambda value: float(np.rint(value))))
    float64 = staticmethod(counted(ARITHMETIC, float))

    @staticmethod
    def zeros(shape: Any, kind: Any = np.float64) -> Rows:
        """Room for what a block keeps beside its worlds."""
        return Rows(np.zeros(shape, kind))

    def __getattr__(self, name: str) -> Any:
        return getattr(np, name)
