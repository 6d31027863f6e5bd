"""How the batch is compiled: one place for numba's options."""

from collections.abc import Callable
from typing import Any, TypeVar

import numba
from numba.extending import overload, register_jitable

from khepera_forage.worlds.batch.sources import SOURCES

_F = TypeVar("_F", bound=Callable[..., Any])

# The Python error model checks every division, which keeps loops from being vectorised.
_OPTIONS: dict[str, Any] = {
    "error_model": "numpy",
    "boundscheck": False,
    "nogil": True,
    "no_cfunc_wrapper": True,
}
# What compiled code alone calls needs no entrances from Python and C, which take a tenth of the time to compile.
_INLINE: Any = {"forceinline": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}


def entrance(function: _F) -> _F:
    """A kernel that Python calls, without its lock; what is compiled is kept on disk.

    Numba looks at the date of the one file that a kernel is written in. These are made of functions from many files, so
    the name under which one is kept changes with all of them: none that is out of date is used, or even read.
    """
    function.__qualname__ = f"{function.__qualname__}_{SOURCES:08x}"
    options: dict[str, Any] = {"error_model": "numpy", "boundscheck": False, "nogil": True, "cache": True}
    compiled: _F = numba.njit(**options)(function)
    return compiled


def kernel(function: _F) -> _F:
    """A function that loops over many worlds, compiled when it is first called by compiled code."""
    compiled: _F = numba.njit(**_OPTIONS)(function)
    return compiled


def sequence(function: _F) -> _F:
    """A function that calls kernels one after the other, written out where it is called.

    Numba optimises a compiled function anew inside everything that calls it: a call less is some seconds less.
    """
    written_out: _F = numba.njit(inline="always", **_OPTIONS)(function)
    return written_out


def inline(function: _F) -> _F:
    """A function of one world's numbers, compiled into whatever kernel calls it; plain Python otherwise."""
    registered: _F = register_jitable(**_INLINE)(function)
    return registered


def stand_in(function: Callable[..., Any]) -> Callable[[_F], _F]:
    """In compiled code the decorated function takes the place of `function`, of the same arguments.

    Both stay what they are in plain Python, so that a test can compare them.
    """

    def register(substitute: _F) -> _F:
        names = ", ".join(substitute.__code__.co_varnames[: substitute.__code__.co_argcount])
        typing: dict[str, Any] = {}
        exec(f"def typing({names}):\n    return substitute\n", {"substitute": substitute}, typing)
        overload(function, jit_options=_INLINE, strict=False)(typing["typing"])
        return substitute

    return register
