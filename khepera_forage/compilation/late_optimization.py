"""Late optimisation: modules of functions that only compiled code calls are optimised once, inside the entrance.

Numba optimises the module of each function and emits its machine code, and then optimises it again inside every caller.
Python never calls the inner functions of this package. While an entrance is compiled, their modules are therefore only
prepared by the passes over single functions; the optimisation of the entrance covers the rest. This saves a fifth to a
third of the time of the first call. Without the passes over single functions the compiled code is slower.

The methods replaced here are internals of numba. Where one of them does not exist, numba compiles as usual.
"""

from collections.abc import Callable
from typing import Any

from numba.core import codegen

_LIBRARY = getattr(codegen, "CPUCodeLibrary", None)
_CODEGEN = getattr(codegen, "JITCPUCodegen", None)


def _optimize_final_module(library: Any) -> None:
    """Instead of the passes over the module."""


def _finalize_final_module(library: Any) -> None:
    """Instead of emitting machine code: only what a caller's module needs of this one."""
    library._finalize_dynamic_globals()
    library._finalized = True


def _set_env(codegen: Any, name: str, env: Any) -> None:
    """Instead of writing the environment of a function into its machine code, which does not exist."""


_REPLACEMENTS: tuple[tuple[Any, str, Callable[..., None]], ...] = (
    (_LIBRARY, "_optimize_final_module", _optimize_final_module),
    (_LIBRARY, "_finalize_final_module", _finalize_final_module),
    (_CODEGEN, "set_env", _set_env),
)
_REQUIRED = ((_LIBRARY, "_finalize_dynamic_globals"),)


class LateOptimization:
    """Numba's methods, or those for inner functions; used under numba's compiler lock."""

    def __init__(self) -> None:
        self._usual: list[Any] = []

    def switch(self, on: bool) -> None:
        """Replace numba's methods, or restore them."""
        if on and not self._usual and _is_available():
            self._usual = [getattr(owner, name) for owner, name, _ in _REPLACEMENTS]
            for owner, name, replacement in _REPLACEMENTS:
                setattr(owner, name, replacement)
        elif not on and self._usual:
            for (owner, name, _), usual in zip(_REPLACEMENTS, self._usual, strict=True):
                setattr(owner, name, usual)
            self._usual = []


def _is_available() -> bool:
    needed = (*_REQUIRED, *((owner, name) for owner, name, _ in _REPLACEMENTS))
    return all(hasattr(owner, name) for owner, name in needed)
