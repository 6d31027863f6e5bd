"""The same kernels for another number of worlds in a block.

`LANES` is a constant of the source, because only then the compiler knows that rows do not overlap. A block of 128 is
what thousands of worlds want; one world alone would pay for 127 others.
"""

from collections.abc import Callable
from types import CodeType, FunctionType, ModuleType
from typing import Any, TypeVar

from numba.extending import is_jitted

from khepera_forage.compilation.decorators import inline, kernel, sequence

_F = TypeVar("_F", bound=Callable[..., Any])
_NAME = "LANES"
_PACKAGE = __name__.split(".")[0]


def at_width(function: _F, lanes: int) -> _F:
    """A compiled function as if `LANES` had been another number; what it calls and what depends on it, too.

    Args:
        function: Made by one of `compiling`.
        lanes: Worlds in a block.
    """
    twin: _F = _twin(function, lanes, {})
    return twin


def _twin(function: Any, lanes: int, made: dict[Any, Any]) -> Any:
    """A copy with another `LANES`, or the function itself if nothing in it depends on that."""
    if function in made:
        return made[function]
    plain = function.py_func if is_jitted(function) else function
    names = plain.__globals__
    changed: dict[str, Any] = {}
    for name in _names(plain.__code__) & names.keys():
        value = names[name]
        if isinstance(value, ModuleType):
            continue
        if name == _NAME:
            changed[name] = lanes
        elif is_jitted(value) or (isinstance(value, FunctionType) and value.__module__.startswith(_PACKAGE)):
            twin = _twin(value, lanes, made)
            if twin is not value:
                changed[name] = twin
    made[function] = function
    if changed:
        copy = FunctionType(plain.__code__, {**names, **changed}, plain.__name__, plain.__defaults__)
        copy.__qualname__, copy.__module__ = plain.__qualname__, plain.__module__
        made[function] = _compiled_as(function)(copy)
    return made[function]


def _compiled_as(function: Any) -> Callable[[Any], Any]:
    """The decorator of `compiling` that made a function."""
    if not is_jitted(function):
        return inline
    return sequence if function.targetoptions.get("inline") == "always" else kernel


def _names(code: CodeType) -> set[str]:
    """Every name that a function looks up, in the functions within it too."""
    inner = (_names(part) for part in code.co_consts if isinstance(part, CodeType))
    return set(code.co_names).union(*inner)
