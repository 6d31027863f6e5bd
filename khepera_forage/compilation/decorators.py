"""Decorators that compile functions: one place for numba's options.

`entrance` compiles what Python calls. `kernel`, `inline` and `sequence` mark what entrances call.
"""

import gc
from collections.abc import Callable
from typing import Any, TypeVar

import numba
from numba import types as types
from numba.core import event
from numba.extending import overload, register_jitable

from khepera_forage.compilation.cache_key import cache_key
from khepera_forage.compilation.late_optimization import LateOptimization
from khepera_forage.compilation.one_at_a_time import compile_one_at_a_time
from khepera_forage.compilation.private_functions import PrivateFunctions

_F = TypeVar("_F", bound=Callable[..., Any])
_PACKAGE = __name__.partition(".")[0]

# Python's error model checks every division, and loops with checks do not vectorise. Compiled functions receive all
# their arrays and allocate none, so no references need to be counted (`_nrt`).
_OPTIONS: dict[str, Any] = {
    "error_model": "numpy",
    "boundscheck": False,
    "no_cfunc_wrapper": True,
    "_nrt": False,
}
_INNER: Any = {**_OPTIONS, "no_cpython_wrapper": True}
_INNER_INLINE: Any = {**_INNER, "forceinline": True}


def entrance(function: _F) -> _F:
    """A function that Python calls: it releases Python's lock, and its machine code is kept on disk.

    Numba compares the date of one source file, but an entrance contains functions of many files. So its name on disk
    contains a checksum of all of them: machine code of older sources is never used.
    """
    function.__qualname__ = f"{function.__qualname__}_{cache_key(function.__module__):08x}"
    compiled: _F = numba.njit(cache=True, nogil=True, **_OPTIONS)(function)
    compile_one_at_a_time(compiled)
    return compiled


def kernel(function: _F) -> _F:
    """A function that loops over many worlds, compiled once for all its callers."""
    registered: _F = register_jitable(**_INNER)(function)
    return registered


def sequence(function: _F) -> _F:
    """A function that calls kernels one after the other; its statements are copied into the caller.

    Each function call avoided saves seconds of compilation.
    """
    copied: _F = numba.njit(inline="always", nogil=True, **_OPTIONS)(function)
    return copied


def inline(function: _F) -> _F:
    """A function of one world's numbers, compiled into each kernel that calls it."""
    registered: _F = register_jitable(**_INNER_INLINE)(function)
    return registered


def stand_in(function: Callable[..., Any]) -> Callable[[_F], _F]:
    """In compiled code, the decorated function replaces `function`, which has the same arguments.

    Python calls either of them uncompiled, so that a test can compare them.
    """

    def register(substitute: _F) -> _F:
        names = ", ".join(substitute.__code__.co_varnames[: substitute.__code__.co_argcount])
        typing: dict[str, Any] = {}
        exec(f"def typing({names}):\n    return substitute\n", {"substitute": substitute}, typing)
        overload(function, jit_options=_INNER_INLINE, strict=False)(typing["typing"])
        return substitute

    return register


def variant(function: Callable[..., Any], applies: Callable[[Any], bool]) -> Callable[[_F], _F]:
    """In compiled code, the decorated function replaces `function` for some types of the first argument.

    Python always calls `function`.

    Args:
        function: What all other types compile to.
        applies: Whether the decorated function is for this type, one of numba's, of the first argument.
    """

    def register(substitute: _F) -> _F:
        names = ", ".join(substitute.__code__.co_varnames[: substitute.__code__.co_argcount])
        first = names.partition(",")[0]
        typing: dict[str, Any] = {"applies": applies, "substitute": substitute, "function": function}
        exec(f"def typing({names}):\n    return substitute if applies({first}) else function\n", typing)
        overload(function, jit_options=_INNER_INLINE, strict=False)(typing["typing"])
        return substitute

    return register


class _Compilation(event.Listener):
    """What is special about the compilation of this package's functions.

    Functions within an entrance are optimised late (see `late_optimization`) and have no name in its machine code (see
    `private_functions`). And Python looks for unreachable objects
    less often: a compiler makes millions of objects and keeps most of them, and searching them takes an eighth of its
    time.
    """

    _THRESHOLDS = (100_000, 10, 10)

    def __init__(self) -> None:
        self._inner: list[bool] = []
        """Of each function under compilation, outermost first: whether only compiled code calls it."""
        self._usual = gc.get_threshold()
        self._late_optimization = LateOptimization()
        self._private_functions = PrivateFunctions()

    def on_start(self, event: Any) -> None:
        own = event.data["dispatcher"].py_func.__module__.startswith(_PACKAGE)
        if not self._inner:
            if not own:
                return
            self._usual = gc.get_threshold()
            gc.set_threshold(*self._THRESHOLDS)
            self._private_functions.switch(True)
        self._inner.append(own and bool(self._inner))
        self._late_optimization.switch(self._inner[-1])

    def on_end(self, event: Any) -> None:
        if not self._inner:
            return
        self._inner.pop()
        self._late_optimization.switch(bool(self._inner) and self._inner[-1])
        if not self._inner:
            self._private_functions.switch(False)
            gc.set_threshold(*self._usual)


event.register("numba:compile", _Compilation())  # type: ignore[no-untyped-call]
