"""How the batch is compiled: one place for numba's options."""

import gc
from collections.abc import Callable
from typing import Any, TypeVar

import numba
from numba.core import event
from numba.extending import overload, register_jitable

from khepera_forage.compilation.cache_key import cache_key

_F = TypeVar("_F", bound=Callable[..., Any])
_PACKAGE = __name__.partition(".")[0]

# The Python error model checks every division, which keeps loops from being vectorised. Kernels work on the arrays they
# are given and make none: to count who refers to them takes time, to compile and to run.
_OPTIONS: dict[str, Any] = {
    "error_model": "numpy",
    "boundscheck": False,
    "nogil": True,
    "no_cfunc_wrapper": True,
    "_nrt": False,
}
# What compiled code alone calls needs no entrance from Python either.
_INLINE: Any = {"forceinline": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True, "_nrt": False}


def entrance(function: _F) -> _F:
    """A kernel that Python calls, without its lock; what is compiled is kept on disk.

    Numba looks at the date of the one file that a kernel is written in. These are made of functions from many files, so
    the name under which one is kept changes with all of them: none that is out of date is used, or even read.
    """
    function.__qualname__ = f"{function.__qualname__}_{cache_key(function.__module__):08x}"
    compiled: _F = numba.njit(cache=True, **_OPTIONS)(function)
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


class _SeldomCollecting(event.Listener):
    """While numba compiles the functions of this package, Python looks for unreachable objects less often.

    A compiler makes objects by the million and keeps most of them: to look through them all again and again takes an
    eighth of its time.
    """

    _THRESHOLDS = (100_000, 10, 10)

    def __init__(self) -> None:
        self._depth = 0
        self._usual = gc.get_threshold()

    def on_start(self, event: Any) -> None:
        if self._depth == 0:
            if not event.data["dispatcher"].py_func.__module__.startswith(_PACKAGE):
                return
            self._usual = gc.get_threshold()
            gc.set_threshold(*self._THRESHOLDS)
        self._depth += 1

    def on_end(self, event: Any) -> None:
        if self._depth == 0:
            return
        self._depth -= 1
        if self._depth == 0:
            gc.set_threshold(*self._usual)


event.register("numba:compile", _SeldomCollecting())  # type: ignore[no-untyped-call]
